#include "physics/bricks/pinned_parts.hpp"

#include "physics/bricks/free_parts.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

namespace physics {
namespace {

using geometry::Mat3;

Eigen::Map<Vec3> at_slot(Aligned<double>& v, std::size_t k)
{
    return Eigen::Map<Vec3>(&v[4 * k]);
}

// The pins of a part, where they are and where the stage takes them.
struct PinsOfPart {
    std::vector<std::size_t> slot;  // of corners that are fixed
    std::vector<Vec3> from, to;     // m, of these and of what springs hold
};

// How a part turns about its pins.
struct Pivot {
    Vec3 place = Vec3::Zero();     // m, where they are
    Vec3 velocity = Vec3::Zero();  // m/s
    Vec3 axis = Vec3::Zero();      // unit; 0: about the point, along any
    double most = 0;               // rad, that its pins turn it by; 0: it turns as it does
};

// Of parts whose pins all hold every axis, which are elastic and touch nothing.
std::map<std::uint32_t, PinsOfPart> pinned(const Stage& stage)
{
    const StepFrame& frame = stage.frame;
    const CornerBody& body = frame.body;
    const Pins& pins = frame.loads.pins;
    std::vector<std::uint8_t> out_of_it(std::max<std::size_t>(body.parts, 1), 0);
    for (const PointContact& c : stage.contacts) {
        for (std::size_t a = 0; a < c.count; a += 8) out_of_it[body.part_of(c.corners[a])] = 1;
    }
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) out_of_it[stage.rigid.part(i)] = 1;
    const bool driven = stage.elasticity.targets_move();
    for (const HeldCube& cube : pins.matter.cubes) {
        if (driven && cube.axes == all_axes) continue;
        out_of_it[body.part_of(body.slot_of(pins.matter.corner[cube.corner[0]]))] = 1;
    }
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        if (held_axes(pins, p) == all_axes) continue;
        out_of_it[body.part_of(body.slot_of(pins.corner[p]))] = 1;
    }
    std::map<std::uint32_t, PinsOfPart> out;
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const std::size_t slot = body.slot_of(pins.corner[p]);
        const std::uint32_t part = body.part_of(slot);
        if (out_of_it[part] != 0) continue;
        PinsOfPart& of = out[part];
        of.slot.push_back(slot);
        of.from.emplace_back(Eigen::Map<const Vec3>(&stage.x0[4 * slot]));
        of.to.push_back(frame.pin_paths.at(p, stage.share));
    }
    if (!driven) return out;
    const auto to = stage.elasticity.targets(stage.share);
    const auto from = stage.elasticity.targets(stage.share - stage.tau / frame.seconds);
    for (std::size_t i = 0; i < to.size(); ++i) {
        const std::uint32_t part = body.part_of(body.slot_of(pins.matter.corner[i]));
        if (out_of_it[part] != 0) continue;
        PinsOfPart& of = out[part];
        of.from.push_back(from[i]);
        of.to.push_back(to[i]);
    }
    return out;
}

Vec3 mean_place(const std::vector<Vec3>& of)
{
    Vec3 sum = Vec3::Zero();
    for (const Vec3& v : of) sum += v;
    return sum / static_cast<double>(of.size());
}

// The turn that takes the pins nearest to where they go.
Eigen::AngleAxisd turn_between(const PinsOfPart& pins, const Vec3& from, const Vec3& to)
{
    Mat3 sum = Mat3::Zero();
    for (std::size_t i = 0; i < pins.from.size(); ++i) {
        sum += (pins.to[i] - to) * (pins.from[i] - from).transpose();
    }
    const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
    return Eigen::AngleAxisd(Mat3(u * svd.matrixV().transpose()));
}

// `edge`: m, of a cube. None: its pins keep the part from turning.
std::optional<Pivot> pivot_of(const PinsOfPart& pins, double tau, double edge)
{
    constexpr double nearly = 1e-3;  // cubes
    Pivot out;
    out.place = mean_place(pins.from);
    const Vec3 to = mean_place(pins.to);
    out.velocity = (to - out.place) / tau;
    Mat3 scatter = Mat3::Zero();
    bool shifted = true;
    for (std::size_t i = 0; i < pins.from.size(); ++i) {
        const Vec3 arm = pins.from[i] - out.place;
        scatter += arm * arm.transpose() / static_cast<double>(pins.from.size());
        shifted &= (pins.to[i] - to - arm).norm() < nearly * edge;
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(scatter);
    const double least = nearly * nearly * edge * edge;
    if (shifted && eigen.eigenvalues()[2] < least) return out;
    if (eigen.eigenvalues()[1] < least) {
        if (!shifted) return std::nullopt;  // a line that turns
        out.axis = eigen.eigenvectors().col(2);
        return out;
    }
    const Eigen::AngleAxisd turn = turn_between(pins, out.place, to);
    if (!(turn.angle() > 1e-6)) return std::nullopt;
    out.axis = turn.axis();
    out.most = turn.angle();
    return out;
}

// About the pivot, kg m^2 and N m s.
struct AboutPivot {
    Mat3 inertia;
    Vec3 momentum;
};
AboutPivot about(const RigidPart& part, const Vec3& place, const Vec3& velocity)
{
    const Vec3 arm = part.centre - place;
    return {part.inertia +
                part.mass * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose()),
            part.momentum + part.mass * arm.cross(part.velocity - velocity)};
}

// What gives the part an angular momentum about the pivot, rad/s.
Vec3 spin_for(const AboutPivot& part, const Vec3& momentum, const Pivot& pivot)
{
    if (pivot.axis.isZero(0)) return spin_of(part.inertia, momentum);
    const double inertia = pivot.axis.dot(part.inertia * pivot.axis);
    if (!(inertia > 0)) return Vec3::Zero();
    return pivot.axis * (pivot.axis.dot(momentum) / inertia);
}

// As it turns in the stage, rad/s.
Vec3 spin_in_stage(const AboutPivot& part, const Pivot& pivot, double tau)
{
    const Vec3 own = spin_for(part, part.momentum, pivot);
    if (!(pivot.most > 0)) return own;
    return pivot.axis * (std::clamp(tau * own.dot(pivot.axis), 0.0, pivot.most) / tau);
}

struct Turning {
    Pivot pivot;
    Vec3 spin;
    Mat3 by;
    Vec3 due = Vec3::Zero();  // N m s, about the pivot where it ends
};

Vec3 force_on(const Stage& stage, std::size_t k)
{
    const Eigen::Map<const Vec3> steady(&stage.frame.steady[4 * k]), wind(&stage.wind[4 * k]);
    return steady + wind;
}

}  // namespace

void turn_pinned_parts(Stage& stage)
{
    constexpr double least = 1e-6, most = std::numbers::pi;  // rad, as of free parts
    const CornerBody& body = stage.frame.body;
    if (!stage.turns_start || stage.frame.options.leaps || has_sheets(body)) return;
    const auto pins = pinned(stage);
    const double tau = stage.tau;
    std::map<std::uint32_t, Turning> turning;
    std::vector<RigidPart> parts;
    for (const auto& [part, its_pins] : pins) {
        const auto pivot = pivot_of(its_pins, tau, body.h);
        if (!pivot) continue;
        if (parts.empty()) parts = rigid_parts(stage, stage.x0, stage.v0);
        const AboutPivot here = about(parts[part], pivot->place, pivot->velocity);
        const Vec3 spin = spin_in_stage(here, *pivot, tau);
        const double angle = tau * spin.norm();
        if (!(angle > least && angle < most)) continue;
        const Mat3 by = Eigen::AngleAxisd(angle, spin.normalized()).toRotationMatrix();
        turning.insert({part, {*pivot, spin, by, here.momentum}});
    }
    if (turning.empty()) return;
    if (stage.base.empty()) stage.base.assign(stage.frame.n, 0);
    Aligned<double> turned = stage.x0;
    for (std::size_t k = 0; k < body.corners; ++k) {
        const auto found = turning.find(body.part_of(k));
        if (found == turning.end()) continue;
        auto& [pivot, spin, by, due] = found->second;
        const Vec3 from = at_slot(stage.x0, k), arm = by * (from - pivot.place);
        const Vec3 to = pivot.place + tau * pivot.velocity + arm;
        const Vec3 velocity = pivot.velocity + spin.cross(arm);
        at_slot(stage.w, k) += velocity - pivot.velocity - spin.cross(from - pivot.place);
        at_slot(stage.x0, k) = to - tau * velocity;
        at_slot(stage.base, k) = velocity;
        at_slot(turned, k) = to;
        // The stage's forces have the arms of its end.
        due += tau * (from - pivot.place - arm).cross(force_on(stage, k));
    }
    const auto there = rigid_parts(stage, turned, stage.v0);
    std::map<std::uint32_t, Vec3> change;
    for (const auto& [part, turn] : turning) {
        const Vec3 place = turn.pivot.place + tau * turn.pivot.velocity;
        const AboutPivot has = about(there[part], place, turn.pivot.velocity);
        change[part] = spin_for(has, turn.due - has.momentum, turn.pivot);
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const auto found = turning.find(body.part_of(k));
        if (found == turning.end()) continue;
        const Pivot& pivot = found->second.pivot;
        const Vec3 arm = at_slot(turned, k) - pivot.place - tau * pivot.velocity;
        at_slot(stage.v0, k) += change[found->first].cross(arm);
    }
    for (const auto& [part, its_pins] : pins) {
        for (std::size_t i = 0; i < its_pins.slot.size(); ++i) {
            const std::size_t slot = its_pins.slot[i];
            at_slot(stage.w, slot) = (its_pins.to[i] - at_slot(stage.x0, slot)) / tau;
        }
    }
}

}  // namespace physics
