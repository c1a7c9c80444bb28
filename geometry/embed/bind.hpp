#pragma once

// Which cube carries each vertex of a mesh, and where in that cube the vertex lies at rest.
//
//      +-----+-----+
//      |  .a |     |    a  lies in a cube: its place there is 0..1 along each axis
//      +-----+-----+
//      |     |q . . . b b  lies in none: it goes with the nearest cube, by the affine map at the
//      +-----+-----+       anchor q, the cube's point nearest to it
//
// Where a whole piece of the mesh is in no cube, q is the centre of one cube for all of it, so that
// it stays in one piece, and turns and shears as that cube does. On a plane (cubes/plane.hpp) who
// lies over or under a cell is in it, however far. Of several cubes in one cell, a vertex goes with
// the piece of material that it is nearest to (Cubes::part), and where bodies meet with the body
// that its piece of the mesh goes with (cubes/body_finder.hpp). Up to a cube outside of that body
// it is a stray of it, in the cubes of another too: these may go elsewhere. Farther out it goes
// with the other, as a skin over several bodies does.
//
// On a sheet (cubes/sheet.hpp) a vertex goes with the nearest triangle, at that one's nearest
// place: none is a stray, and none lies across.

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <string>

namespace geometry {

struct Binding {
    struct Stray {
        std::uint32_t vertex = 0;
        Vec3f anchor = Vec3f::Zero();  // in its cube, 0..1
    };

    std::vector<std::uint32_t> used;           // cubes that carry vertices, ascending
    std::vector<std::uint32_t> cube;           // V, into used
    std::vector<Vec3f> local;                  // V, place in the cube, 0..1 but for strays
                                               // and across a plane
    std::vector<std::uint32_t> normal_vertex;  // N, whose each normal is; no_index: of none
    bool one_normal_each = false;              // normal v is vertex v's, for all of both
    std::vector<Stray> strays;                 // vertices in no cube of their body, ascending
    std::vector<std::uint32_t> stray_normals;  // normals of strays
    double farthest = 0;                       // m, from a stray to its cube, or a vertex to
                                               // its triangle
};

// Where each vertex of the rest mesh lies in the rest cubes. A vertex within a thousandth of a cube
// counts as inside; one that is not finite is bound to the first cube's origin.
// Without `by_pieces`, each vertex goes with the nearest material, whatever its piece goes with.
// Throws std::invalid_argument when there are vertices but no cubes.
Binding bind(const TriMesh& mesh, const Cubes& cubes, bool by_pieces = true);

// The vertex's entry in binding.strays; null when it lies in a cube.
const Binding::Stray* find_stray(const Binding& binding, std::uint32_t vertex);

// What to warn of where vertices lie in no cube; empty where there are none.
std::string warning_of_strays(const Binding& binding);

}  // namespace geometry
