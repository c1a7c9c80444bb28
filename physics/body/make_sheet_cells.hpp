#pragma once

// Makes what sheets need to know of themselves to touch (sheet_cells.hpp).

#include "physics/body/corner_body.hpp"
#include "physics/body/part_shapes.hpp"

#include <memory>

namespace physics {

// Of planes, which `body` is made of. Null where contact is off, or a lone plane does not touch
// itself.
std::shared_ptr<const SheetCells> sheets_that_touch(const BodyModels& models,
                                                    const CornerBody& body,
                                                    const PartContactOptions& options);

// The same whether or not sheets touch.
std::shared_ptr<const SheetCells> make_sheet_cells(const BodyModels& models, const CornerBody& body,
                                                   const PartContactOptions& options);

}  // namespace physics
