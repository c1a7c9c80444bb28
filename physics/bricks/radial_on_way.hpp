#pragma once

// Radial forces in a stage: where on a body's way they are taken.
//
// They vary along the way, and by that where they are taken decides whether a body that is drawn to
// a place gains energy. With a = -omega^2 x at x0, x1 = x0 + tau v0 + tau^2 a / 2 and
// v1 = v0 + tau a have the determinant 1 + (tau omega)^2 / 2, so that orbits grow from step to
// step. With a in the middle of the way, at x0 + tau v0 / 2, it is 1: drift, kick and drift
// (leapfrog; Hairer, Lubich, Wanner. Geometric Numerical Integration. 2006, I.1.4). So
//   what goes along a parabola (free_fall.hpp) or by means (rigid_energy.hpp) takes them there;
//   what implicit Euler moves by tau v1 takes them where it starts, with the determinant 1;
//   stages of the midpoint rule and of sdirk2 take them where they end, as their equations ask.
//
// Their torques are about places where the stage ends. A body that spins takes them turned as it is
// there: at another angle, a force that draws to its centre would turn it ever faster. What pins
// hold turns as turn_pinned_parts() says, by forces where it starts.

#include "physics/bricks/stage.hpp"

namespace physics {

// Adds them to stage.wind where the stage starts.
void start_radial_forces(Stage& stage);

// Takes them where they belong. `ahead`, m: where corners are about to be at the stage's end.
void take_radial_on_way(Stage& stage, Aligned<double> ahead);

// N, of each corner at x, less those of the stage; empty where there are none.
Aligned<double> radial_beyond_stage(const Stage& stage, const Aligned<double>& x);

}  // namespace physics
