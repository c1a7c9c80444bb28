#include "physics/bricks/step_newton.hpp"

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/step_descent.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// Most contacts settle in a few rounds with steps that never reverse a slip. From this round on
// steps take friction nearly by its derivative, and are shortened where they go too far.
constexpr int first_wary_round = 3;

// Contacts of parts with each other come and go: rounds are many and need not be exact, and of
// those that do not settle in so many few ever do.
constexpr int part_rounds = 10;
constexpr double part_accuracy = 0.1;

// Free corners set off as the steady forces have them, unless they then touch something.
void fall(Stage& stage)
{
    const StepFrame& frame = stage.frame;
    for (std::size_t i = 0; i < frame.n; ++i) {
        if (frame.mass[i] > 0) stage.w[i] += stage.tau * frame.steady[i] / frame.mass[i];
    }
    place(stage);
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
    if (!stage.base.empty()) stage.contacts = touching(stage);
    const bool free = stage.frame.loads.pins.corner.empty() && stage.contacts.empty();
    if (free) fall(stage);
    find_residual(stage);
    prepare(solver, stage);
}

// Rounds of Newton's method from what start_rounds() left. `start` is the norm of the forces at
// work there.
void go_round(Stage& stage, StepSolver& solver, double size, double start, StepRecord& record)
{
    const StepOptions& options = stage.frame.options;
    const double target = options.tolerance * start;
    const bool one = options.newton_iterations == 1;
    const bool parts = !stage.near.empty();
    const int most =
        parts ? std::min(options.contact_iterations, part_rounds) : options.contact_iterations;
    const int rounds = std::max(options.newton_iterations, may_touch(stage) ? most : 1);
    Aligned<double> from;  // w before a wary round
    for (int round = 0; round < rounds && size > target; ++round) {
        stage.wary = round + 1 >= first_wary_round;  // of what touches after this round's step
        const double goal = parts ? std::max(0.5 * target, part_accuracy * size) : target;
        const Solved solved = solve_linear(solver, stage, goal);
        record.report.iterations += solved.iterations;
        if (round >= first_wary_round) from = stage.w;
        const double slope = dot(stage.r, stage.delta);
        for (std::size_t i = 0; i < stage.frame.n; ++i) stage.w[i] += stage.delta[i];
        if (!solved.converged) record.short_of_iterations = true;
        if (round == 0 && is_violent(stage)) {
            const Descent how{.target = std::max(options.tolerance, 1e-3) * start};
            if (descend(stage, solver, how, record) != Descended::arrived) record.violent = true;
            return;
        }
        if (!may_touch(stage)) return;  // linear forces alone: solved
        const bool apart = stage.contacts.empty() && stage.colliders.empty();
        place(stage);
        stage.contacts = touching(stage);
        if (apart && one && stage.contacts.empty()) return;  // parts that passed each other by
        if (!one) linearise_here(stage);
        find_residual(stage);
        if (round >= first_wary_round) draw_back(stage, from, slope);
        prepare(solver, stage);
        size = norm(solver, stage.r);
        if (!std::isfinite(size)) return;
    }
    if (size <= 1.0001 * target) return;
    record.unsettled = true;
    record.left = std::max(record.left, size / start);
}

}  // namespace

void solve_stage(Stage& stage, StepSolver& solver, StepRecord& record)
{
    const StepOptions& options = stage.frame.options;
    start_rounds(stage, solver);
    const double size = norm(solver, stage.r);
    const AtWork at = at_work(stage);
    if (options.newton_iterations == 1 || may_touch(stage)) {
        go_round(stage, solver, size,
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
