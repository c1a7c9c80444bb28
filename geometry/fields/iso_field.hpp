#pragma once

// A field as a mesher sees it: where its surface may be, and what it is worth at points.
// Two kinds exist: an undeformed layer (below) and one that contacts deform
// (physics/layers/deformed_layer.hpp).

#include "geometry/fields/field.hpp"
#include "geometry/fields/field_block.hpp"

#include <functional>

namespace geometry {

// In a box the value grows over a distance s by no more than slope * s + leap.
struct Steepness {
    double slope = 0;  // 1/m
    double leap = 0;   // above 0 where the value may jump, or rise steeply
};

// Solid where the value, isovalue taken off, is >= 0. Called from many threads at once. Values must
// not depend on which other points are asked.
struct IsoField {
    Box domain;                                                // m, holds all of the surface
    std::function<Interval(const Box&)> bounds;                // over a box
    std::function<void(const FieldBlock&, BlockValues&)> ask;  // value and gradient, padded blocks
    std::function<Steepness(const Box&)> steepness = nullptr;  // over a box; null: not known
};

// `field` must outlive the result. The domain is where the field is not 0; a plane alone has none.
IsoField iso_field(const Field& field);

}  // namespace geometry
