#include "physics/bricks/sleep.hpp"

#include "physics/bricks/stage_touches.hpp"
#include "physics/bricks/step_descent.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace physics {

// Of a frame, in those of 1/24 s; longer ones count as these.
static double slowness(double seconds)
{
    return std::min(1.0, 24 * seconds);
}

bool is_still(const CornerBody& body, const Aligned<double>& from, const Aligned<double>& to,
              double seconds)
{
    const double most = still * body.h * slowness(seconds);
    for (std::size_t i = 0; i < body.numbers; ++i) {
        if (!(std::abs(to[i] - from[i]) <= most)) return false;
    }
    return true;
}

// Rigid parts that lie on stiff contacts are out of balance by much where they are off by little.
// Whether those of `parts` would go nowhere to speak of from where they are. The stage is started,
// with velocities 0 and its residual.
static bool hardly_move(Stage& stage, StepSolver& solver, const std::vector<std::uint8_t>& parts)
{
    constexpr int rounds = 20;  // contacts come and go within a nanometre
    constexpr double accuracy = 0.05, small = 0.01;
    const StepFrame& frame = stage.frame;
    double size = norm(solver, stage.r);
    const double target = small * size;
    for (int round = 0; round < rounds && size > target; ++round) {
        if (!solve_linear(solver, stage, accuracy * size).converged) return false;
        const Aligned<double> from = stage.w;
        const double slope = dot(stage.r, stage.delta);
        for (std::size_t i = 0; i < frame.n; ++i) stage.w[i] += stage.delta[i];
        place(stage);
        stage.contacts = touching(stage);
        find_residual(stage);
        if (round > 0) draw_back(stage, from, slope);
        prepare(solver, stage);
        size = norm(solver, stage.r);
    }
    if (!(size <= target)) return false;
    const double slow = slowness(frame.seconds);  // what begins to move goes a way of its square
    const double most = still * frame.body.h / least_steps(frame.options) * slow * slow;
    for (std::size_t k = 0; k < frame.body.corners; ++k) {
        if (parts[frame.body.part_of(k)] == 0) continue;
        for (std::size_t i = 4 * k; i < 4 * k + 3; ++i) {
            if (!(stage.tau * std::abs(stage.w[i]) <= most)) return false;
        }
    }
    return true;
}

bool stays_at_rest(Stage& stage, StepSolver& solver, const Aligned<double>& x,
                   const Aligned<double>& v, StepRecord& record)
{
    const StepFrame& frame = stage.frame;
    if (!pins_stay(stage) || !colliders_stay(frame)) return false;
    start_stage(stage, x, v, frame.seconds / least_steps(frame.options), 1);
    std::fill(stage.w.begin(), stage.w.end(), 0);
    find_forces_at_start(stage);
    prepare(solver, stage);
    const AtWork at = at_work(stage);
    const auto left = norms_of_parts(solver, frame.body, stage.r);
    const auto outside = norms_of_parts(solver, frame.body, at.outside);
    const auto elastic = norms_of_parts(solver, frame.body, at.elastic);
    const double rounding = rounding_of(stage, solver);
    double residual = 0;
    std::vector<std::uint8_t> off(left.size(), 0);
    for (std::size_t p = 0; p < left.size(); ++p) {
        const double scale = std::max(outside[p], elastic[p]);
        // A step ends within the tolerance of the whole, and a part may have more than its share.
        constexpr double share = 2;
        if (!(left[p] <= std::max(share * frame.options.tolerance * scale, rounding))) {
            if (frame.body.rigid.empty() || frame.body.rigid[p] == 0) return false;
            off[p] = 1;
        } else if (scale > 0) {
            residual = std::max(residual, left[p] / scale);
        }
    }
    record.reaction = reactions_of(stage);
    const bool balanced = std::none_of(off.begin(), off.end(), [](auto is) { return is != 0; });
    if (!balanced && !hardly_move(stage, solver, off)) return false;
    record.report.residual = residual;
    return true;
}

}  // namespace physics
