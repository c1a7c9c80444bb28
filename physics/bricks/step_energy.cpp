#include "physics/bricks/step_energy.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/bricks/stage_touches.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace physics {
namespace {

// Elastic energy; what is left of it is lost of the stage's linearisation.
double elastic(Stage& stage, const Aligned<double>& x)
{
    stage.linear_at.clear();
    return stage.elasticity.energy(x.data());
}

// Of motion and of the forces that do not change.
double kinetic(const Stage& stage, const Aligned<double>& v)
{
    Aligned<double> momentum;
    times_mass(stage, v, momentum);
    return 0.5 * dot(momentum, v);
}
double steady(const StepFrame& frame, const Aligned<double>& x)
{
    double sum = 0;
    for (std::size_t i = 0; i < frame.n; ++i) sum -= frame.steady[i] * (x[i] - frame.start[i]);
    return sum;
}
double weight(const StepFrame& frame)
{
    Vec3 sum = Vec3::Zero();  // N
    for (std::size_t i = 0; i + 3 < frame.n; i += 4) {
        sum += Vec3(frame.steady[i], frame.steady[i + 1], frame.steady[i + 2]);
    }
    return sum.norm();
}
double others(const Stage& stage, const Aligned<double>& x, const Aligned<double>& v)
{
    return kinetic(stage, v) + steady(stage.frame, x);
}

bool is_known(const Stage& stage)
{
    const StepFrame& frame = stage.frame;
    return !frame.windy && pins_stay(stage);
}

}  // namespace

EnergyAccount open_account(Stage& stage, const Aligned<double>& x, const Aligned<double>& v,
                           double owed)
{
    if (!is_known(stage)) return {};
    return {true, elastic(stage, x) + others(stage, x, v) - owed, owed};
}

void take_forces(EnergyAccount& account, StepFrame& frame, const Aligned<double>& x, double share)
{
    if (!any_change(frame.loads.forces)) return;
    const double before = steady(frame, x);
    frame.take_forces(share);
    account.due += steady(frame, x) - before;
}

void charge_damping(EnergyAccount& account, Stage& stage, double seconds)
{
    if (!account.known) return;
    const StepFrame& frame = stage.frame;
    Aligned<double> u = stage.w;
    for (std::size_t i = 0; i < stage.base.size(); ++i) u[i] -= stage.base[i];
    stage.elasticity.weigh(0, 1);
    stage.elasticity.multiply(u.data(), stage.product.data());
    double power = 0;
    for (std::size_t i = 0; i < frame.n; ++i) power += u[i] * stage.product[i];
    if (!frame.body.mass_damping.empty()) {
        times_damping(stage, stage.w, stage.momentum);
        power += dot(stage.momentum, stage.w);
    }
    account.due -= seconds * power;
}

bool settle(EnergyAccount& account, Stage& stage, const Aligned<double>& x, Aligned<double>& v)
{
    if (!account.known) return true;
    const StepFrame& frame = stage.frame;
    const double stored = elastic(stage, x);
    const double excess = stored + others(stage, x, v) - account.due;
    // A part that touches something turns as freely as before: for this, nothing holds it.
    std::vector<PointContact> contacts = std::exchange(stage.contacts, {});
    const Aligned<double> u = deforming(stage, x, v);
    stage.contacts = std::move(contacts);
    const double moving = kinetic(stage, u), whole = kinetic(stage, v);
    const double much = 0.1 * (stored + moving) + 1e-4 * whole;
    account.owed = 0;
    if (!stage.contacts.empty() && (excess <= 0 || !colliders_stay(frame))) {
        account.due += excess;
        return true;
    }
    const double share_sq = 1 - excess / moving;
    if (share_sq >= 0.5 && share_sq <= 2) {
        const double change = std::sqrt(share_sq) - 1;
        for (std::size_t i = 0; i < frame.n; ++i) v[i] += change * u[i];
        return true;
    }
    account.owed = excess;
    return !(excess > much);
}

namespace {

// 1 for parts that another one presses, or themselves, where the stage ends.
std::vector<std::uint8_t> pressed_parts(const Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    std::vector<std::uint8_t> out(stage.frame.part_mass.size(), 0);
    for (const PlaneTouch& touch : stage.touches) {
        if (!(touch.depth(stage.x.data()) > 0)) continue;
        out[body.part_of(touch.corners[0])] = 1;
        out[body.part_of(touch.corners[8])] = 1;
    }
    return out;
}

// Parts that press each other, by sets, and whether a pin holds one of a set.
struct PressedSets {
    std::vector<std::uint32_t> set;  // of each part; no_index: nothing presses it
    std::vector<std::uint8_t> held;  // of each set
};

PressedSets pressed_sets(const Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    const std::size_t parts = stage.frame.part_mass.size();
    geometry::UnionFind sets(parts);
    const std::vector<std::uint8_t> pressed = pressed_parts(stage);
    std::vector<std::uint8_t> held = axes_of_parts(stage.frame.loads.pins, body);
    held.resize(parts);
    for (const PlaneTouch& touch : stage.touches) {
        if (!(touch.depth(stage.x.data()) > 0)) continue;
        sets.join(static_cast<std::uint32_t>(body.part_of(touch.corners[0])),
                  static_cast<std::uint32_t>(body.part_of(touch.corners[8])));
    }
    PressedSets out{sets.roots(), std::vector<std::uint8_t>(parts, 0)};
    for (std::size_t p = 0; p < parts; ++p) {
        if (pressed[p] != 0 && held[p] != 0) out.held[out.set[p]] = 1;
        if (pressed[p] == 0) out.set[p] = geometry::no_index;
    }
    return out;
}

// Whether a body of cubes is pressed by a collider where the stage ends.
bool presses_colliders(const Stage& stage)
{
    if (has_sheets(stage.frame.body)) return false;
    return std::any_of(stage.holds.begin(), stage.holds.end(),
                       [&](const PlaneTouch& touch) { return touch.depth(stage.x.data()) > 0; });
}

bool presses_parts(const Stage& stage)
{
    const auto pressed = pressed_parts(stage);
    return std::any_of(pressed.begin(), pressed.end(), [](auto p) { return p != 0; });
}

// What slack lets out in the stage (plane_touch.hpp) rises, and gets its speed, J. What comes out
// faster was driven in.
double let_out(const Stage& stage, double mass)
{
    double way = 0;  // m
    for (const auto* touches : {&stage.touches, &stage.holds}) {
        for (const PlaneTouch& touch : *touches) {
            if (!(touch.slack > 0 && touch.depth(stage.x.data()) > 0)) continue;
            const double deep = depth_at_start(stage, touch), out = deep - touch.slack;
            const bool driven_in = out > 2 * stage.tau * slack_speed(deep);
            if (!driven_in) way = std::max(way, out);
        }
    }
    const double speed = way / stage.tau;
    return way * weight(stage.frame) + mass * speed * speed;
}

}  // namespace

double gained_by_touching(Stage& stage, const Aligned<double>& x, const Aligned<double>& v,
                          const Aligned<double>& after_x, const Aligned<double>& after_v)
{
    constexpr double little = 0.02;
    constexpr double slow = 0.005;  // m/s
    constexpr double risen = 0.01;  // cubes, that what landed too deep comes out by
    const StepFrame& frame = stage.frame;
    if ((stage.touches.empty() && stage.holds.empty()) || frame.windy) return 0;
    if (!pins_stay(stage) || !colliders_stay(frame)) return 0;
    if (!presses_parts(stage) && !presses_colliders(stage)) return 0;
    const double before = elastic(stage, x) + kinetic(stage, v);
    const double after = elastic(stage, after_x) + kinetic(stage, after_v);
    const double gain = after - before + steady(frame, after_x) - steady(frame, x);
    // Sheets and rigid parts that rest have next to no energy of their own.
    const double mass = std::accumulate(frame.part_mass.begin(), frame.part_mass.end(), 0.0);
    const bool may_rest = has_sheets(frame.body) || !stage.rigid.none();
    const double rising = stage.rigid.none() ? 0 : risen * frame.body.h * weight(frame);
    const double least = (may_rest ? 0.5 * mass * slow * slow + rising : 0) + let_out(stage, mass);
    // What starts from rest has none before, and a rounding error would be more than that.
    return gain > std::max(least, little * std::max(before, after)) ? gain : 0;
}

bool take_off(const Stage& stage, double gained, Aligned<double>& v)
{
    const CornerBody& body = stage.frame.body;
    const PressedSets pressed = pressed_sets(stage);
    const auto at = [&](std::size_t k) { return Eigen::Map<Vec3>(&v[4 * k]); };
    std::vector<double> mass(pressed.held.size(), 0);
    std::vector<Vec3> mean(pressed.held.size(), Vec3::Zero());
    const auto for_each = [&](const auto& with) {
        for (std::size_t k = 0; k < body.corners; ++k) {
            const std::uint32_t set = pressed.set[body.part_of(k)];
            if (set != geometry::no_index) with(k, set);
        }
    };
    for_each([&](std::size_t k, std::uint32_t set) {
        mass[set] += body.mass[k];
        mean[set] += body.mass[k] * at(k);
    });
    for (std::size_t set = 0; set < mean.size(); ++set) {
        const bool moves_freely = pressed.held[set] == 0 && mass[set] > 0;
        mean[set] *= moves_freely ? 1 / mass[set] : 0;  // a pin takes the momentum
    }
    double moving = 0;
    for_each([&](std::size_t k, std::uint32_t set) {
        moving += 0.5 * body.mass[k] * (at(k) - mean[set]).squaredNorm();
    });
    if (!(moving > 0)) return false;
    const double share = std::sqrt(std::max(0.0, 1 - gained / moving));
    for_each(
        [&](std::size_t k, std::uint32_t set) { at(k) = mean[set] + share * (at(k) - mean[set]); });
    return moving >= gained;
}

}  // namespace physics
