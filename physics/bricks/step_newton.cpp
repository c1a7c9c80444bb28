#include "physics/bricks/step_newton.hpp"

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/step_descent.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// Most contacts settle in a few rounds with steps that never reverse a slip. From this round on
// steps take friction nearly by its derivative, and are shortened where they go too far. Where
// parts touch each other, what they touch at is looked for in the rounds before it.
constexpr int first_wary_round = 3;
constexpr int first_wary_round_of_parts = 2;

// Contacts of parts come and go between rounds, so that none of them need be solved exactly.
constexpr double part_accuracy = 0.02;
// Parts are looked at again where the forces balance so far, as a share of those at work.
constexpr double near_enough = 0.01;

// Free corners set off as the steady forces have them, unless they then touch something.
void fall(Stage& stage)
{
    const StepFrame& frame = stage.frame;
    for (std::size_t i = 0; i < frame.n; ++i) {
        if (frame.mass[i] > 0) stage.w[i] += stage.tau * frame.steady[i] / frame.mass[i];
    }
    place(stage);
    find_touches(stage);
    stage.contacts = touching(stage);
    if (stage.contacts.empty()) return;
    stage.w = stage.v0;
    place(stage);
    stage.contacts.clear();
}

void linearise_here(Stage& stage)
{
    linearise(stage, stage.x);
    stage.at_start = false;
}

// Linear about x0 + tau b, with the residual and A of w as it was guessed.
void start_rounds(Stage& stage, StepSolver& solver)
{
    stage.wary = false;
    place(stage);
    find_touches(stage);
    stage.contacts = touching(stage);
    turn_free_parts(stage);
    if (stage.base.empty()) {
        linearise(stage, stage.x0);
    } else {
        for (std::size_t i = 0; i < stage.frame.n; ++i) {
            stage.x[i] = stage.x0[i] + stage.tau * stage.base[i];
        }
        linearise(stage, stage.x);
    }
    stage.at_start = true;
    place(stage);
    if (!stage.base.empty()) {
        find_touches(stage);
        stage.contacts = touching(stage);
    }
    const bool free = stage.frame.loads.pins.corner.empty() && stage.contacts.empty();
    if (free) fall(stage);
    find_residual(stage);
    prepare(solver, stage);
}

// What stays as it is from round to round.
struct Rounds {
    bool one;    // linear forces alone were asked for
    bool parts;  // may touch each other
    int first_wary, most;
    double start;   // the norm of the forces at work
    double target;  // the norm of the residual that is small enough
};

// The norm of what is left over where w leads.
double measure(Stage& stage, StepSolver& solver)
{
    prepare(solver, stage);
    return norm(solver, stage.r);
}

// In place of rounds where the motion is violent.
void go_down(Stage& stage, StepSolver& solver, double start, StepRecord& record)
{
    const Descent how{.target = std::max(stage.frame.options.tolerance, 1e-3) * start};
    if (descend(stage, solver, how, record) != Descended::arrived) record.violent = true;
}

// Whether further rounds are of no use. What parts touch at is not known in the first round: they
// are judged by the last one.
bool is_hopeless(const Stage& stage, const Rounds& rounds, int round)
{
    return round == (rounds.parts ? rounds.most : 0) && is_violent(stage);
}

// Takes w a round on. Returns the norm of what is left over, 0 where nothing touches.
double go_round(Stage& stage, StepSolver& solver, const Rounds& rounds, int round, double size,
                StepRecord& record)
{
    const double goal =
        rounds.parts ? std::max(0.5 * rounds.target, part_accuracy * size) : rounds.target;
    const Solved solved = solve_linear(solver, stage, goal);
    record.report.iterations += solved.iterations;
    if (!solved.converged) record.short_of_iterations = true;
    const bool wary = round >= rounds.first_wary;
    const Aligned<double> from = wary ? stage.w : Aligned<double>();
    const double slope = dot(stage.r, stage.delta);
    for (std::size_t i = 0; i < stage.frame.n; ++i) stage.w[i] += stage.delta[i];
    if (!may_touch(stage) || is_hopeless(stage, rounds, round)) return 0;
    const bool apart = stage.contacts.empty() && stage.colliders.empty();
    place(stage);
    if (!wary) find_touches(stage);
    if (round == rounds.first_wary) hold_loads(stage.touches, stage.x.data());
    stage.wary = round + 1 >= rounds.first_wary;
    stage.contacts = touching(stage);
    if (apart && rounds.one && stage.contacts.empty()) return 0;  // parts that passed by
    if (!rounds.one) linearise_here(stage);
    find_residual(stage);
    if (wary) draw_back(stage, from, slope);
    return measure(stage, solver);
}

// Where the forces balance, looks for more that parts touch at. Returns the norm of what is left
// over then.
double join(Stage& stage, StepSolver& solver, bool again, double size)
{
    if (!find_touches(stage) && again) return size;
    hold_loads(stage.touches, stage.x.data());
    stage.contacts = touching(stage);
    find_residual(stage);
    return measure(stage, solver);
}

// Rounds of Newton's method from what start_rounds() left. `start` is the norm of the forces at
// work there.
void go_rounds(Stage& stage, StepSolver& solver, double size, double start, StepRecord& record)
{
    const StepOptions& options = stage.frame.options;
    const bool parts = !stage.near.empty();
    const int most =
        std::max(options.newton_iterations, may_touch(stage) ? options.contact_iterations : 1);
    const Rounds rounds{options.newton_iterations == 1,
                        parts,
                        parts ? first_wary_round_of_parts : first_wary_round,
                        most,
                        start,
                        options.tolerance * start};
    bool joined = !parts;
    int round = 0;
    for (; round < most && size > rounds.target; ++round) {
        size = go_round(stage, solver, rounds, round, size, record);
        if (!std::isfinite(size)) return;
        if (size <= (joined ? rounds.target : std::max(rounds.target, near_enough * start))) {
            if (parts) size = join(stage, solver, joined, size);
            joined = true;
        }
    }
    if (is_hopeless(stage, rounds, parts ? most : round - 1)) {
        go_down(stage, solver, start, record);
    } else if (size > 1.0001 * rounds.target) {
        record.unsettled = true;
        record.left = std::max(record.left, size / start);
    }
}

}  // namespace

void solve_stage(Stage& stage, StepSolver& solver, StepRecord& record)
{
    const StepOptions& options = stage.frame.options;
    start_rounds(stage, solver);
    const double size = norm(solver, stage.r);
    const AtWork at = at_work(stage);
    if (options.newton_iterations == 1 || may_touch(stage)) {
        go_rounds(stage, solver, size,
                  std::max({size, norm(solver, at.outside), norm(solver, at.elastic)}), record);
        return;
    }
    const Descent how{
        .rounds = options.newton_iterations, .tolerance = options.tolerance, .hessian = true};
    if (descend(stage, solver, how, record) != Descended::arrived) record.unsettled = true;
}

void find_leftover(Stage& stage, StepSolver& solver, StepRecord& record)
{
    place(stage);
    if (!all_finite(stage.x)) return;
    linearise_here(stage);
    find_residual(stage);
    prepare(solver, stage);
    const double size = norm(solver, stage.r);
    const double scale = forces_at_work(stage, solver);
    if (scale > 0) record.report.residual = std::max(record.report.residual, size / scale);
    // A solve in single precision ends within its own rounding of the tolerance.
    const double target = 1.001 * stage.frame.options.tolerance * scale;
    if (!(size <= std::max(target, rounding_of(stage, solver)))) record.report.converged = false;
}

}  // namespace physics
