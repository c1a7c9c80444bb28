#pragma once

// Corotational brick finite elements on the cubes of a model, stepped implicitly. The element's
// equations stand in brick_kernels.hpp, those of the step in time_step.hpp.
// Squashing cubes: James, Barbic, Twigg, SIGGRAPH 2004 sketches. Bricks as the deformable method on
// embedding cubes: Nesme, Kry, Jerabkova, Faure. Preserving topology and elasticity for embedded
// deformable models. SIGGRAPH 2009.

#include "physics/bricks/bricks_body.hpp"
#include "physics/bricks/elasticity.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/step_options.hpp"

#include <memory>
#include <vector>

namespace physics {

// The state dt seconds later. Throws std::invalid_argument when state, loads or dt do not fit or
// are not finite; any finite state is accepted, and what goes wrong is told in its report.
State advance(const BricksBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options = {});

// Its forces, for steps of another kind; the body must outlive them. `rotation` is a state's.
std::unique_ptr<Elasticity> elasticity_of(const BricksBody& body,
                                          const std::vector<float>& rotation);

// What a body holds at a state's places, with its rest shapes: its elastic energy (J), the forces
// on its corners (N, K) and the von Mises stress of its cubes (Pa, C).
struct Strained {
    double energy = 0;
    std::vector<Vec3> force;
    std::vector<float> stress;
};
Strained strain(const BricksBody& body, const State& state);
Strained strain(const BricksBody& body, const std::vector<Vec3>& x);

}  // namespace physics
