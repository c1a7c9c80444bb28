#include "physics/layered_bodies/step_length.hpp"

#include "geometry/fields/round_skeleton.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "physics/layered_bodies/net_base.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace physics {

using geometry::Skeleton;
using geometry::SkeletonKind;

namespace {

// A frame's layer on its way through a frame of the film: a ball that goes straight, or a half
// space.
struct Mover {
    Vec3 from = Vec3::Zero();    // m, its middle; a point of a half space's edge
    Vec3 way = Vec3::Zero();     // m, how far that goes
    Vec3 normal = Vec3::Zero();  // of a half space; else 0
    std::uint32_t part = 0;      // of its body: what hangs together by its blend
    double reach = 0;            // m, from the middle to where its influence ends
    double turn = 0;             // rad
    double stray = 0;            // m, how far its points go besides: they turn, or change shape
    Box box;                     // m, that a ball's influence stays in
};

// The box in a frame's axes around the masses of a net that carry it, and in `stray` how much
// farther than the frame one of them goes in dt.
Box box_of_masses(const Base& base, const LayeredState& state, std::size_t f, double dt,
                  double& stray)
{
    const Eigen::Quaterniond back = Eigen::Quaterniond(state.rotation[f]).conjugate();
    Box box;
    for (const std::uint32_t m : masses_of(base, f)) {
        const Vec3 arm = state.position[m] - state.position[f];
        const Vec3 speed = state.velocity[f] + state.spin[f].cross(arm);
        stray = std::max(stray, dt * (state.velocity[m] - speed).norm());
        box.add(back * arm);
    }
    return box;
}

// What these skeletons of a frame take up, in its axes; `plane`: one of them that has no end.
Box box_of(const LayeredBody& body, std::span<const std::uint32_t> skeletons, double& reach,
           const Skeleton*& plane)
{
    Box box;
    for (const std::uint32_t s : skeletons) {
        const Skeleton& skeleton = body.layer.skeletons[s];
        reach = std::max(reach,
                         body.layer.contributions[s].radius * geometry::stretch_of(skeleton).most);
        if (skeleton.kind == SkeletonKind::plane) plane = &skeleton;
        for (const Vec3& p : skeleton.points) box.add(p);
        if (!skeleton.points.empty()) continue;
        Box own;
        const Vec3 half = geometry::half_extent(skeleton.kind, skeleton.half_size);
        own.add(-half);
        own.add(half);
        if (skeleton.mesh) own = geometry::bounds(skeleton.mesh->mesh);
        const Vec3 centre = skeleton.place * own.centre();
        box.add(centre - Vec3::Constant(0.5 * own.diagonal()));
        box.add(centre + Vec3::Constant(0.5 * own.diagonal()));
    }
    return box;
}

// m: how far the parts of a skeleton that changes its shape go at most.
double largest_change(const ShapeChange& change, std::uint32_t s)
{
    const geometry::Skeleton &before = change.before[s], &after = change.after[s];
    double most = (after.half_size - before.half_size).cwiseAbs().maxCoeff();
    for (std::size_t i = 0; i < after.points.size(); ++i) {
        most = std::max(most, (after.points[i] - before.points[i]).norm());
    }
    return most;
}

// `told`: where the frame is to be by the end of dt; null: it goes on as it goes.
Mover mover_of(const LayeredPart& part, const LayeredState& state, std::size_t f,
               std::span<const std::uint32_t> skeletons, const Transform* told, const Vec3& gravity,
               double dt)
{
    Mover mover;
    if (!state.part.empty()) mover.part = state.part[skeletons.front()];
    const Skeleton* plane = nullptr;
    Box box = box_of(*part.body, skeletons, mover.reach, plane);
    const Base& base = part.body->base;
    double change = 0;
    if (f >= mass_count(base)) box = box_of_masses(base, state, f, dt, change);
    const Eigen::Quaterniond now(state.rotation[f]);
    const Vec3 arm = now * (plane ? Vec3(plane->place.translation()) : box.centre());
    mover.from = state.position[f] + arm;
    if (!told) {
        mover.turn = dt * state.spin[f].norm();
        mover.way = dt * (state.velocity[f] + dt * gravity + state.spin[f].cross(arm));
    } else {
        mover.turn = now.angularDistance(Eigen::Quaterniond(told->linear()));
        mover.way = *told * (now.conjugate() * arm) - mover.from;
    }
    if (plane) {
        mover.normal = now * plane->place.linear().col(1);
        return mover;
    }
    mover.reach += 0.5 * box.diagonal();
    mover.stray = 0.5 * box.diagonal() * mover.turn;
    for (const std::uint32_t s : skeletons) {
        if (part.change) change = std::max(change, largest_change(*part.change, s));
    }
    mover.stray += change;
    if (part.mesh_before) {
        const Box before = geometry::bounds(*part.mesh_before);
        const auto& after = part.body->layer.skeletons[0].mesh->mesh.positions;
        mover.from = before.centre();
        mover.way = box.centre() - mover.from;
        mover.reach =
            std::max(mover.reach, mover.reach + 0.5 * (before.diagonal() - box.diagonal()));
        for (std::size_t v = 0; v < after.size(); ++v) {
            const Vec3 way = (after[v] - part.mesh_before->positions[v]).cast<double>();
            mover.stray = std::max(mover.stray, (way - mover.way).norm());
        }
    }
    const Vec3 around = Vec3::Constant(mover.reach + mover.stray);
    for (const Vec3& at : {mover.from, Vec3(mover.from + mover.way)}) {
        mover.box.add(at - around);
        mover.box.add(at + around);
    }
    return mover;
}

// How much nearer a ball may come to another mover in the frame of the film, m; 0 where they stay
// apart.
double approach(const Mover& a, const Mover& b)
{
    if (b.normal.squaredNorm() > 0) {
        const double apart = (a.from - b.from).dot(b.normal) - a.reach - b.reach;
        const double tilt = b.turn * (a.from - b.from).norm();
        const double closing = (b.way - a.way).dot(b.normal) + a.stray + tilt;
        return closing > apart ? std::max(0.0, closing) : 0;
    }
    const bool meet = (a.box.lo.array() <= b.box.hi.array()).all() &&
                      (b.box.lo.array() <= a.box.hi.array()).all();
    return meet ? (a.way - b.way).norm() + a.stray + b.stray : 0;
}

// Of all frames of a body that carry skeletons.
std::vector<Mover> movers_of(LayeredScene& now, std::size_t b, const Vec3& gravity, double dt)
{
    const LayeredBody& body = *now.parts[b].body;
    const LayeredPart& part = now.parts[b];
    const bool all = is_told(body.base.kind);
    std::vector<Transform> told;
    if (all || !part.held.empty()) told = told_frames(part);
    std::vector<std::uint8_t> led(told.size(), all ? 1 : 0);
    for (const HeldFrame& held : part.held) {
        led[held.frame] = 1;
        told[held.frame].pretranslate(held.way);
    }
    const auto on_frame = skeletons_on_frames(body);
    std::vector<Mover> out;
    for (std::size_t f = 0; f < on_frame.size(); ++f) {
        if (on_frame[f].empty()) continue;
        const Transform* const to = f < led.size() && led[f] != 0 ? &told[f] : nullptr;
        out.push_back(mover_of(part, now.states[b], f, on_frame[f], to, gravity, dt));
    }
    return out;
}

}  // namespace

int choose_steps(LayeredScene& now, const Vec3& gravity, double dt, int asked)
{
    constexpr double share = 0.4;
    const int most = most_steps(asked);
    const std::size_t n = now.parts.size();
    std::vector<std::vector<Mover>> movers(n);
    std::vector<double> thinnest(
        n, std::numeric_limits<double>::infinity());  // of layers that may be stopped
    for (std::size_t b = 0; b < n; ++b) {
        const LayeredBody& body = *now.parts[b].body;
        movers[b] = movers_of(now, b, gravity, dt);
        if ((body.matter.rigid && is_told(body.base.kind)) || body.samples.count() == 0) continue;
        for (const geometry::Contribution& c : body.layer.contributions) {
            thinnest[b] = std::min(thinnest[b], c.thickness);
        }
    }
    // How many steps body i, a soft or a moving one, needs beside j; beside itself, its parts.
    const auto needed = [&](std::size_t i, std::size_t j) {
        double most = 0;
        for (const Mover& a : movers[i]) {
            if (a.normal.squaredNorm() > 0) continue;
            for (const Mover& b : movers[j]) {
                if (i != j || a.part != b.part) most = std::max(most, approach(a, b));
            }
        }
        return most / (share * std::min(thinnest[i], thinnest[j]));
    };
    double wanted = asked;
    for (std::size_t i = 0; i < n; ++i) {
        if (!std::isfinite(thinnest[i])) continue;
        for (std::size_t j = 0; j < n; ++j) {
            const bool both_still = now.parts[i].body->base.kind == BaseKind::still &&
                                    now.parts[j].body->base.kind == BaseKind::still;
            if (both_still || (j < i && std::isfinite(thinnest[j]))) continue;
            if (i == j && !now.parts[i].body->matter.self_contact) continue;
            const double steps = needed(i, j);
            if (steps > most) {
                const std::string who = i == j ? fmt::format("Parts of body {}", i)
                                               : fmt::format("Bodies {} and {}", i, j);
                now.states[i].report.warnings.push_back(
                    fmt::format("{} may tunnel: they approach by {:.2g} layer "
                                "thicknesses per step, "
                                "even with {} steps per frame. Slow them down or raise substeps.",
                                who, share * steps / most, most));
            }
            wanted = std::max(wanted, std::min<double>(steps, most));
        }
    }
    return static_cast<int>(std::ceil(wanted));
}

bool comes_on(LayeredScene& now, double dt, double speed)
{
    const std::size_t n = now.parts.size();
    std::vector<std::vector<Mover>> movers(n);
    for (std::size_t b = 0; b < n; ++b) movers[b] = movers_of(now, b, Vec3::Zero(), dt);
    const auto fast = [&](const Mover& a, const Mover& b) {
        return !(a.normal.squaredNorm() > 0) && approach(a, b) > speed * dt;
    };
    for (std::size_t i = 0; i < n; ++i) {
        if (now.parts[i].body->base.kind != BaseKind::rigid) continue;
        for (std::size_t j = 0; j < n; ++j) {
            const BaseKind kind = now.parts[j].body->base.kind;
            const bool both = kind == BaseKind::rigid;
            if (i == j || (both && j < i) || !(both || kind == BaseKind::still)) continue;
            for (const Mover& a : movers[i]) {
                for (const Mover& b : movers[j]) {
                    if (fast(a, b)) return true;
                }
            }
        }
    }
    return false;
}

int most_steps(int asked)
{
    constexpr int times = 64;
    return asked < std::numeric_limits<int>::max() / times ? times * asked
                                                           : std::numeric_limits<int>::max();
}

ExplicitSteps explicit_steps(const LayeredScene& now, const LayeredSystem& system, double dt)
{
    constexpr double share = 0.3;
    ExplicitSteps wanted;
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        for (std::size_t f = 0; f < now.states[b].position.size(); ++f) {
            if (!system.held[system.frame(b, f)]) continue;
            const Rates rates = held_rates(system, system.frame(b, f));
            const double fastest =
                std::max({rates.frequency, rates.decay, now.states[b].spin[f].norm()});
            if (dt * fastest / share > wanted.steps) wanted = {dt * fastest / share, b};
        }
    }
    return wanted;
}

}  // namespace physics
