#pragma once

// Points spread inside a mesh.

#include "geometry/cells/solid_cells.hpp"
#include "geometry/cubes/sample_surface.hpp"

namespace geometry {

// `count` points spread evenly inside the mesh: one at random in each cell of a grid whose cells
// have volume / count, those kept that are inside; see Inside for when a point is. Each is of
// the matter of the smallest closed part that it lies in, else of the face nearest to it (see
// matter_at()). SampleMass: total, or density (mass = volume x density); a surface density
// means nothing here and is an std::invalid_argument, as is a mesh without an inside.
Samples sample_volume(const TriMesh& mesh, const FaceMatter& matter, Inside rule, std::size_t count,
                      std::uint64_t seed, const SampleMass& mass = {});

// m^3, by the cells and shares of a grid of so many cells along the longest side.
double volume_inside(const TriMesh& mesh, Inside rule, int resolution = 64);

}  // namespace geometry
