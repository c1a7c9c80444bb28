#pragma once

// Makes the surface that a pressure acts on (state/pressed_surface.hpp) of a mesh in cubes.
//
// Faces are cut at the middles of their sides until no side is longer than half a cube, so that
// every cube that the surface passes through feels its share. On a sheet they are cut until no side
// is longer than the longest of its cells. Faces that meet keep meeting: a closed mesh makes a
// closed surface, which neither pushes nor turns a body as a whole.
//
// Which way is out, the mesh's winding says, mended as in geometry/mesh/wound_out.hpp; of a closed
// piece within another the cubes say whether it is a hollow.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/state/pressed_surface.hpp"

#include <string>

namespace physics {

struct PressOn {
    PressedSurface surface;
    std::size_t turned = 0;   // faces of the mesh
    std::size_t one_way = 0;  // edges with two faces that no turning of faces reconciles
    double farthest = 0;      // m, of a node from the cube that carries it
};

// Of all faces, or those of the material or group `name` where it is not empty. Throws
// std::invalid_argument when there are none, when the cubes are a plane, or when the faces would
// have to be cut into more than 20 million.
PressOn press_on(const geometry::Cubes& cubes, const geometry::TriMesh& mesh,
                 const std::string& name);

}  // namespace physics
