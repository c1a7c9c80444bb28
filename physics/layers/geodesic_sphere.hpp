#pragma once

// Directions spread evenly over the sphere, and the solid angle that each stands for.
//
//     o---o---o     Each of an icosahedron's 20 faces is cut into n^2 triangles (here n = 2),
//      \ / \ /      whose corners (o) are pushed out onto the sphere: 10 n^2 + 2 directions.
//       o---o
//        \ /
//         o

#include "geometry/base/vec.hpp"

#include <vector>

namespace physics {

struct GeodesicSphere {
    std::vector<geometry::Vec3> points;     // unit
    std::vector<geometry::Triangle> faces;  // outward
};

GeodesicSphere geodesic_sphere(int n);

// What a face of unit vectors gives each of its corners and of the vertices across its edges, so
// that sums over all faces integrate smooth functions over the sphere with order 3 to 4. Seen from
// the middle of the sphere, in the plane that touches it at the middle of the face, a function of
// direction is taken as the quadratic through its six values; x there stands for solid angle d^2x /
// (1 + |x|^2)^(3/2). (A third of the solid angle for each corner has order 2.)
Eigen::Matrix<double, 6, 1> solid_angles(const std::array<geometry::Vec3, 6>& points);

}  // namespace physics
