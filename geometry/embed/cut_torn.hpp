#pragma once

// A mesh cut along the links that its cubes have lost, so that a tear opens without a gap.
//
//      +---:---+          +---+   +---+       A face of the mesh, ~, runs across a parted cube. It
//      |   :   |          |   |   |   |       is cut along the plane between the parts, dotted,
//      |~~~o~~~|    ->    |~~~o   o~~~|       and each side moves with its own part: the new
//      |   :   |          |   |   |   |       vertex o becomes two as soon as the parts are apart.
//      +---:---+          +---+   +---+
//
// Which octants of a cube stay together is in parted_cubes.hpp, how its parts move in
// part_motion.hpp, and the cut itself in cut_faces.hpp.
//
// Where the mesh is a solid, new faces close it along those planes (cut_caps.hpp).

#include "geometry/embed/embed.hpp"
#include "geometry/embed/parted_cubes.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <optional>

namespace geometry {

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
