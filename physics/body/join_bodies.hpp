#pragma once

// Solids and sheets as one body, to be stepped together.

#include "physics/body/corner_body.hpp"
#include "physics/body/solids_beside_sheets.hpp"

#include <span>
#include <vector>

namespace physics {

// Of each of several models: whether it is a sheet, and how many corners it has.
struct JoinedModel {
    bool sheet = false;
    std::size_t corners = 0;
};

// A body whose slots are those of the solids, and behind them those of the sheets. Its corners are
// those of the models in their order, which solids and sheets have among themselves. `touching` is
// of the solids, with the sheets' own cells; null where the two do not touch.
CornerBody join_bodies(const CornerBody& solids, const CornerBody& sheets,
                       std::span<const JoinedModel> models,
                       std::unique_ptr<SolidsBesideSheets> touching);

}  // namespace physics
