#pragma once

// Points spread over a mesh, to be voxelized or scattered upon.

#include "geometry/cubes/assign_matter.hpp"
#include "geometry/cubes/samples.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// How samples get their mass. Total: as by density, then scaled to a sum. By density, a surface
// weighs area x thickness x density of its matter; where no thickness is given, cubes with samples
// in them count as full, and each sample weighs as if the surface were as thick as they lie apart.
struct SampleMass {
    enum class By { total, density, surface_density };
    By by = By::density;
    double total = 1;            // kg
    double thickness = 0;        // m
    double surface_density = 1;  // kg/m^2
};

// `count` points spread evenly by area: one at random in each of `count` strips of equal area along
// the faces' order, the place across the strip by the golden ratio, so that points keep apart
// inside a face too.
// Faces that are there twice count twice (geometry/mesh/doubled_faces.hpp).
// Throws std::invalid_argument when the mesh has no area, or no finite one.
Samples sample_surface(const TriMesh& mesh, const FaceMatter& matter, std::size_t count,
                       std::uint64_t seed, const SampleMass& mass = {});

// `count` points of which no two are near each other: blue noise, for scattering and remeshing.
// Nearer than about 0.75 of the spacing of the closest packing occurs nowhere on flat parts.
// Some hundred times the time of sample_surface.
Samples sample_surface_blue(const TriMesh& mesh, const FaceMatter& matter, std::size_t count,
                            std::uint64_t seed, const SampleMass& mass = {});

// Scales masses to a sum of `total` kg, and leaves the volume that they fill as it is.
void scale_mass(Samples& samples, double total);

// m^2, of all faces whose corners are finite.
double sampled_area(const TriMesh& mesh);

// How many samples of a surface of `area` lie about `spacing` apart.
std::size_t count_for_spacing(double area, double spacing);

}  // namespace geometry
