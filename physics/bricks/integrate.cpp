#include "physics/bricks/integrate.hpp"

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/rigid_energy.hpp"
#include "physics/bricks/stage_touches.hpp"
#include "physics/bricks/step_error.hpp"
#include "physics/bricks/step_newton.hpp"
#include "physics/math/for_numbers.hpp"
#include "physics/state/measure.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace physics {
namespace {

// Implicit Euler over tau seconds up to a share of the frame.
void solve_over(FrameStep& step, double tau, double share, Balance balance)
{
    Stage& stage = step.stage;
    stage.span = balance == Balance::middle ? 2 * tau : tau;
    take_forces(step.account, step.frame, step.now.x, share);
    start_stage(stage, step.now.x, step.now.v, tau, share);
    stage.turns_start = balance == Balance::end;
    solve_stage(stage, step.solver, step.record);
    balance_free_parts(stage, step.now.x, step.now.v, balance);
    const bool groups = step.frame.body.solids || !step.frame.loads.joints.empty();
    for (int i = 0; i < 2 && groups && !stage.rigid.none(); ++i) {  // turned parts
        take_rigid_motion(stage);
        turn_rigid_parts(stage);
        balance_free_parts(stage, step.now.x, step.now.v, balance);
    }
    find_leftover(stage, step.solver, step.record);
    step.forces = forces_of_stage(stage, step.record);
    if (!stage.rigid.none()) step.solved = stage.x;
    take_rigid_motion(stage);
    turn_rigid_parts(stage);
}

SolvedStage solved_of(const FrameStep& step)
{
    return {step.now.x, step.now.v, step.stage.rigid.none() ? step.stage.x : step.solved};
}

// Solves the stage over another time, tells what rises by that, and solves it again as it was.
template <class Tell>
void tell_over(FrameStep& step, double seconds, double share, const Tell& tell)
{
    const double tau = step.stage.tau;
    const StepRecord record = step.record;
    solve_over(step, seconds, share, Balance::end);
    tell();
    const auto iterations = step.record.report.iterations;
    step.record = record;
    step.record.report.iterations = iterations;
    solve_over(step, tau, share, Balance::end);
}

// What of `own` was found before a step was cut in halves is not less in these.
Risen risen_in_halves(const FrameStep& step, Risen own)
{
    for (auto& [who, share_of_it] : own) {
        if (const auto at = step.risen.find(who); at != step.risen.end()) {
            share_of_it = std::max(share_of_it, at->second);
        }
    }
    return own;
}

// What rises after an impact by the end of a whole step, where the stage that was solved is
// shorter. In halves it is what was found before they were cut.
Risen risen_in_a_step(FrameStep& step, double share, Balance balance)
{
    constexpr double nearly = 0.9;
    const double whole = step.frame.seconds / least_steps(step.frame.options);
    Risen own = risen(step.stage, solved_of(step));
    if (step.stage.halvings > 0) return risen_in_halves(step, std::move(own));
    const bool all =
        std::all_of(own.begin(), own.end(), [](const auto& r) { return r.second == 1; });
    if (all || balance != Balance::end || step.stage.tau > nearly * whole) return own;
    Risen out;
    tell_over(step, whole, share, [&] { out = risen(step.stage, solved_of(step)); });
    return out;
}

// The same where the error chooses the steps: over a frame, and over less where that tells nothing.
// What is followed since it hit is followed on. The slower it has become by being squashed, the
// longer steps would be expected: it would be taken for rigid, and leave with a share of the speed
// that it has left.
Risen risen_by_error_in_a_step(FrameStep& step, double share)
{
    const double finest = step.frame.seconds / (1 << finest_by_error);
    const auto told = [&] { return risen_by_error(step.stage, solved_of(step), finest); };
    const auto is_told = [&](const auto& r) {
        return r.second != rigid_yet || step.squashed.contains(r.first);
    };
    Risen out = told();
    if (step.stage.halvings > 0) {
        for (auto& [who, share_of_it] : out) {
            const auto at = step.risen.find(who);
            if (at != step.risen.end()) share_of_it = at->second;
        }
    } else {
        for (double tau = step.frame.seconds; tau > step.stage.tau; tau /= 4) {
            tell_over(step, tau, share, [&] { out = told(); });
            if (std::all_of(out.begin(), out.end(), is_told)) break;
        }
    }
    for (auto& [who, share_of_it] : out) {
        share_of_it = step.squashed.contains(who) ? 0 : std::min(share_of_it, 1.0);
    }
    step.squashed.clear();
    for (const auto& [who, share_of_it] : out) {
        if (share_of_it == 0) step.squashed.insert(who);
    }
    return out;
}

void take_stage(FrameStep& step, double tau, double share, Balance balance)
{
    Stage& stage = step.stage;
    solve_over(step, tau, share, balance);
    if (stage.halvings == 0) step.risen.clear();
    Risen all;
    if (stage.struck) {
        const bool by_error = are_by_error(step.frame.options);
        all = by_error ? risen_by_error_in_a_step(step, share)
                       : risen_in_a_step(step, share, balance);
        if (stage.halvings == 0) step.risen = all;
        const auto followed = [](const auto& r) { return r.second == 0; };
        if (by_error && std::any_of(all.begin(), all.end(), followed)) {
            step.solved_error =
                error_of_step(stage, step.now.x, step.now.v, stage.x, stage.w, stage.tau);
        }
    }
    if (stage.struck || !stage.rigid.none()) finish_impacts(stage, solved_of(step), all);
    const Motion before = stage.rigid.none() ? Motion{} : step.now;
    for_numbers(step.frame.n,
                [&](std::size_t i) { step.now.x[i] = stage.x0[i] + tau * stage.w[i]; });
    copy_numbers(stage.w, step.now.v);
    stage.rigid.straighten(step.now.x.data(), step.now.v.data());
    keep_rigid_energy(stage, before.x, before.v, step.now.x, step.now.v);
}

// Whether something hits on the way to x, behind the middle of the step.
bool hits_later(Stage& stage, const Aligned<double>& x)
{
    if (!may_touch(stage)) return false;
    const auto touches = stage.touches, holds = stage.holds;
    const Aligned<double> middle = stage.x;
    stage.x = x;
    find_touches(stage);
    stage.x = middle;
    stage.touches = touches, stage.holds = holds;
    return stage.struck;
}

// Both take a step of dt seconds from share `begin` to share `end` of the frame. Returns whether it
// stands.
bool take_midpoint(FrameStep& step, double dt, double begin, double end)
{
    const Motion before = step.now;
    Motion& now = step.now;
    take_stage(step, 0.5 * dt, 0.5 * (begin + end), Balance::middle);
    if (step.stage.struck) return false;
    charge_damping(step.account, step.stage, dt);
    for (std::size_t i = 0; i < step.frame.n; ++i) {
        now.x[i] = 2 * now.x[i] - before.x[i];
        now.v[i] = 2 * now.v[i] - before.v[i];
    }
    if (!all_finite(now.x)) return true;
    if (hits_later(step.stage, now.x)) return false;
    if (settle(step.account, step.stage, now.x, now.v)) return true;
    step.record.gained = true;
    return false;
}

bool take_sdirk2(FrameStep& step, double dt, double begin, double end)
{
    const double gamma = 1 - 1 / std::sqrt(2.0);
    const Motion before = step.now;
    Motion& now = step.now;
    take_stage(step, gamma * dt, begin + gamma * (end - begin), Balance::linear);
    if (step.stage.struck) return false;
    MeanForces forces;
    add_share(forces, step.forces, 1 - gamma);
    // Slopes of the first stage: velocity v, acceleration (v - v before) / (gamma dt).
    for (std::size_t i = 0; i < step.frame.n; ++i) {
        now.x[i] = before.x[i] + (1 - gamma) * dt * now.v[i];
        now.v[i] = before.v[i] + (1 - gamma) / gamma * (now.v[i] - before.v[i]);
    }
    take_stage(step, gamma * dt, end, Balance::linear);
    add_share(forces, step.forces, gamma);
    step.forces = std::move(forces);
    return !step.stage.struck;
}

}  // namespace

bool are_by_error(const StepOptions& options)
{
    return options.substeps == 0 && options.integrator == Integrator::implicit_euler;
}

void integrate(FrameStep& step, double begin, double end)
{
    const double dt = (end - begin) * step.frame.seconds;
    const Integrator integrator = step.frame.options.integrator;
    if (integrator != Integrator::implicit_euler) {
        const Motion before = step.now;
        const StepRecord record = step.record;
        const bool stands = integrator == Integrator::sdirk2 ? take_sdirk2(step, dt, begin, end)
                                                             : take_midpoint(step, dt, begin, end);
        if (stands) return;
        const bool gained = step.record.gained;
        step.now = before;
        step.record = record;
        step.record.gained |= gained;
    }
    take_stage(step, dt, end, Balance::end);
    if (integrator == Integrator::implicit_midpoint) {
        step.account = open_account(step.stage, step.now.x, step.now.v);
    }
}

}  // namespace physics
