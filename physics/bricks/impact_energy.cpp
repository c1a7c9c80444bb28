#include "physics/bricks/impact_energy.hpp"

#include "geometry/base/union_find.hpp"
#include "physics/bricks/stage_touches.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// N s, N m s about the centre where a part began.
struct Momenta {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};

// Of each part: what acts from outside in the stage.
std::vector<Momenta> given_from_outside(const Stage& stage, const Aligned<double>& x,
                                        const std::vector<RigidPart>& before)
{
    const StepFrame& frame = stage.frame;
    std::vector<Momenta> out(before.size());
    for (std::size_t k = 0; k < frame.body.corners; ++k) {
        const std::uint32_t part = frame.body.part_of(k);
        Vec3 force;
        for (std::size_t a = 0, i = 4 * k; a < 3; ++a, ++i) {
            force[static_cast<Eigen::Index>(a)] =
                frame.steady[i] + stage.wind[i] - (frame.damping[i] + stage.drag[i]) * stage.w[i];
        }
        const Vec3 arm = Eigen::Map<const Vec3>(&x[4 * k]) - before[part].centre;
        out[part].linear += stage.tau * force;
        out[part].angular += stage.tau * arm.cross(force);
    }
    return out;
}

// Parts that push each other or are joined, by the first of them.
struct PushedGroups {
    PushedGroups(const Stage& stage, std::span<const Push> pushes);

    std::vector<std::uint32_t> of;   // of each part
    std::vector<std::uint8_t> kept;  // of each of these: its energy is
    std::vector<std::uint8_t> free;  // likewise: no collider touches it
    std::vector<std::uint8_t> hit;   // likewise: something hits a part of it
};

PushedGroups::PushedGroups(const Stage& stage, std::span<const Push> pushes)
    : kept(stage.frame.body.parts, 0), free(kept.size(), 1), hit(kept.size(), 0)
{
    const CornerBody& body = stage.frame.body;
    geometry::UnionFind sets(body.parts);
    std::vector<std::uint32_t> on_colliders;
    const auto join = [&](const auto& contact) {
        const std::uint32_t part = body.part_of(contact.corners[0]);
        if (contact.count > 8) {
            sets.join(part, body.part_of(contact.corners[8]));
        } else {
            on_colliders.push_back(part);
        }
    };
    for (const PointContact& contact : stage.contacts) join(contact);
    for (const Push& push : pushes) join(*push.touch);
    of = sets.roots();
    for (const std::uint32_t part : on_colliders) free[of[part]] = 0;
    for (const Push& push : pushes) {
        const std::uint32_t group = of[body.part_of(push.touch->corners[0])];
        kept[group] = 1;
        if (push.hits) hit[group] = 1;
    }
    const auto held = axes_of_parts(stage.frame.loads.pins, body);
    for (std::size_t p = 0; p < body.parts; ++p) {
        if (body.rigid[p] == 0 || held[p] != 0) kept[of[p]] = 0;
    }
}

// J, of colliders that move, by the contacts of each group.
std::vector<double> work_of_colliders(const Stage& stage, const PushedGroups& groups,
                                      const Aligned<double>& x)
{
    std::vector<double> out(groups.of.size(), 0);
    const Aligned<double> v = mean_velocities(stage);
    for (const PlaneTouch& touch : stage.holds) {
        if (touch.drift.isZero(0)) continue;
        for (const PointContact& c : press({touch}, x.data(), v.data(), stage.tau, 0)) {
            const auto part = stage.frame.body.part_of(touch.corners[0]);
            out[groups.of[part]] += stage.tau * c.force.dot(touch.drift);
        }
    }
    return out;
}

// Of each group: as one rigid body with these momenta of its parts.
std::vector<RigidPart> as_one(const PushedGroups& groups, const std::vector<RigidPart>& parts,
                              const std::vector<Momenta>& momenta)
{
    std::vector<RigidPart> out(parts.size());
    for (std::size_t p = 0; p < parts.size(); ++p) {
        RigidPart& group = out[groups.of[p]];
        group.mass += parts[p].mass;
        group.centre += parts[p].mass * parts[p].centre;
        group.velocity += momenta[p].linear;
    }
    for (RigidPart& group : out) {
        if (group.mass > 0) group.centre /= group.mass, group.velocity /= group.mass;
    }
    for (std::size_t p = 0; p < parts.size(); ++p) {
        RigidPart& group = out[groups.of[p]];
        const Vec3 arm = parts[p].centre - group.centre;
        const Mat3 about = arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose();
        group.inertia += parts[p].inertia + parts[p].mass * about;
        group.momentum += momenta[p].angular + arm.cross(momenta[p].linear);
    }
    for (RigidPart& group : out) group.spin = spin_of(group.inertia, group.momentum);
    return out;
}

Momenta momenta_of(const RigidPart& part)
{
    return {part.mass * part.velocity, part.momentum};
}

// Of a part that moves with its group.
Momenta moved_with(const RigidPart& group, const RigidPart& part)
{
    const Vec3 velocity = group.velocity + group.spin.cross(part.centre - group.centre);
    return {part.mass * velocity, part.inertia * group.spin};
}

void give(RigidPart& part, const Momenta& momenta)
{
    part.velocity = momenta.linear / part.mass;
    part.momentum = momenta.angular;
    part.spin = spin_of(part.inertia, part.momentum);
}

// J: m v . u + L . s of what has the momenta a and b.
double product(const RigidPart& part, const Momenta& a, const Momenta& b)
{
    return a.linear.dot(b.linear) / part.mass + a.angular.dot(spin_of(part.inertia, b.angular));
}

// J, j of a part.
Momenta pushed(const RigidPart& before, const RigidPart& after, const Momenta& given)
{
    const Momenta from = momenta_of(before), to = momenta_of(after);
    return {to.linear - from.linear - given.linear, to.angular - from.angular - given.angular};
}

// G of each group, J.
std::vector<double> gained(const Stage& stage, const SolvedStage& solved,
                           const PushedGroups& groups, const std::vector<RigidPart>& before,
                           const std::vector<Momenta>& given, const std::vector<RigidPart>& after)
{
    std::vector<double> out = work_of_colliders(stage, groups, solved.end);
    for (double& gain : out) gain = -gain;
    for (std::size_t p = 0; p < before.size(); ++p) {
        const RigidPart& part = before[p];
        const Momenta own = pushed(part, after[p], given[p]);
        out[groups.of[p]] += product(part, momenta_of(part), own) + 0.5 * product(part, own, own) -
                             0.5 * product(part, given[p], given[p]);
    }
    return out;
}

// How far slack lets a point out, m, and what of that it would not come out by itself.
struct LetOut {
    double way = 0, more = 0;
};
LetOut let_out(const Stage& stage, const PlaneTouch& touch)
{
    if (!(touch.slack > 0)) return {};
    const double deep = std::max(0.0, depth_at_start(stage, touch));
    const double way = std::min(deep - touch.slack, stage.tau * slack_speed(deep));
    const double leaves = touch.normal.dot(touch.velocity(stage.began_v.data()));
    return {way, way - stage.tau * std::max(0.0, leaves)};
}

// J, that each group may gain.
std::vector<double> allowed(const Stage& stage, const PushedGroups& groups,
                            std::span<const Push> pushes, const std::vector<RigidPart>& before,
                            const std::vector<Momenta>& given)
{
    constexpr double slow = 0.005;  // m/s
    constexpr double risen = 0.01;  // cubes
    const std::size_t parts = before.size();
    std::vector<double> out(parts, 0), mass(parts, 0);
    std::vector<LetOut> most(parts);
    std::vector<Vec3> weight(parts, Vec3::Zero());  // N
    for (std::size_t p = 0; p < parts; ++p) {
        mass[groups.of[p]] += before[p].mass;
        weight[groups.of[p]] += given[p].linear / stage.tau;
    }
    for (const Push& push : pushes) {
        LetOut& of = most[groups.of[stage.frame.body.part_of(push.touch->corners[0])]];
        const LetOut own = let_out(stage, *push.touch);
        of = {std::max(of.way, own.way), std::max(of.more, own.more)};
    }
    for (std::size_t g = 0; g < parts; ++g) {
        if (groups.hit[g] != 0) continue;
        const double speed = slow + most[g].more / stage.tau;
        const double rise = risen * stage.frame.body.h + most[g].way;
        out[g] = 0.5 * mass[g] * speed * speed + rise * weight[g].norm();
    }
    return out;
}

// The motion of colliders that groups touch: the mean of what pushes.
std::vector<RigidPart> colliders_of(const Stage& stage, const PushedGroups& groups,
                                    std::span<const Push> pushes)
{
    std::vector<RigidPart> out(groups.of.size());
    std::vector<double> impulse(out.size(), 0);
    for (const Push& push : pushes) {
        if (push.touch->count > 8) continue;
        const auto g = groups.of[stage.frame.body.part_of(push.touch->corners[0])];
        impulse[g] += push.impulse;
        out[g].velocity += push.impulse * push.touch->drift;
    }
    for (std::size_t g = 0; g < out.size(); ++g) {
        if (impulse[g] > 0) out[g].velocity /= impulse[g];
    }
    return out;
}

// Takes off what is left over of what the parts of free groups push each other with.
void balance(const PushedGroups& groups, const std::vector<RigidPart>& before,
             const std::vector<Momenta>& given, std::vector<RigidPart>& after)
{
    std::vector<Momenta> own(before.size());
    for (std::size_t p = 0; p < own.size(); ++p) own[p] = pushed(before[p], after[p], given[p]);
    const std::vector<RigidPart> left = as_one(groups, before, own);
    for (std::size_t p = 0; p < before.size(); ++p) {
        const std::uint32_t g = groups.of[p];
        if (groups.kept[g] == 0 || groups.free[g] == 0) continue;
        const Momenta over = moved_with(left[g], before[p]), now = momenta_of(after[p]);
        give(after[p], {now.linear - over.linear, now.angular - over.angular});
    }
}

// f of a group: E, P and G.
double factor(double moving, double work, double gain)
{
    const double left = work - 2 * moving, square = left * left - 4 * moving * gain;
    return std::clamp((work + std::sqrt(std::max(0.0, square))) / (2 * moving), 0.0, 1.0);
}

// Slows groups that gained energy, J, by just as much.
void slow_down(const Stage& stage, const PushedGroups& groups, std::span<const Push> pushes,
               const std::vector<Momenta>& given, const std::vector<double>& gain,
               std::vector<RigidPart>& after)
{
    const std::size_t parts = after.size();
    std::vector<Momenta> now(parts), with(parts), relative(parts);
    std::transform(after.begin(), after.end(), now.begin(), momenta_of);
    const auto one = as_one(groups, after, now), others = colliders_of(stage, groups, pushes);
    std::vector<double> moving(parts, 0), work(parts, 0);  // E, P of each group
    for (std::size_t p = 0; p < parts; ++p) {
        const std::uint32_t g = groups.of[p];
        with[p] = moved_with(groups.free[g] != 0 ? one[g] : others[g], after[p]);
        relative[p] = {now[p].linear - with[p].linear, now[p].angular - with[p].angular};
        moving[g] += 0.5 * product(after[p], relative[p], relative[p]);
        work[g] += product(after[p], given[p], relative[p]);
    }
    for (std::size_t p = 0; p < parts; ++p) {
        const std::uint32_t g = groups.of[p];
        if (groups.kept[g] == 0 || !(gain[g] > 0 && moving[g] > 0)) continue;
        const double f = factor(moving[g], work[g], gain[g]);
        give(after[p],
             {with[p].linear + f * relative[p].linear, with[p].angular + f * relative[p].angular});
    }
}

}  // namespace

void keep_impact_energy(const Stage& stage, const SolvedStage& solved, std::span<const Push> pushes,
                        const std::vector<RigidPart>& before, const std::vector<double>& work,
                        std::vector<RigidPart>& after)
{
    if (pushes.empty()) return;
    const PushedGroups groups(stage, pushes);
    const auto given = given_from_outside(stage, solved.x, before);
    balance(groups, before, given, after);
    std::vector<double> gain = gained(stage, solved, groups, before, given, after);
    for (std::size_t p = 0; p < before.size(); ++p) gain[groups.of[p]] -= work[p];
    const auto most = allowed(stage, groups, pushes, before, given);
    for (std::size_t g = 0; g < gain.size(); ++g) gain[g] -= most[g];
    slow_down(stage, groups, pushes, given, gain, after);
}

}  // namespace physics
