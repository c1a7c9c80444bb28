#pragma once

// How far a field's surface reaches along each axis: where rays that come along the axes, a quarter
// of a cell apart and then closer around the first that is met, meet it.

#include "geometry/fields/iso_cells.hpp"

namespace geometry {

// The surface's box, to about a hundred-thousandth of a cell where the surface is round. What is
// narrower than a quarter of a cell may stand out of it. Empty where there is none.
Box surface_box(const IsoField& field, const IsoCells& cells);

}  // namespace geometry
