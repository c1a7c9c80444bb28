#include "physics/bricks/bounce.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// Implicit Euler takes vibration off; the other methods keep it, and points have velocities that
// lead nowhere within a step.
bool rings(const Stage& stage)
{
    return stage.frame.options.integrator != Integrator::implicit_euler;
}

// When it hits, s after the stage starts. gap = t (speed + acceleration t / 2): what hits was free
// before.
double time_of_hit(const Coming& in)
{
    const double square = in.speed * in.speed + 2 * in.acceleration * in.gap;
    return 2 * std::max(in.gap, 0.0) / (in.speed + std::sqrt(std::max(0.0, square)));
}

}  // namespace

Vec3 place_of_touch(const PlaneTouch& touch, const Aligned<double>& x)
{
    Vec3 p = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        p +=
            double(touch.weight[a]) * Eigen::Map<const Vec3>(&x[4 * std::size_t{touch.corners[a]}]);
    }
    return p;
}

Vec3 velocity_at(const RigidPart& part, const Vec3& p)
{
    return part.velocity + part.spin.cross(p - part.centre);
}

double Comings::speed_as_a_whole(const PlaneTouch& touch)
{
    if (parts_.empty()) parts_ = rigid_parts(stage_, stage_.x0, stage_.v0);
    const CornerBody& body = stage_.frame.body;
    const Vec3 p = place_of_touch(touch, stage_.x0);
    Vec3 v = velocity_at(parts_[body.part_of(touch.corners[0])], p) - touch.drift;
    if (touch.count > 8) v -= velocity_at(parts_[body.part_of(touch.corners[8])], p);
    return -touch.normal.dot(v);
}

Coming Comings::of(const PlaneTouch& touch)
{
    const Stage& stage = stage_;
    const StepFrame& frame = stage.frame;
    const bool rigid = !stage.rigid.none();  // x0 and v0 turn with them from round to round
    const Aligned<double>&x0 = rigid ? stage.began : stage.x0,
          &v0 = rigid ? stage.began_v : stage.v0;
    const double drift = touch.drift.dot(touch.normal);
    Coming out{touch.gap(x0.data()) + stage.tau * drift, drift, 0};
    for (std::size_t a = 0; a < touch.count; ++a) {
        const std::size_t at = 4 * std::size_t{touch.corners[a]};
        const double weight = double(touch.weight[a]);
        for (std::size_t i = 0; i < 3; ++i) {
            const double along = weight * touch.normal[static_cast<Eigen::Index>(i)];
            out.speed -= along * v0[at + i];
            if (frame.mass[at + i] > 0) {
                out.acceleration -= along * frame.steady[at + i] / frame.mass[at + i];
            }
        }
    }
    if (rings(stage)) out.speed = speed_as_a_whole(touch);
    return out;
}

bool hits(const Stage& stage, const Coming& in)
{
    return in.speed > 2 * stage.span * std::abs(in.acceleration) && time_of_hit(in) < stage.span;
}

void aim_bounces(Stage& stage)
{
    // A point's plane gives way by this share of what its speed changes by.
    constexpr double give = 0.01;
    const CornerBody& body = stage.frame.body;
    Comings comings(stage);
    std::vector<std::size_t> count(stage.frame.part_mass.size(), 0);  // of those that bounce
    const auto for_each = [&](const auto& with) {
        for (auto* touches : {&stage.touches, &stage.holds}) {
            for (PlaneTouch& touch : *touches) with(touch, body.part_of(touch.corners[0]));
        }
    };
    for_each([&](PlaneTouch& touch, std::uint32_t part) {
        if (!rings(stage) && !(touch.bounce > 0)) return;
        const Coming in = comings.of(touch);
        touch.rebound = 0;
        if (!hits(stage, in)) return;
        stage.struck = true;
        if (!(touch.bounce > 0)) return;
        // Steps are split where something hits: it turns back where the stage starts.
        const double leaves = touch.bounce * in.speed - stage.tau * in.acceleration;
        if (leaves > 0) touch.rebound = std::max(0.0, in.gap + stage.tau * leaves);
        if (touch.rebound > 0) ++count[part];
    });
    for_each([&](PlaneTouch& touch, std::uint32_t part) {
        if (!(touch.rebound > 0)) return;
        const double mass = stage.frame.part_mass[part] / static_cast<double>(count[part]);
        touch.stiffness = std::max(touch.stiffness, mass / (give * stage.tau * stage.tau));
    });
}

double first_hit(const Stage& stage)
{
    constexpr double just_before = 0.999;
    double first = stage.tau;
    Comings comings(stage);
    for (const auto* touches : {&stage.touches, &stage.holds}) {
        for (const PlaneTouch& touch : *touches) {
            if (!(touch.rebound > 0)) continue;
            first = std::min(first, just_before * time_of_hit(comings.of(touch)));
        }
    }
    return first;
}

}  // namespace physics
