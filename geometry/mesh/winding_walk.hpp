#pragma once

// Whether places are inside of a closed mesh, for many that lie near each other: the winding number
// of each follows from that of the one before, by what the way from there crosses.

#include "geometry/mesh/triangle_bvh.hpp"

namespace geometry {

class WindingWalk {
public:
    // Ways longer than `far` (m) are not walked. The tree must outlive it, and be of a closed mesh:
    // of an open one the winding number changes along the way too.
    WindingWalk(const TriangleBvh& tree, double far) : tree_(tree), far_(far) {}

    // As tree.inside(p).
    bool inside(const Vec3& p);

private:
    const TriangleBvh& tree_;
    double far_;
    Vec3 last_ = Vec3::Zero();
    std::optional<int> winding_;  // of `last_`; none where it is no whole number
};

}  // namespace geometry
