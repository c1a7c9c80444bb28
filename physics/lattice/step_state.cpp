#include "physics/lattice/step_state.hpp"

#include "physics/body/external_forces.hpp"
#include "physics/state/balls.hpp"

namespace physics {

namespace {

void find_what_touches(FrameState& step)
{
    const Loads& loads = step.loads;
    step.touches = !loads.colliders.empty() || !loads.balls.empty() || step.body.options.contact.on;
    if (!step.touches) return;
    for (const double m : step.body.base.mass) step.inverse_mass.push_back(m > 0 ? 1 / m : 0);
    for (const auto k : loads.pins.corner) step.inverse_mass[k] = 0;
}

// What the state keeps from step to step: rotations and d of the step before, rest shapes, breaks.
void make_room_in_state(FrameState& step)
{
    State& state = step.state;
    const std::size_t slots = step.body.whole.regions.slots(), kept = 4 * slots + 3 * step.n;
    step.has_before = state.rotation.size() == kept;
    if (!step.has_before) state.rotation.assign(kept, 0.0f);
    step.plastic = step.body.options.plastic.yield > 0;
    const std::size_t plastic = step.plastic ? 6 * slots : 0;
    if (state.plastic.size() != plastic || state.plastic_of != PlasticOf::regions) {
        state.plastic.assign(plastic, 0.0f);
    }
    state.plastic_of = step.plastic ? PlasticOf::regions : PlasticOf::nothing;
    if (!step.body.torn) state.broken.clear();
}

}  // namespace

void find_forces(FrameState& step, double share)
{
    step.gravity = Vec3::Zero();
    step.forces.clear();
    std::vector<Force> points;
    for (const Force& end : step.loads.forces) {
        const Force& f = step.forces.emplace_back(end.at(share));
        if (f.kind == Force::Kind::gravity) step.gravity += f.acceleration;
        if (f.kind == Force::Kind::point) points.push_back(f);
        if (varies_by_place(f)) step.windy = true;
    }
    if (!points.empty() || step.windy) {
        step.steady.assign(step.body.base.numbers, 0);
        add_steady_forces(step.body.base, points, step.steady);
    }
}

void begin_frame(FrameState& step)
{
    const CornerBody& base = step.body.base;
    const Pins& pins = step.loads.pins;
    std::vector<Vec3> from;
    std::vector<std::uint32_t> part;
    for (const auto k : pins.corner) {
        from.push_back(step.state.x[k]);
        part.push_back(base.part_of(base.slot_of(k)));
    }
    step.pin_paths = PinPaths(std::move(from), pins.target, part, pins.pivot, base.h);
    find_what_touches(step);
    make_room_in_state(step);
    find_forces(step, 1);
    step.damped = largest_of(step.n, [&](std::size_t i) { return base.damping_of(i); }) > 0;
    if (step.state.balls.size() != step.loads.balls.size()) {
        step.state.balls = place_balls(step.loads.balls);
    }
}

}  // namespace physics
