#include "physics/bricks/time_step.hpp"

#include "geometry/base/stop.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/bricks/bounce.hpp"
#include "physics/bricks/frame_state.hpp"
#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/held_ringing.hpp"
#include "physics/bricks/holding_elasticity.hpp"
#include "physics/bricks/integrate.hpp"
#include "physics/bricks/rigid_energy.hpp"
#include "physics/bricks/sleep.hpp"
#include "physics/bricks/stage_touches.hpp"
#include "physics/bricks/step_energy.hpp"
#include "physics/bricks/step_error.hpp"
#include "physics/bricks/step_newton.hpp"
#include "physics/math/for_numbers.hpp"
#include "physics/state/hold_matter.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/pins.hpp"
#include "physics/state/report_texts.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace physics {
namespace {

// N s, what pins give the body where they make what they hold faster by `jump` (m/s). Their
// neighbours have a share of it where mass is spread over cubes, which comes from the pins too.
Aligned<double> impulses_for(const Stage& stage, const Aligned<double>& jump)
{
    Aligned<double> out, of_held;
    times_mass(stage, jump, out);
    times_mass(stage, stage.frame.fixed, of_held);
    for_numbers(jump.size(),
                [&](std::size_t i) { out[i] += (stage.frame.mass[i] - of_held[i]) * jump[i]; });
    return out;
}

// Pinned corners arrive exactly, and move as their targets do. Where the step left them with
// another velocity (the midpoint rule goes on by as much as it came, and what turns goes along a
// chord), their pins change their momentum once more.
void place_pins(FrameStep& step, double begin, double end)
{
    const StepFrame& frame = step.frame;
    Aligned<double> jump;
    fill_numbers(jump, frame.n, 0.0);
    for_held_axes(frame, [&](std::size_t pin, std::size_t axis, std::size_t number) {
        const auto a = static_cast<Eigen::Index>(axis);
        const double v = frame.pin_paths.velocity(pin, end)[a] / frame.seconds;
        step.now.x[number] = frame.pin_paths.at(pin, end)[a];
        jump[number] = v - step.now.v[number];
        step.now.v[number] = v;
    });
    if (std::all_of(jump.begin(), jump.end(), [](double v) { return v == 0; })) return;
    const Aligned<double> impulses = impulses_for(step.stage, jump);
    MeanForces more;
    more.reaction.assign(frame.loads.pins.corner.size(), Vec3::Zero());
    for_held_axes(frame, [&](std::size_t pin, std::size_t axis, std::size_t number) {
        const double dt = (end - begin) * frame.seconds;
        more.reaction[pin][static_cast<Eigen::Index>(axis)] = impulses[number] / dt;
    });
    more.reaction = frame.pin_paths.at_end(std::move(more.reaction), end);
    add_share(step.forces, more, 1);
}

// Whether a corner moved by more than so many edges of its cube or cell in the step that was taken
// last.
bool leaps_over_cubes(const FrameStep& step, double cubes)
{
    const CornerBody& body = step.frame.body;
    const Aligned<double>& v = step.stage.began_v;
    for (std::size_t k = 0; k < body.corners; ++k) {
        const double speed = Vec3(v[4 * k], v[4 * k + 1], v[4 * k + 2]).norm();
        if (step.stage.tau * speed > cubes * body.edge_at(k)) return true;
    }
    return false;
}

// How often a step may be halved where parts that touch do not settle. What is fast and does not
// settle may have come through a sheet or a thin body.
int most_halvings_of(const FrameStep& step)
{
    constexpr int most_of_the_fast = 7;
    const bool sheets = static_cast<bool>(step.frame.body.solids);
    if (leaps_over_cubes(step, sheets ? 1 : 4)) return most_of_the_fast;
    return sheets || !step.stage.rigid.none() ? most_halvings : 2;
}

// Whether the step that was taken last is to be taken in halves: parts that touch did not settle,
// so that they would be thrown apart.
bool is_torn_apart(const FrameStep& step, int halvings)
{
    const double much = !step.stage.rigid.none() ? 0 : 0.01;  // of the forces at work
    const StepRecord& record = step.record;
    const bool may = touches_itself(step.stage) || !step.stage.rigid.none();
    return may && (record.left > much || record.violent) && halvings < most_halvings_of(step);
}

// What a step starts with.
struct Before {
    explicit Before(const FrameStep& step)
        : now(step.now), record(step.record), account(step.account), squashed(step.squashed),
          forces_at(step.frame.forces_at)
    {}

    Motion now;
    StepRecord record;
    EnergyAccount account;
    Squashed squashed;
    double forces_at;
};

// Undoes the step that was taken last; what it cost stays counted.
void take_back(FrameStep& step, const Before& before)
{
    const auto iterations = step.record.report.iterations;
    const auto steps = step.record.report.steps;
    step.now = before.now;
    step.frame.take_forces(before.forces_at);
    step.account = before.account;
    step.squashed = before.squashed;
    step.record = before.record;
    step.record.report.iterations = iterations;
    step.record.report.steps = steps;
}

// Cubes: what rests comes to be no deeper in what it lies on.
constexpr double deep_at_rest = 0.005;
constexpr double deep_sheet_at_rest = 0.05;  // thicknesses

// What rest shapes give way by is no energy that the midpoint rule is to keep.
void let_flow(FrameStep& step, double dt)
{
    Elasticity& elasticity = step.stage.elasticity;
    if (step.frame.options.leaps || !elasticity.may_flow()) return;
    const double* const x = step.now.x.data();
    const double before = step.account.known ? elasticity.energy(x) : 0;
    if (elasticity.flow(x, dt, Elasticity::Flow::taken) == 0) return;
    step.stage.linear_at.clear();
    if (step.account.known) step.account.due += elasticity.energy(x) - before;
}

// Goes on from the step that was taken last.
void keep(FrameStep& step, const Before& before, double begin, double end)
{
    step.record.unsettled |= before.record.unsettled;
    step.record.violent |= before.record.violent;
    StepEnd at{before.now.x.data(), step.now.x.data(), (end - begin) * step.frame.seconds};
    const CornerBody& body = step.frame.body;
    at.deep = body.sheets ? deep_sheet_at_rest : deep_at_rest;
    step.stage.grips = grips_of(step.stage.touches, at);
    // The side of a sheet is not told by a plane alone: the next step may lead over a crease.
    at.late = (end - step.stage.share) * step.frame.seconds;
    at.near = 0.5 * known_before * step.frame.body.greatest_edge;
    step.stage.held = grips_of(step.stage.holds, at);
    add_share(step.mean, step.forces, end - begin);
    let_flow(step, at.dt);
}

// How often a step was cut already: in halves where it failed, where something hit, and in halves
// for the error's sake.
struct Cuts {
    int halvings = 0, hits = 0, finer = 0;
};

// Where in the step that was taken last, begin .. end, something that bounces hits first: the step
// is to end there, and another one to begin. `end`: it need not.
double share_of_hit(const FrameStep& step, double begin, double end, Cuts cuts)
{
    constexpr int most = 3;
    constexpr double near = 0.002;  // of the step
    if (cuts.hits == most || !step.stage.struck) return end;
    const double hit = first_hit(step.stage) / step.stage.tau;
    return hit > near && hit < 1 ? begin + hit * (end - begin) : end;
}

// Whether what touches gained nothing in the step that was taken last. In the least of halves, what
// parts gained of each other is taken off.
bool keeps_energy(FrameStep& step, const Motion& before, int halvings)
{
    Motion& now = step.now;
    const double gained = gained_by_touching(step.stage, before.x, before.v, now.x, now.v);
    if (!(gained > 0)) return true;
    if (halvings < most_halvings) return false;
    if (!take_off(step.stage, gained, now.v)) step.record.violent = true;
    return true;
}

// Of the step that was taken last, of dt seconds: in edges of cubes. Only of implicit Euler is it
// known.
double error_of_last(const FrameStep& step, const Motion& before, double dt)
{
    if (step.frame.options.integrator != Integrator::implicit_euler || step.frame.options.leaps) {
        return 0;
    }
    const double error = error_of_step(step.stage, before.x, before.v, step.now.x, step.now.v, dt);
    return std::max(error, step.solved_error);
}

// Whether a step with this error need not be taken in halves for its sake. The next one may be
// twice as long where that leaves it so.
bool is_accurate(FrameStep& step, double error, Cuts cuts)
{
    const StepOptions& options = step.frame.options;
    if (!are_by_error(options)) return true;
    const double most = options.error;
    step.finer = may_lengthen(error, most) ? cuts.finer - 1 : cuts.finer;
    return error <= most || cuts.finer == finest_by_error;
}

// Whether a step is cut in halves before it is tried: what follows a step that took halves takes no
// more than twice as long.
bool begins_in_halves(FrameStep& step, Cuts& cuts)
{
    if (cuts.hits > 0) return false;
    if (cuts.finer < step.finer) {
        ++cuts.finer;
        return true;
    }
    if (step.stage.rigid.none() || cuts.halvings + 1 >= step.halvings) return false;
    if (cuts.halvings == 0) step.risen.clear();
    ++cuts.halvings;
    return true;
}

// From share `begin` to share `end` of the frame; in halves where the whole fails. False: not even
// a 256th of it could be taken.
bool step_or_parts(FrameStep& step, double begin, double end, Cuts cuts)
{
    if (begins_in_halves(step, cuts)) {
        const double half = 0.5 * (begin + end);
        return step_or_parts(step, begin, half, cuts) && step_or_parts(step, half, end, cuts);
    }
    const Before before(step);
    step.record.unsettled = step.record.violent = false;
    step.record.left = 0;
    step.stage.halvings = cuts.halvings;
    step.solved_error = 0;
    ++step.record.report.steps;
    integrate(step, begin, end);
    place_pins(step, begin, end);
    const bool rings = step.frame.options.integrator == Integrator::implicit_midpoint;
    if (step.holding && rings) stop_ringing(step, *step.holding, before.now.v, begin, end);
    const bool finite = all_finite(step.now.x) && all_finite(step.now.v);
    double middle = finite ? share_of_hit(step, begin, end, cuts) : end;
    const double dt = (end - begin) * step.frame.seconds;
    const double error = finite ? error_of_last(step, before.now, dt) : 0;
    if (middle < end) {
        ++cuts.hits;
    } else if (!finite || is_torn_apart(step, cuts.halvings) ||
               !keeps_energy(step, before.now, cuts.halvings)) {
        middle = 0.5 * (begin + end);
        ++cuts.halvings;
    } else if (!is_accurate(step, error, cuts)) {
        middle = 0.5 * (begin + end);
        ++cuts.finer;
    } else {
        keep(step, before, begin, end);
        double& most = step.record.report.step_error;
        most = std::max(most, error);
        step.halvings = cuts.halvings;
        return true;
    }
    take_back(step, before);
    if (cuts.halvings > 8) {
        step.record.report.converged = false;
        step.record.report.warnings.emplace_back(told_of_divergence());
        return false;
    }
    return step_or_parts(step, begin, middle, cuts) && step_or_parts(step, middle, end, cuts);
}

void warn_of_shortfall(StepRecord& record)
{
    if (record.gained) {
        record.report.warnings.emplace_back(
            "The midpoint rule would gain energy in steps this long, so that some of them are of "
            "implicit Euler. Raise step.substeps, or take step.integrator = implicit_euler.");
    }
    if (!record.short_of_iterations && !record.unsettled && !record.violent) return;
    record.report.converged = false;
    record.report.warnings.emplace_back(record.short_of_iterations ? short_linear_solve
                                        : record.violent           ? short_of_speed
                                        : !record.touched          ? short_newton
                                                                   : short_contact);
}

Motion load(const CornerBody& body, const State& state)
{
    return {by_slot(body, state.x), by_slot(body, state.v)};
}

void store(const CornerBody& body, const Motion& motion, State& state)
{
    for_numbers(body.corners, [&](std::size_t k) {
        const std::size_t at = 4 * body.slot_of(k);
        state.x[k] = Vec3(motion.x[at], motion.x[at + 1], motion.x[at + 2]);
        state.v[k] = Vec3(motion.v[at], motion.v[at + 1], motion.v[at + 2]);
    });
}

// Whether no rest shape would flow within the frame.
bool keeps_shape(FrameStep& step)
{
    Elasticity& elasticity = step.stage.elasticity;
    return !elasticity.may_flow() || elasticity.flow(step.now.x.data(), step.frame.seconds,
                                                     Elasticity::Flow::told) < still_rest;
}

bool sleeps(FrameStep& step, const State& state)
{
    const StepOptions& options = step.frame.options;
    return options.sleep && !options.leaps && state.still_frames >= frames_at_rest &&
           state.report.converged && state.report.warnings.empty() && keeps_shape(step) &&
           stays_at_rest(step.stage, step.solver, step.now.x, step.now.v, step.record);
}

State slept_through(State state, FrameStep& step, double dt)
{
    const MeanForces forces = forces_of_pins(step.stage, step.record, step.now.x);
    tell_pins(forces, step.frame.loads.pins, state);
    state.v.assign(state.v.size(), Vec3::Zero());
    state.time += dt;
    state.report = step.record.report;
    state.report.slept = true;
    return state;
}

State advance_all(const CornerBody& body, Elasticity& elasticity, State state, const Loads& loads,
                  double dt, const StepOptions& options, const HoldingElasticity* holding = nullptr)
{
    StepFrame frame(body, loads, dt, options);
    FrameStep step(frame, elasticity);
    step.holding = holding;
    step.now = load(body, state);
    step.stage.rigid.straighten(step.now.x.data(), step.now.v.data());
    step.stage.grips = without_those_gone(state.grips);
    step.stage.held = without_those_gone(state.holds);
    frame.start_at(step.now.x);
    frame.first = state.time == 0;
    if (sleeps(step, state)) return slept_through(std::move(state), step, dt);
    if (options.integrator == Integrator::implicit_midpoint) {
        step.account = open_account(step.stage, step.now.x, step.now.v, state.energy_owed);
    }
    if (are_by_error(options)) step.finer = halvings_of(state.report.steps);
    const int steps = least_steps(options);
    const double share = 1.0 / steps;
    for (int i = 0; i < steps; ++i) {
        geometry::stop_if_asked();
        const double end = i + 1 == steps ? 1.0 : (i + 1) * share;
        if (!step_or_parts(step, i * share, end, {})) break;
        frame.first = false;
    }
    store(body, step.now, state);
    state.still_frames = is_still(body, frame.start, step.now.x, dt) ? state.still_frames + 1 : 0;
    tell_pins(step.mean, loads.pins, state);
    state.energy_owed = step.account.owed;
    state.grips = with_corners(body, with_mean(step.stage.grips, step.mean.grips));
    state.holds = with_corners(body, with_mean(step.stage.held, step.mean.holds));
    if (is_far(state)) {
        step.record.report.converged = false;
        step.record.report.warnings.emplace_back(told_of_distance());
    }
    warn_of_shortfall(step.record);
    state.time += dt;
    state.report = std::move(step.record.report);
    return state;
}

}  // namespace

State advance_implicitly(const CornerBody& body, Elasticity& elasticity, State state,
                         const Loads& loads, double dt, const StepOptions& options)
{
    if (!(std::isfinite(dt) && dt > 0)) {
        throw std::invalid_argument("expected a time step above 0 s, found " + std::to_string(dt));
    }
    if (options.substeps < 0) throw std::invalid_argument("expected substeps of 0 or more");
    check_state(body, state);
    check_pins(loads.pins, body.corners);
    check_forces(loads.forces);
    const HeldMatter& matter = loads.pins.matter;
    if (matter.cubes.empty()) {
        return advance_all(body, elasticity, std::move(state), loads, dt, options);
    }
    HoldingElasticity holding(body, elasticity, matter, targets_before(matter, state));
    return advance_all(body, holding, std::move(state), loads, dt, options, &holding);
}

State rest_state(const CornerBody& body)
{
    State state;
    state.x.resize(body.corners);
    state.v.assign(body.corners, Vec3::Zero());
    for (std::size_t k = 0; k < body.corners; ++k) {
        const double* at = body.rest.data() + 4 * body.slot_of(k);
        state.x[k] = Vec3(at[0], at[1], at[2]);
    }
    return state;
}

}  // namespace physics
