#include "physics/bricks/brick_frame.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/report_texts.hpp"

#include <algorithm>
#include <stdexcept>

namespace physics {

void check_rigid(const StepOptions& options)
{
    if (options.integrator == Integrator::implicit_euler && !options.leaps) return;
    throw std::invalid_argument("rigid bodies move by implicit Euler alone: set step.integrator = "
                                "implicit_euler and initial_shape = given");
}

void begin_frame(const BricksBody& body, const State& state, const Pins& pins,
                 const StepOptions& options, BrickElasticity& elasticity)
{
    elasticity.load_rotations(state.rotation);
    if (state.plastic_of == PlasticOf::bricks) elasticity.load_plastic(state.plastic);
    if (options.leaps) return;  // an equilibrium is one of the body's own forces
    elasticity.hold(undo_knots(*body.rest, body.neighbours, state.rotation, pins));
}

void end_frame(const BricksBody& body, double before, double dt, const StepOptions& options,
               BrickElasticity& elasticity, State& state)
{
    elasticity.hold({});
    Aligned<float> stress(body.layout.cube.size()), volume(stress.size()), energy(stress.size());
    elasticity.evaluate(by_slot(body.base, state.x).data(), nullptr,
                        {stress.data(), volume.data(), energy.data()});
    state.stress = by_cube(body, stress);
    state.energy = by_cube(body, energy);
    const auto inverted =
        std::count_if(volume.begin(), volume.end(), [](float v) { return v < 0.1f; });
    if (inverted > 0) {
        const double speed = std::max(before, largest_speed(state));
        state.report.warnings.push_back(told_of_inverted(
            std::size_t(inverted), volume.size(), speed * dt / least_steps(options) > body.base.h));
    }
    state.rotation = elasticity.rotations();
    state.plastic = elasticity.plastic();
    state.plastic_strain = elasticity.plastic_strain();
    state.plastic_of = state.plastic.empty() ? PlasticOf::nothing : PlasticOf::bricks;
}

std::vector<float> by_cube(const BricksBody& body, const Aligned<float>& lanes)
{
    std::vector<float> out(body.cubes);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
        if (body.layout.cube[i] != geometry::no_index) out[body.layout.cube[i]] = lanes[i];
    }
    return out;
}

}  // namespace physics
