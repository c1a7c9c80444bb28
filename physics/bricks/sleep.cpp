#include "physics/bricks/sleep.hpp"

#include "physics/bricks/stage_touches.hpp"
#include "physics/bricks/step_descent.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

bool is_still(const CornerBody& body, const Aligned<double>& from, const Aligned<double>& to)
{
    const double most = still * body.h;
    for (std::size_t i = 0; i < body.numbers; ++i) {
        if (!(std::abs(to[i] - from[i]) <= most)) return false;
    }
    return true;
}

bool stays_at_rest(Stage& stage, StepSolver& solver, const Aligned<double>& x,
                   const Aligned<double>& v, StepRecord& record)
{
    const StepFrame& frame = stage.frame;
    if (!pins_stay(stage) || !colliders_stay(frame)) return false;
    start_stage(stage, x, v, frame.seconds / frame.options.substeps, 1);
    if (stage.struck) return false;
    std::fill(stage.w.begin(), stage.w.end(), 0);
    find_forces_at_start(stage);
    prepare(solver, stage);
    const AtWork at = at_work(stage);
    const auto left = norms_of_parts(solver, frame.body, stage.r);
    const auto outside = norms_of_parts(solver, frame.body, at.outside);
    const auto elastic = norms_of_parts(solver, frame.body, at.elastic);
    const double rounding = rounding_of(stage, solver);
    double residual = 0;
    for (std::size_t p = 0; p < left.size(); ++p) {
        const double scale = std::max(outside[p], elastic[p]);
        // A step ends within the tolerance of the whole, and a part may have more than its share.
        constexpr double share = 2;
        if (!(left[p] <= std::max(share * frame.options.tolerance * scale, rounding))) return false;
        if (scale > 0) residual = std::max(residual, left[p] / scale);
    }
    record.report.residual = residual;
    record.reaction = reactions_of(stage);
    return true;
}

}  // namespace physics
