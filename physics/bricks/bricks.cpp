#include "physics/bricks/bricks.hpp"

#include "physics/bricks/brick_frame.hpp"
#include "physics/bricks/rigid_pins.hpp"
#include "physics/bricks/time_step.hpp"
#include "physics/state/measure.hpp"

namespace physics {

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
    begin_frame(body, state, loads.pins, options, elasticity);
    const double before = largest_speed(state);
    state = advance_implicitly(body.base, elasticity, std::move(state), loads, dt, options);
    if (!state.report.slept) end_frame(body, before, dt, options, elasticity, state);
    return state;
}

State advance(const BricksBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options)
{
    check_pins(loads.pins, body.base.corners);
    if (body.base.rigid.empty()) return advance_bricks(body, std::move(state), loads, dt, options);
    check_rigid(options);
    Loads held = loads;
    held.pins = with_rigid_pins(body, loads.pins, dt, loads.joints);
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
