#pragma once

// A mesh cut along the links that its cubes have lost, so that a tear opens without a gap.
//
// Each corner of a cube stands for the octant of the cube around it. Where the links that a cube
// has left no longer join all of its corners, it is in parts: the octants of those that are still
// joined. The mesh is cut along the planes between parts. A part moves as the cube would that has
// its corners, and in place of the others virtual ones, as far from its own as the links of those
// point.
// After Molino, Bao, Fedkiw. A virtual node algorithm for changing mesh topology during simulation.
// SIGGRAPH 2004.
//
// Where the mesh is a solid, new faces close it along those planes (cut_caps.hpp).

#include "geometry/embed.hpp"
#include "geometry/mesh.hpp"
#include "geometry/triangle_bvh.hpp"

#include <optional>
#include <span>

namespace geometry {

// A cube in parts: the part of each corner, numbered from 0.
struct PartedCube {
    std::uint32_t cube;
    std::array<std::uint8_t, 8> part;
    std::uint8_t parts;
};

// Those whose corners are no longer all joined, in their order; of cubes that share a cell, only
// the first can be one, as meshes are bound to that. Links are named 3 * corner + axis, ascending,
// by the lower of their corners.
std::vector<PartedCube> find_parted(const Cubes& cubes, std::span<const std::uint32_t> broken);

// Which cubes those are. C.
std::vector<std::uint8_t> marked(const Cubes& cubes, std::span<const PartedCube> parted);

// What closes a solid where it is cut.
struct Closing {
    const TriangleBvh* solid = nullptr;  // the mesh at rest; null: it stays open, as planes do
    std::optional<Material> material;    // of the faces; else each has that of what is nearest
};

// `carried` is what embed() makes of `rest` with corners at x (K, m), and `parted` what
// find_parted() says of the same `broken`. Faces that pass through those cubes are cut there, and
// vertices in them go with the part that they are in; new vertices, normals and texture coordinates
// come after the others. What is cut is closed where it is inside the solid, by faces of the group
// "inside", after all others, whose vertices have the numbers of what is nearest to them of the
// mesh. Where that has texture coordinates, so have they: with a material of their own, their
// places along the plane, m.
TriMesh cut_torn(const Binding& binding, const TriMesh& rest, TriMesh carried, const Cubes& cubes,
                 std::span<const Vec3> x, std::span<const std::uint32_t> broken,
                 std::span<const PartedCube> parted, const Closing& closing = {});

}  // namespace geometry
