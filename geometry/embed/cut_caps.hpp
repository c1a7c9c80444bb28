#pragma once

// What closes a solid where its cubes have parted: the planes between their parts, as far as those
// lie inside the mesh.
//
// Each plane of a cube is cut along all edges that the mesh has in it. Its pieces lie inside or
// outside as a whole, which the winding number at one point of each tells: so broken meshes are
// closed as well as they are closed themselves, and sheets are not.

#include "geometry/embed/parted_cubes.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

namespace geometry {

// Where a face crosses the plane across `axis` through the middle of a parted cube. Lattice
// coordinates.
struct CutEdge {
    std::uint32_t parted;
    int axis;
    Vec3 from, to;
};

// A convex face, counter-clockwise seen from outside.
struct Cap {
    std::uint32_t part;         // 8 * parted cube + part
    Vec3 outward;               // unit, along an axis
    std::vector<Vec3> corners;  // lattice coordinates
};

// Winding numbers just below and above a place, along an axis. Lattice coordinates; `mesh` is at
// rest, m.
std::array<double, 2> winding_beside(const Cubes& cubes, const TriangleBvh& mesh, const Vec3& at,
                                     int axis);

// Of each part of `parted`, in their order. `mesh` is at rest, m.
std::vector<Cap> find_caps(const Cubes& cubes, std::span<const PartedCube> parted,
                           std::vector<CutEdge> edges, const TriangleBvh& mesh);

}  // namespace geometry
