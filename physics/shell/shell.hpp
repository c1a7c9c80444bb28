#pragma once

// A sheet that stretches, bends and folds as a thin elastic shell, stepped implicitly: cloth,
// paper, rubber, sheet metal. What it costs to stretch stands in shell_cell.hpp, to bend in
// shell_body.hpp; steps, pins, contact and friction are those of all implicit methods
// (bricks/time_step.hpp). How it touches itself and other sheets stands in
// body/sheet_contact.hpp.

#include "physics/shell/shell_body.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/step_options.hpp"

namespace physics {

// The state dt seconds later, as advance() of BricksBody, with the same warnings.
State advance(const ShellBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options = {});

}  // namespace physics
