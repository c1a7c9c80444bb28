#pragma once

// How much more than its material a lattice resists bends within its regions, cube by cube.
//
// A region sees what is best linear of a motion, F, and the rest of it (region_volume.hpp). Stretch
// is all F. Of a bend u = kappa (a^2 / 2 e3 - a c e1), a along and c across a body that is t cubes
// thick and L long, F is the stretch kappa c of the regions whose middles are off the middle of the
// body, and the rest is the bend within them. With both at the rate of E they cost, of what the
// material says (E kappa^2 t^2 / 24 for each unit of volume, in lattice steps),
//   alpha = 12 / t^2  V C / m2    and    beta = 12 / t^2  (Q + V V') / m2.
// V is the variance of places in a window of 2 w + 1 of them along the body, and Q what a^2 / 2
// differs there from a line, in mean square; across it, V' is the mean variance in its windows, and
// C that of the windows' middles. Thin bodies have alpha = 0 and beta of 4 (w = 1) and more. With
// stretch at the rate of E and the rest at that of E / n they bend rightly where
//   n = beta / (1 - alpha),
// and Poisson's ratio, which acts in F alone, hardly changes it. Where n is below 1, in bodies that
// are hardly longer than a region, it is taken as 1.

#include "geometry/cubes/cubes.hpp"

#include <vector>

namespace physics {

// n of a body t cubes thick and L long, at least 1.
double bend_ratio(int thickness, int length, int half_width);

// C, n of each cube. Thickness is the edge of the largest full block of cubes that it lies in, and
// length that of the longest row of cubes through it.
std::vector<double> bend_ratios(const geometry::Cubes& cubes, int half_width);

}  // namespace physics
