#pragma once

// Solids that are round about their own y: torus, cylinder and cone. Distances are taken in the
// half plane (rho, y), rho the distance from the axis; all are exact.
//
//     y                     y  half.z              half_size of a skeleton
//     |    .-.              |---.                    torus     x: outer radius, y: radius of its
//     tube
//   --+---(-x-)-- rho       |    \   half.y          cylinder  x: radius, y: half its height
//     |    `-'              +-----\---- rho          cone      x: radius of its base, y: half its
//     |  half.y             |      \                           height, z: radius of its top
//     |<-half.x->|          '-------' half.x

#include "geometry/fields/field_skeleton.hpp"

namespace geometry {

struct RoundShape {
    double ring = 0, tube = 0;             // m, torus: its circle's radius and the tube's
    double base = 0, top = 0, height = 0;  // m, cone: radii at y = -height and y = height
};

inline bool is_round(SkeletonKind kind)
{
    return kind == SkeletonKind::torus || kind == SkeletonKind::cylinder ||
           kind == SkeletonKind::cone;
}

RoundShape round_shape(SkeletonKind kind, const Vec3& half_size);

// Half the box of a solid in its own frame, for every kind that has a half_size.
Vec3 half_extent(SkeletonKind kind, const Vec3& half_size);

Foot foot_on_torus(const RoundShape& shape, const Vec3& p);  // about y
Foot foot_on_cone(const RoundShape& shape, const Vec3& p);   // about y; a cylinder also

}  // namespace geometry
