#include "physics/bricks/free_fall.hpp"

#include "physics/bricks/part_groups.hpp"
#include "physics/bricks/stage_touches.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// A group as a whole, along each axis.
struct Whole {
    Vec3 impulse = Vec3::Zero();  // N s
    Vec3 mass = Vec3::Zero();     // kg
    Vec3 drag = Vec3::Zero();     // kg/s
};

// What each part gains of velocity with its group in the stage, m/s; 0 along axes that hold it.
// With `lifts`, less by the share that drag leaves of the lift (free_fall.hpp).
std::vector<Vec3> gained_by_parts(const Stage& stage, PartGroups& groups, bool lifts)
{
    constexpr double much = 0.25;  // of the velocity, that drag takes in the stage
    const StepFrame& frame = stage.frame;
    const CornerBody& body = frame.body;
    std::vector<Whole> all(groups.held.size());
    for (std::size_t k = 0; k < body.corners; ++k) {
        Whole& whole = all[groups.sets.root(body.part_of(k))];
        for (std::size_t i = 4 * k, a = 0; a < 3; ++i, ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            const double drag = frame.damping[i] + stage.drag[i];
            whole.impulse[axis] +=
                stage.tau * (frame.steady[i] + stage.wind[i] - drag * stage.v0[i]);
            whole.mass[axis] += frame.mass[i];
            whole.drag[axis] += drag;
        }
    }
    const auto held = groups.with_all(groups.held);
    std::vector<Vec3> out(groups.held.size(), Vec3::Zero());
    for (std::uint32_t p = 0; p < out.size(); ++p) {
        const Whole& whole = all[groups.sets.root(p)];
        for (Eigen::Index a = 0; a < 3; ++a) {
            const double taken = stage.tau * whole.drag[a] / whole.mass[a];
            const double share = lifts ? std::clamp(1 - taken / much, 0.0, 1.0) : 1;
            const double gained =
                share * whole.impulse[a] / (whole.mass[a] + stage.tau * whole.drag[a]);
            if ((held[p] >> a & 1) == 0 && std::isfinite(gained)) out[p][a] = gained;
        }
    }
    return out;
}

// Whether any part that gains velocity may touch something.
bool may_meet(const Stage& stage, const std::vector<Vec3>& gained)
{
    return stage.frame.body.sheets || !stage.colliders.empty() ||
           std::any_of(stage.near.begin(), stage.near.end(), [&](const PartPair& pair) {
               return !gained[pair.a].isZero(0) || !gained[pair.b].isZero(0);
           });
}

bool all_zero(const std::vector<Vec3>& gained)
{
    return std::all_of(gained.begin(), gained.end(), [](const Vec3& v) { return v.isZero(0); });
}

}  // namespace

void lift_free_parts(Stage& stage)
{
    stage.lifted.clear();
    if (!stage.turns_start || stage.frame.options.leaps) return;
    const CornerBody& body = stage.frame.body;
    PartGroups groups(stage);
    const std::vector<Vec3> ahead = gained_by_parts(stage, groups, false);
    if (all_zero(ahead)) return;
    if (may_meet(stage, ahead)) {
        Aligned<double> w = stage.w;
        for (std::size_t k = 0; k < body.corners; ++k) {
            Eigen::Map<Vec3>(&w[4 * k]) += 0.5 * ahead[body.part_of(k)];  // where a parabola ends
        }
        groups.add(stage, contacts_ahead(stage, w));
    }
    const std::vector<Vec3> gained = gained_by_parts(stage, groups, true);
    if (all_zero(gained)) return;
    stage.lifted.assign(stage.frame.n, 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        const Vec3 by = -0.5 * stage.tau * gained[body.part_of(k)];
        Eigen::Map<Vec3>(&stage.lifted[4 * k]) = by;
        Eigen::Map<Vec3>(&stage.x0[4 * k]) += by;
    }
}

}  // namespace physics
