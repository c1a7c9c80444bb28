#pragma once

// Contact between parts of one body: points of a part's surface that lie in the matter of another,
// or of their own part where that is three cubes and more away along the body.
//
// A point at p that lies in a cube of another part is, for that part, where the cube was at rest:
//   p = sum w_a(u) x_a,    X = origin + h (cell + u)
// with w the trilinear weights. How deep X lies in the part's shape at rest, to the nearest point Y
// of it, is known from there; the cube's deformation gradient F takes it back:
//   n = F^-T N / |F^-T N|,   g = -|Y - X| / |F^-T N|,   N = (Y - X) / |Y - X|
// (distances from shapes at rest: Hirota, Fisher, Lin. Simulation of non-penetrating elastic bodies
// using distance fields. TR00-018, UNC, 2000; McAdams and others. Efficient elasticity for
// character skinning with contact and collisions. SIGGRAPH 2011). A point that came in through
// another side within the step is pushed back out of that side.
//
//   part boxes -> pairs of parts that are near -> cubes and points in the boxes' overlap
//     -> tree of cubes -> u of each point -> shape at rest -> plane (plane_touch.hpp)

#include "physics/body/meet_part.hpp"
#include "physics/body/part_shapes.hpp"
#include "physics/body/plane_touch.hpp"

#include <vector>

namespace physics {

// Pairs that do not overlap at rest and whose boxes overlap when each corner goes from x along v
// for dt seconds, and a cube further; and each part with itself where parts touch themselves. x and
// v are by slot, four numbers each.
std::vector<PartPair> near_parts(const PartShapes& shapes, const double* x, const double* v,
                                 double dt);

// The planes of all points of a part of each pair that are in the other part or before a face of
// it, in_order(). Points on a part that they are `known` to touch, in_order(), are not looked at.
std::vector<PlaneTouch> find_part_touches(const PartShapes& shapes,
                                          const std::vector<PartPair>& pairs, const double* x,
                                          const double* v, double dt, Look how,
                                          const std::vector<PlaneTouch>& known = {});

}  // namespace physics
