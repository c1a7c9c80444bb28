#pragma once

// The lines of one chart along x, y and z: which bars and plates regions need, and what each sums.

#include "physics/regions/charts.hpp"
#include "physics/regions/lattice_regions.hpp"

namespace physics {

// Adds the bars, plates and regions of `chart` to those of `regions`.
void add_chart_lines(const Lattice& lattice, const Chart& chart, LatticeRegions& regions);

}  // namespace physics
