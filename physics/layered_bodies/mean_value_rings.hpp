#pragma once

// Where each vertex of a mesh is among its neighbours: its mean value coordinates.
//
//        p1----p0        In the plane square to its normal vertex v is sum w_i p_i, sum w_i = 1;
//       /  \  /  \       it is off that plane's point by -offset. A triangle's corner of angle a,
//     p2----v----p5      between the edges to p and q, adds tan(a / 2) / length to both.
//       \  /  \  /
//        p3----p4
//
//   Floater. Mean value coordinates. Computer Aided Geometric Design 20(1), 2003.

#include "geometry/mesh/mesh_fwd.hpp"

#include <vector>

namespace physics {

// Neighbours of vertex v: ring[ring_at[v] .. ring_at[v + 1]), and the weight of each.
struct MeanValueRings {
    std::vector<std::uint32_t> ring_at;  // V + 1
    std::vector<std::uint32_t> ring;
    std::vector<float> weight;            // one a neighbour
    std::vector<geometry::Vec3f> offset;  // V, m
    double edge = 0;                      // m, of mean length; 0 where there is none
};

// Vertices on a rim or where sheets meet are left without, as are those that lie outside theirs.
MeanValueRings mean_value_rings(const geometry::TriMesh& mesh);

}  // namespace physics
