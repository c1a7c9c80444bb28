#pragma once

#include "physics/loads.hpp"

#include <span>

namespace physics {

// All pins as one. A corner pinned twice goes to the mean of its targets. Throws
// std::invalid_argument when a corner is not below `corners` or a target is not finite.
Pins merge_pins(std::span<const std::shared_ptr<const Pins>> pins, std::size_t corners);

// Throws std::invalid_argument when `pins` is not sorted, names a corner twice or one not below
// `corners`, or holds a target that is not finite.
void check_pins(const Pins& pins, std::size_t corners);

}  // namespace physics
