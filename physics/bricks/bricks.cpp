#include "physics/bricks/bricks.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/rigid_pins.hpp"
#include "physics/bricks/time_step.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/report_texts.hpp"

#include <algorithm>
#include <stdexcept>

namespace physics {
namespace {

using geometry::no_index;

std::vector<float> by_cube(const BricksBody& body, const Aligned<float>& lanes)
{
    std::vector<float> out(body.cubes);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
        if (body.layout.cube[i] != no_index) out[body.layout.cube[i]] = lanes[i];
    }
    return out;
}

// What rigid parts cannot be asked for.
void check_rigid(const StepOptions& options)
{
    if (options.integrator == Integrator::implicit_euler && !options.leaps) return;
    throw std::invalid_argument("rigid bodies move by implicit Euler alone: set step.integrator = "
                                "implicit_euler and initial_shape = given");
}

}  // namespace

std::unique_ptr<Elasticity> elasticity_of(const BricksBody& body,
                                          const std::vector<float>& rotation)
{
    auto elasticity = std::make_unique<BrickElasticity>(body);
    elasticity->load_rotations(rotation);
    return elasticity;
}

static State advance_bricks(const BricksBody& body, State state, const Loads& loads, double dt,
                            const StepOptions& options)
{
    BrickElasticity elasticity(body);
    elasticity.load_rotations(state.rotation);
    if (state.plastic_of == PlasticOf::bricks) elasticity.load_plastic(state.plastic);
    if (!options.leaps) {  // an equilibrium is one of the body's own forces
        elasticity.hold(undo_knots(*body.rest, body.neighbours, state.rotation, loads.pins));
    }
    const double before = largest_speed(state);
    state = advance_implicitly(body.base, elasticity, std::move(state), loads, dt, options);
    if (state.report.slept) return state;
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
            std::size_t(inverted), volume.size(), speed * dt / options.substeps > body.base.h));
    }
    state.rotation = elasticity.rotations();
    state.plastic = elasticity.plastic();
    state.plastic_strain = elasticity.plastic_strain();
    state.plastic_of = state.plastic.empty() ? PlasticOf::nothing : PlasticOf::bricks;
    return state;
}

State advance(const BricksBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options)
{
    check_pins(loads.pins, body.base.corners);
    if (body.base.rigid.empty()) return advance_bricks(body, std::move(state), loads, dt, options);
    check_rigid(options);
    Loads held = loads;
    held.pins = with_rigid_pins(body, loads.pins, dt);
    return advance_bricks(body, std::move(state), held, dt, options);
}

Strained strain(const BricksBody& body, const std::vector<Vec3>& x)
{
    State state;
    state.x = x;
    return strain(body, state);
}

Strained strain(const BricksBody& body, const State& state)
{
    BrickElasticity elasticity(body);
    if (state.plastic_of == PlasticOf::bricks) elasticity.load_plastic(state.plastic);
    Aligned<double> f(4 * body.layout.slots, 0);
    Aligned<float> stress(body.layout.cube.size());
    Strained out;
    out.energy = elasticity.evaluate(by_slot(body.base, state.x).data(), f.data(), {stress.data()});
    for (std::size_t k = 0; k < body.base.corners; ++k) {
        out.force.emplace_back(f[4 * std::size_t{body.base.slot[k]}],
                               f[4 * std::size_t{body.base.slot[k]} + 1],
                               f[4 * std::size_t{body.base.slot[k]} + 2]);
    }
    out.stress = by_cube(body, stress);
    return out;
}

}  // namespace physics
