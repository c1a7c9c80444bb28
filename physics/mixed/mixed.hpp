#pragma once

// Steps solids and sheets together (mixed_body.hpp).

#include "physics/mixed/mixed_body.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/step_options.hpp"

namespace physics {

// The state dt seconds later, as advance() of BricksBody, with the same warnings. The stress and
// elastic energy of sheets are not known. Throws std::invalid_argument where a pin holds corners of
// sheets along some axes, or points of them.
State advance(const MixedBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options = {});

}  // namespace physics
