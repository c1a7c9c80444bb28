#pragma once

// Attributes of meshes and samples as numbers of cubes: the mean over what of them lies in each.

#include "geometry/cubes/cubes.hpp"
#include "geometry/cubes/fill_cubes.hpp"
#include "geometry/cubes/samples.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// Those of `attributes` that `wanted` names: names apart by commas or spaces, where * is any text
// and ? any character. In their own order, each once. * and ? pass over names that cubes cannot
// have (check_own_name). Throws std::invalid_argument for a name without them that none has, or
// that cubes cannot have.
std::vector<const Attribute*> chosen_attributes(const std::string& wanted,
                                                std::span<const Attribute> attributes);

// The same of what cubes know: their own attributes, and young, density, poisson, mass_damping,
// stiffness_damping and fill. * and ? stand for their own alone.
std::vector<CubeAttribute> chosen_values(const std::string& wanted, const Cubes& cubes);

// By the area of the faces in each cube; exact where they are linear. A cube that faces only touch
// has the value of the nearest. Of a sheet, as with_means_of_solid(): exact where they are linear
// and the mesh is the sheet's. Throws std::invalid_argument for names of other quantities
// (check_own_name).
Cubes with_means_of_surface(Cubes cubes, const TriMesh& mesh,
                            std::span<const Attribute* const> attributes);

// Each place in a cube has the value of the nearest place of the surface; the mean is that of 2 x 2
// x 2 Gauss points, or of a sheet's sheet_points().
Cubes with_means_of_solid(Cubes cubes, const TriMesh& mesh,
                          std::span<const Attribute* const> attributes);

// Gives samples of a mesh the values of its attributes where they lie: on its faces, nearest to
// them, or of its points.
void add_attributes(Samples& samples, const TriMesh& mesh,
                    std::span<const Attribute* const> attributes);

// By the volume that samples fill of each cube. `deposits` are of those samples that are `used`,
// set by set, in their order.
void add_means_of_samples(Cubes& cubes, std::span<const Deposit> deposits,
                          std::span<const Samples* const> sets, std::span<const std::uint8_t> used);

}  // namespace geometry
