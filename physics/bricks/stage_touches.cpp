#include "physics/bricks/stage_touches.hpp"

#include "physics/body/external_forces.hpp"
#include "physics/bricks/bounce.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// What colliders touch at x when corners came there at stage.w.
std::vector<PlaneTouch> find_holds(const Stage& stage, const Aligned<double>& x)
{
    const CornerBody& body = stage.frame.body;
    auto found = find_collider_touches(body, x.data(), stage.w.data(), stage.colliders, stage.held,
                                       stage.tau);
    take_grips(found, stage.held);
    return found;
}

}  // namespace

void start_stage(Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0, double tau,
                 double share)
{
    const StepFrame& frame = stage.frame;
    const Loads& loads = frame.loads;
    stage.tau = tau;
    stage.share = share;
    stage.x0 = x0, stage.v0 = v0;
    stage.base.clear();
    stage.struck = false;
    std::fill(stage.wind.begin(), stage.wind.end(), 0);
    std::fill(stage.drag.begin(), stage.drag.end(), 0);
    if (frame.windy) {
        add_wind(frame.body, loads.forces, x0.data(), v0.data(), stage.wind, stage.drag);
    }
    stage.colliders.clear();
    for (const Collider& c : loads.colliders) {
        stage.colliders.push_back(
            pose_collider(c, share, frame.seconds, frame.body.greatest_edge, frame.first));
    }
    stage.near.clear();
    stage.touches.clear();
    stage.holds.clear();
    if (frame.body.shapes) {
        stage.near = near_parts(*frame.body.shapes, x0.data(), v0.data(), tau);
        stage.touches = find_part_touches(*frame.body.shapes, stage.near, x0.data(), v0.data(), tau,
                                          Look::ahead);
        take_grips(stage.touches, stage.grips);
    }
    if (!stage.colliders.empty()) {
        stage.w.assign(frame.n, 0);
        stage.holds = find_holds(stage, x0);
    }
    aim_bounces(stage);
    stage.looked_at = x0;
    stage.w = v0;
    for (std::size_t i = 0; i < loads.pins.corner.size(); ++i) {
        const std::size_t at = 4 * frame.body.slot_of(loads.pins.corner[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            stage.w[at + k] = (pin_target(frame, i, k, share) - x0[at + k]) / tau;
        }
    }
}

bool find_touches(Stage& stage, Known known)
{
    constexpr double much = 0.01;               // cubes
    constexpr double far = 0.5 * known_before;  // cubes: both of a pair may have moved so far
    if (!may_touch(stage)) return false;
    const double h = stage.frame.body.h;
    double moved = 0;
    for (std::size_t i = 0; i < stage.frame.n; ++i) {
        moved = std::max(moved, std::abs(stage.x[i] - stage.looked_at[i]));
    }
    if (moved <= far * h) return false;
    stage.looked_at = stage.x;
    bool changed = false;
    if (!stage.near.empty()) {
        auto found = find_part_touches(*stage.frame.body.shapes, stage.near, stage.x.data(),
                                       stage.w.data(), stage.tau, Look::back);
        take_grips(found, stage.grips);
        changed = add_found(stage.touches, found, stage.x.data(), much * h);
    }
    if (!stage.colliders.empty()) {
        const auto found = find_holds(stage, stage.x);
        changed |= known == Known::kept ? add_found(stage.holds, found, stage.x.data(), much * h)
                                        : renew(stage.holds, found, stage.x.data(), much * h);
    }
    aim_bounces(stage);
    return changed;
}

std::vector<PointContact> touching(const Stage& stage)
{
    constexpr double nearly = 0.95;  // the derivative itself may leave a slip with no resistance
    const double tangent = stage.wary ? nearly : 0;
    auto out = press(stage.holds, stage.x.data(), stage.w.data(), stage.tau, tangent);
    if (stage.touches.empty()) return out;
    const auto parts = press(stage.touches, stage.x.data(), stage.w.data(), stage.tau, tangent);
    out.insert(out.end(), parts.begin(), parts.end());
    return out;
}

void hold_loads(Stage& stage)
{
    hold_loads(stage.touches, stage.x.data());
    hold_loads(stage.holds, stage.x.data());
}

}  // namespace physics
