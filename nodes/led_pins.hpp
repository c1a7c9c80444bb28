#pragma once

// Pins of a body that another node leads.

#include "graph/types/node_type.hpp"
#include "physics/layered_bodies/layered.hpp"

#include <fmt/format.h>

namespace nodes {

// Pins would hold frames where the body is drawn, and not where it is led.
inline void leave_pins_out(const char* leader, physics::LayeredPart& part,
                           const graph::Context& context)
{
    if (part.held.empty()) return;
    part.held.clear();
    context.warn(fmt::format("pins of the body have no effect, because {} leads all of its frames. "
                             "Take them out of the ImplicitLayer",
                             leader));
}

}  // namespace nodes
