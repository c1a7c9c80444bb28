#pragma once

// Checks pins, and makes one set of several. A pin holds a corner of the cubes at a target, along
// all axes of the world or some of them.

#include "physics/state/loads.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace physics {

// All pins as one. A corner goes to the mean of the targets of those that hold it, axis by axis.
// Throws
// std::invalid_argument when a corner is not below `corners` or a target is not finite.
Pins merge_pins(std::span<const std::shared_ptr<const Pins>> pins, std::size_t corners);

// A warning for each two of the pins that hold a corner in places more than `tolerance` (m) apart,
// where neither gets its way. They must be sorted, as merge_pins() asks.
std::vector<std::string> conflicting_pins(std::span<const std::shared_ptr<const Pins>> pins,
                                          double tolerance);

// Throws std::invalid_argument, with what to do, where a pin holds some axes only: `who` cannot.
void require_all_axes(const Pins& pins, const std::string& who);

// The same where a pin holds points of the material.
void require_corners(const Pins& pins, const std::string& who);

// Throws std::invalid_argument when `pins` is not sorted, names a corner twice or one not below
// `corners`, or holds a target that is not finite.
void check_pins(const Pins& pins, std::size_t corners);

}  // namespace physics
