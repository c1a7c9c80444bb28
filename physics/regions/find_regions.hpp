#pragma once

// Finds the regions of a lattice: the lines that most are summed along, and the regions that do not
// hold everything in their box.

#include "physics/regions/lattice_regions.hpp"

namespace physics {

// `flat_axis` is one that nothing is linked along, or -1. Throws std::invalid_argument for a half
// width outside 1 .. 64, or links that are not to a neighbour, or along the flat axis.
LatticeRegions find_regions(const Lattice& lattice, int half_width, int flat_axis = -1);

}  // namespace physics
