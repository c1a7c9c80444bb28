#pragma once

// Any geometry to cubes, three ways to one result.
// James, Barbic, Twigg. Squashing cubes: automating deformable model construction for graphics.
// SIGGRAPH 2004 sketches.

#include "geometry/cells/solid_cells.hpp"
#include "geometry/cubes/assign_matter.hpp"
#include "geometry/cubes/cubes.hpp"
#include "geometry/cubes/fill_cubes.hpp"
#include "geometry/cubes/samples.hpp"

namespace geometry {

// All throw std::invalid_argument when nothing is there to voxelize, or when it takes more than
// options.max_cubes; the message then names a size that fits. Cells are numbered from the grid's
// origin; grid.size is the cubes'.

// A cube wherever a sample is: the volume that each sample fills, and its mass, go to the cube that
// holds it; where samples do not say, the cubes are full. Faces between samples may leave holes: a
// cube is sure to be found only where a sample falls in it. Attributes are means by volume.
Cubes voxelize_samples(const Samples& samples, const VoxelGrid& grid, const VoxelOptions& options);

// The same of several sets, whose matters stay their own. Samples that do not say what they fill
// share what the others leave of their cube; a set's total_mass is kept, by scaling its densities,
// also where the others leave it nothing: it then adds mass without volume.
// An attribute is the mean over samples of sets that have it, and 0 in cubes of none.
Cubes voxelize_samples(std::span<const Samples* const> sets, const VoxelGrid& grid,
                       const VoxelOptions& options);

// A cube wherever a triangle passes (CellShape::half_open), so no hole is ever left. The volume in
// a cube is the area of the faces in it, clipped exactly, times `thickness` (m); 0 for cubes that
// are all full. Faces that are there twice count twice (geometry/mesh/doubled_faces.hpp).
Cubes voxelize_surface(const TriMesh& mesh, const FaceMatter& matter, double thickness,
                       const VoxelGrid& grid, const VoxelOptions& options);

// A cube wherever a triangle passes, and inside. A cube that a triangle passes holds what is inside
// (see inside_shares), or `thickness` (m) times the area in it where that is more: for the sheets
// in a model of solids, a sheet with two sides counting once. Several matters share a cube as
// solid_matter.hpp has it: by the closed parts in it, else by its faces.
Cubes voxelize_solid(const TriMesh& mesh, const FaceMatter& matter, Inside rule, double thickness,
                     const VoxelGrid& grid, const VoxelOptions& options);

}  // namespace geometry
