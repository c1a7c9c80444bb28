#pragma once

// A field as a mesher sees it: where its surface may be, and what it is worth at points.
// Two kinds exist: an undeformed layer (below) and one that contacts deform
// (physics/layers/deformed_layer.hpp).

#include "geometry/fields/field.hpp"
#include "geometry/fields/field_block.hpp"

#include <functional>

namespace geometry {

// Solid where the value, isovalue taken off, is >= 0. Called from many threads at once. Values must
// not depend on which other points are asked.
struct IsoField {
    Box domain;                                                // m, holds all of the surface
    std::function<Interval(const Box&)> bounds;                // over a box
    std::function<void(const FieldBlock&, BlockValues&)> ask;  // value and gradient, padded blocks
    // 1/m: the gradient's length over a box is no more; infinite, or null: not known. For rays.
    std::function<double(const Box&)> slope = nullptr;
};

// `field` must outlive the result. The domain is where the field is not 0; a plane alone has none.
IsoField iso_field(const Field& field);

}  // namespace geometry
