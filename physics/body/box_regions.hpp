#pragma once

// Many boxes, and whether one of them meets another box.

#include "geometry/base/box_tree.hpp"

#include <span>

namespace physics {

inline bool overlap(const geometry::Box& a, const geometry::Box& b)
{
    return (a.lo.array() <= b.hi.array()).all() && (b.lo.array() <= a.hi.array()).all();
}

// Keeps a view of the boxes.
class BoxRegions {
public:
    explicit BoxRegions(std::span<const geometry::Box> boxes);
    bool meet(const geometry::Box& box) const;

private:
    std::span<const geometry::Box> boxes_;
    geometry::BoxTree tree_;  // empty: of few, or of some that are not finite
};

}  // namespace physics
