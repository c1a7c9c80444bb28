#include "physics/bricks/time_step.hpp"

#include "geometry/base/stop.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/step_energy.hpp"
#include "physics/bricks/step_newton.hpp"
#include "physics/state/pins.hpp"
#include "physics/state/report_texts.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace physics {
namespace {

// Where a frame has got to.
struct Motion {
    Aligned<double> x, v;  // m, m/s
};

// All that a frame's steps work with.
struct FrameStep {
    FrameStep(const StepFrame& its_frame, Elasticity& elasticity)
        : frame(its_frame), stage(its_frame, elasticity), solver(stage)
    {}

    const StepFrame& frame;
    Stage stage;
    StepSolver solver;
    StepRecord record;
    Motion now;
    EnergyAccount account;  // of the midpoint rule
};

// Implicit Euler over tau seconds up to a share of the frame.
void take_stage(FrameStep& step, double tau, double share, Balance balance)
{
    Stage& stage = step.stage;
    start_stage(stage, step.now.x, step.now.v, tau, share);
    stage.turns_start = balance == Balance::end;
    step.record.touched |= may_touch(stage);
    solve_stage(stage, step.solver, step.record);
    balance_free_parts(stage, step.now.x, step.now.v, balance);
    find_leftover(stage, step.solver, step.record);
    for (std::size_t i = 0; i < step.frame.n; ++i) {
        step.now.x[i] = stage.x0[i] + tau * stage.w[i];
    }
    step.now.v = stage.w;
}

// From share `begin` to share `end` of the frame.
void integrate(FrameStep& step, double begin, double end)
{
    const double dt = (end - begin) * step.frame.seconds;
    const std::size_t n = step.frame.n;
    Motion& now = step.now;
    switch (step.frame.options.integrator) {
    case Integrator::implicit_euler:
        take_stage(step, dt, end, Balance::end);
        break;
    case Integrator::implicit_midpoint: {
        const Motion before = now;
        const StepRecord record = step.record;
        take_stage(step, 0.5 * dt, 0.5 * (begin + end), Balance::middle);
        charge_damping(step.account, step.stage, dt);
        for (std::size_t i = 0; i < n; ++i) {
            now.x[i] = 2 * now.x[i] - before.x[i];
            now.v[i] = 2 * now.v[i] - before.v[i];
        }
        if (!all_finite(now.x) || settle(step.account, step.stage, now.x, now.v)) break;
        now = before;
        step.record = record;
        step.record.gained = true;
        take_stage(step, dt, end, Balance::end);
        step.account = open_account(step.stage, now.x, now.v);
        break;
    }
    case Integrator::sdirk2: {
        const double gamma = 1 - 1 / std::sqrt(2.0);
        const Motion before = now;
        take_stage(step, gamma * dt, begin + gamma * (end - begin), Balance::linear);
        // Slopes of the first stage: velocity v, acceleration (v - v before) / (gamma dt).
        for (std::size_t i = 0; i < n; ++i) {
            now.x[i] = before.x[i] + (1 - gamma) * dt * now.v[i];
            now.v[i] = before.v[i] + (1 - gamma) / gamma * (now.v[i] - before.v[i]);
        }
        take_stage(step, gamma * dt, end, Balance::linear);
        break;
    }
    }
}

// Pinned corners arrive exactly, and move as their targets do.
void place_pins(const StepFrame& frame, double share, Motion& now)
{
    const auto& pinned = frame.loads.pins.corner;
    for (std::size_t i = 0; i < pinned.size(); ++i) {
        const std::size_t at = 4 * frame.body.slot_of(pinned[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            now.x[at + k] = pin_target(frame, i, k, share);
            now.v[at + k] = (pin_target(frame, i, k, 1) - frame.start[at + k]) / frame.seconds;
        }
    }
}

// Whether the step that was taken last is to be taken in halves: parts that touch did not settle,
// so that they would be thrown apart.
bool is_torn_apart(const FrameStep& step, int halvings)
{
    constexpr int most = 2;
    constexpr double much = 0.01;  // of the forces at work
    const StepRecord& record = step.record;
    return !step.stage.near.empty() && halvings < most && (record.left > much || record.violent);
}

// From share `begin` to share `end` of the frame; in halves where the whole fails. False: not even
// a 256th of it could be taken.
bool step_or_halves(FrameStep& step, double begin, double end, int halvings)
{
    const Motion before = step.now;
    const StepRecord record = step.record;
    const EnergyAccount account = step.account;
    Report& report = step.record.report;
    step.record.unsettled = step.record.violent = false;
    step.record.left = 0;
    step.stage.halvings = halvings;
    ++report.steps;
    integrate(step, begin, end);
    place_pins(step.frame, end, step.now);
    const bool finite = all_finite(step.now.x) && all_finite(step.now.v);
    if (finite && !is_torn_apart(step, halvings)) {
        step.record.unsettled |= record.unsettled;
        step.record.violent |= record.violent;
        StepEnd at{before.x.data(), step.now.x.data(), (end - begin) * step.frame.seconds};
        step.stage.grips = grips_of(step.stage.touches, at);
        // The side of a sheet is not told by a plane alone: the next step may lead over a crease.
        at.late = (end - step.stage.share) * step.frame.seconds;
        at.near = 0.5 * known_before * step.frame.body.h;
        step.stage.held = grips_of(step.stage.holds, at);
        return true;
    }
    step.now = before;
    step.account = account;
    const auto iterations = report.iterations;
    const auto steps = report.steps;
    step.record = record;
    report.iterations = iterations;
    report.steps = steps;
    if (halvings == 8) {
        report.converged = false;
        report.warnings.emplace_back(told_of_divergence());
        return false;
    }
    const double middle = 0.5 * (begin + end);
    return step_or_halves(step, begin, middle, halvings + 1) &&
           step_or_halves(step, middle, end, halvings + 1);
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
    record.report.warnings.emplace_back(
        record.short_of_iterations ? "The linear solver did not converge to step.tolerance. Raise "
                                     "step.solver_iterations."
        : record.violent           ? "The motion is too fast for the time step: the forces are not "
                                     "balanced to step.tolerance. Raise step.substeps."
        : !record.touched          ? "Newton's method did not converge to step.tolerance. Raise "
                                     "step.newton_iterations or step.substeps."
                                   : "Contact did not converge to step.tolerance. Raise "
                                     "step.contact_iterations or step.substeps.");
}

Motion load(const CornerBody& body, const State& state)
{
    return {by_slot(body, state.x), by_slot(body, state.v)};
}

void store(const CornerBody& body, const Motion& motion, State& state)
{
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t at = 4 * body.slot_of(k);
        state.x[k] = Vec3(motion.x[at], motion.x[at + 1], motion.x[at + 2]);
        state.v[k] = Vec3(motion.v[at], motion.v[at + 1], motion.v[at + 2]);
    }
}

bool is_far(const State& state)
{
    return std::any_of(state.x.begin(), state.x.end(),
                       [](const Vec3& x) { return !(x.cwiseAbs().maxCoeff() <= farthest); });
}

void check_state(const CornerBody& body, const State& state)
{
    const auto expected = std::to_string(body.corners);
    if (state.x.size() != body.corners || state.v.size() != body.corners) {
        throw std::invalid_argument("state: expected " + expected + " corners, found " +
                                    std::to_string(state.x.size()) +
                                    ". Was it made with other cubes?");
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        if (!state.x[k].allFinite() || !state.v[k].allFinite()) {
            throw std::invalid_argument("state: corner " + std::to_string(k) +
                                        " has a position or velocity that is not finite");
        }
    }
}

}  // namespace

State advance_implicitly(const CornerBody& body, Elasticity& elasticity, State state,
                         const Loads& loads, double dt, const StepOptions& options)
{
    if (!(std::isfinite(dt) && dt > 0)) {
        throw std::invalid_argument("expected a time step above 0 s, found " + std::to_string(dt));
    }
    if (options.substeps < 1) throw std::invalid_argument("expected at least one substep");
    check_state(body, state);
    check_pins(loads.pins, body.corners);
    check_forces(loads.forces);
    StepFrame frame(body, loads, dt, options);
    FrameStep step(frame, elasticity);
    step.now = load(body, state);
    step.stage.grips = std::move(state.grips);
    step.stage.held = std::move(state.holds);
    frame.start = step.now.x;
    frame.first = state.time == 0;
    if (options.integrator == Integrator::implicit_midpoint) {
        step.account = open_account(step.stage, step.now.x, step.now.v);
    }
    const double share = 1.0 / options.substeps;
    for (int i = 0; i < options.substeps; ++i) {
        geometry::stop_if_asked();
        const double end = i + 1 == options.substeps ? 1.0 : (i + 1) * share;
        if (!step_or_halves(step, i * share, end, 0)) break;
        frame.first = false;
    }
    store(body, step.now, state);
    state.grips = std::move(step.stage.grips);
    state.holds = std::move(step.stage.held);
    if (is_far(state)) {
        step.record.report.converged = false;
        step.record.report.warnings.emplace_back(told_of_distance());
    }
    warn_of_shortfall(step.record);
    state.time += dt;
    state.report = std::move(step.record.report);
    return state;
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
