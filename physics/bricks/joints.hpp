#pragma once

// Joints between parts in a stage of an implicit step: at each point a spring of stiffness k holds
// what both parts carry there together,
//   E = k/2 |g|^2,   g = sum w_a x_a
// linear in x, and felt by the linear solver as a contact that also pulls. k is ten times what
// cubes resist at a point, E h of the softer one, so that a joint gives way by a tenth of what they
// do. Between rigid parts it is 1e4 M / tau^2 of the lighter one, which under g gives way by
// 1e-4 g tau^2: 2 micrometres in 1/24 s. A light one that carries a heavy one counts as a tenth of
// the heaviest part that it is linked to: 20 micrometres.

#include "physics/bricks/stage.hpp"

#include <vector>

namespace physics {

// Of the joints of the frame, at x.
void add_joints(const Stage& stage, const Aligned<double>& x, std::vector<PointContact>& to);

// For each part the first of those that joints link it to.
std::vector<std::uint32_t> joined_parts(const CornerBody& body, std::span<const JointPoint> joints);

// kg, of each part: its own mass, or a tenth of the heaviest that joints link it to.
std::vector<double> masses_to_hold(const CornerBody& body, std::span<const JointPoint> joints,
                                   std::span<const double> part_mass);

}  // namespace physics
