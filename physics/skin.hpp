#pragma once

// Where the world touches a body of cubes: contact points and bits of area, embedded in the cubes
// with trilinear weights. They are the vertices and triangles of the original surface, or the
// outside corners and faces of the cubes themselves.

#include "geometry/cubes.hpp"
#include "geometry/mesh.hpp"

#include <array>
#include <vector>

namespace physics {

using geometry::Vec3;
using geometry::Vec3f;

// Grouped by the cubes that hold them.
struct Skin {
    std::vector<std::array<std::uint32_t, 8>> corners;  // S, slots of the cube's corners
    std::vector<std::array<float, 8>> share;            // S, of what the wind does to each corner
    std::vector<float> stiffness;                       // S, Pa, Young's modulus times fill
    std::vector<float> mass;                            // S, kg, of the cube

    std::vector<std::uint32_t> point_at;  // S + 1, into point
    std::vector<Vec3f> point;             // P, place in the cube, 0..1 inside
    std::vector<float> point_area;        // P, m^2, of the surface around it

    std::vector<std::uint32_t> area_at;  // S + 1, into area
    std::vector<Vec3f> area;             // m^2, normal times area at rest; either side may be out
};

// The trilinear weights of a place in the unit cube, corner a at (a & 1, a >> 1 & 1, a >> 2 & 1).
inline std::array<double, 8> trilinear_weights(const Vec3& place)
{
    std::array<double, 8> w;
    for (unsigned a = 0; a < 8; ++a) {
        w[a] = ((a & 1) ? place.x() : 1 - place.x()) * ((a & 2) ? place.y() : 1 - place.y()) *
               ((a & 4) ? place.z() : 1 - place.z());
    }
    return w;
}

// `slot` of each corner is what Skin::corners holds. A null surface: the outside of the cubes. Of
// vertices crowded into one place, a quarter of a cube wide, the one farthest out stands for all.
Skin make_skin(const geometry::Cubes& cubes, const std::vector<std::uint32_t>& slot,
               const geometry::TriMesh* surface);

}  // namespace physics
