#pragma once

// What the inside of a solid is made of, where there are several matters: that of the closed parts
// (closed_parts.hpp) that a place lies in, else of the faces near it. For cubes and for points.

#include "geometry/cells/inside.hpp"
#include "geometry/cells/voxel_grid.hpp"
#include "geometry/cubes/assign_matter.hpp"
#include "geometry/cubes/fill_cubes.hpp"

namespace geometry {

// What of a face lies in a cube.
struct FaceInCube {
    std::uint32_t cube, triangle;  // triangle of the lattice mesh
    double area;                   // m^2
};

struct Solid {
    const TriMesh& mesh;
    const LatticeMesh& lattice;
    const FaceMatter& matter;
    Inside rule;
    double thickness;  // m, of faces that close nothing
};

// Deposits that add up to `volume` (m^3) in each cube. A point of a closed part is of the matter of
// that part, or of the smallest that it lies in. A part of several matters has that of its faces in
// the cube, by area, or of its face nearest to the cube. So have cubes in no closed part; faces
// that close nothing fill their thickness of the cubes that they lie in, and all of those where
// there is none.
std::vector<Deposit> matter_of_solid(const Solid& solid, const Cubes& cubes,
                                     const std::vector<FaceInCube>& faces,
                                     std::span<const double> volume);

// Of each point: the matter of the smallest closed part that it lies in; in a part of several
// matters, of that part's face nearest to it; in no part, of the nearest of all faces.
std::vector<std::uint16_t> matter_at(const Solid& solid, std::span<const Vec3> points);

}  // namespace geometry
