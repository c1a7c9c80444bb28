#pragma once

// Where the points of parts' shapes are while a step looks for contact.

#include "physics/body/part_shapes.hpp"

#include <vector>

namespace physics {

struct PointNow {
    geometry::Vec3 p = geometry::Vec3::Zero(), v = geometry::Vec3::Zero();  // m, m/s
};

// A cube with points: a box around them, their mean velocity, and how far theirs are from that.
struct HolderNow {
    geometry::Box box;                                 // m
    geometry::Vec3 velocity = geometry::Vec3::Zero();  // m/s
    double spread = 0;                                 // m/s
};

struct PointsNow {
    std::vector<PointNow> point;    // as PartShapes::point
    std::vector<HolderNow> holder;  // H
};

// Of the parts of some pairs; those of others stay empty. x and v are by slot, four numbers each.
PointsNow points_now(const PartShapes& shapes, const std::vector<PartPair>& pairs, const double* x,
                     const double* v);

}  // namespace physics
