#include "physics/bricks/free_parts.hpp"

#include "geometry/base/union_find.hpp"
#include "physics/math/for_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace physics {
namespace {

using geometry::Mat3;

Vec3 at(const Aligned<double>& v, std::size_t k)
{
    return {v[4 * k], v[4 * k + 1], v[4 * k + 2]};
}

}  // namespace

std::vector<RigidPart> rigid_parts(const Stage& stage, const Aligned<double>& x,
                                   const Aligned<double>& v)
{
    // With M: sum_a (M v)_a, and for the inertia J = sum_a (M x)_a x_a^T. What M lacks of the
    // lumped masses answers to differences within cubes alone, whatever the centre.
    const CornerBody& body = stage.frame.body;
    Aligned<double> less_x, less_v;
    const std::size_t room = std::max(stage.frame.n, stage.elasticity.room());
    for (Aligned<double>* less : {&less_x, &less_v}) fill_numbers(*less, room, 0.0);
    stage.elasticity.excess(Lumped::mass, x.data(), less_x.data());
    stage.elasticity.excess(Lumped::mass, v.data(), less_v.data());
    std::vector<RigidPart> parts(body.parts);
    for (std::size_t k = 0; k < body.corners; ++k) {
        RigidPart& part = parts[body.part_of(k)];
        part.mass += body.mass[k];
        part.centre += body.mass[k] * at(x, k);
        part.velocity += body.mass[k] * at(v, k);
    }
    for (RigidPart& part : parts) part.centre /= part.mass, part.velocity /= part.mass;
    for (std::size_t k = 0; k < body.corners; ++k) {
        RigidPart& part = parts[body.part_of(k)];
        const Vec3 arm = at(x, k) - part.centre;
        const Vec3 by_mass = body.mass[k] * arm - at(less_x, k);
        part.inertia += by_mass.dot(arm) * Mat3::Identity() - by_mass * arm.transpose();
        part.momentum += arm.cross(body.mass[k] * (at(v, k) - part.velocity) - at(less_v, k));
    }
    for (RigidPart& part : parts) {
        part.inertia = (0.5 * (part.inertia + part.inertia.transpose())).eval();
    }
    for (RigidPart& part : parts) part.spin = spin_of(part.inertia, part.momentum);
    return parts;
}

namespace {

// Elastic forces and their damping add up to nothing over a part. What is left of
//   sum M (v0 - w) + tau (f_ext - D w)
// of a free one is therefore the solver's error alone: w moves as a whole to undo it, and linear
// momentum is right to round-off whatever the tolerance.
void balance_linear(Stage& stage, const std::vector<std::uint32_t>& group,
                    const std::vector<std::uint8_t>& held)
{
    const StepFrame& frame = stage.frame;
    const CornerBody& body = frame.body;
    std::vector<Vec3> missing(body.parts, Vec3::Zero());  // N s
    std::vector<Vec3> inertia(body.parts, Vec3::Zero());  // kg
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t part = group[body.part_of(k)];
        if (held[part] != 0) continue;
        for (std::size_t i = 4 * k, a = 0; a < 3; ++i, ++a) {
            const double drag = frame.damping[i] + stage.drag[i];
            const auto axis = static_cast<Eigen::Index>(a);
            missing[part][axis] +=
                frame.mass[i] * (stage.v0[i] - stage.w[i]) +
                stage.tau * (frame.steady[i] + stage.wind[i] - drag * stage.w[i]);
            inertia[part][axis] += frame.mass[i] + stage.tau * drag;
        }
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t part = group[body.part_of(k)];
        if (held[part] != 0) continue;
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            stage.w[4 * k + a] += missing[part][axis] / inertia[part][axis];
        }
    }
}

// N, those that act on each corner from outside, at w.
std::vector<Vec3> outside_forces(const Stage& stage)
{
    const StepFrame& frame = stage.frame;
    std::vector<Vec3> out(frame.body.corners);
    Aligned<double> damped(frame.n, 0);
    if (!frame.body.mass_damping.empty()) times_damping(stage, stage.w, damped);
    for (std::size_t k = 0; k < out.size(); ++k) {
        for (std::size_t a = 0, i = 4 * k; a < 3; ++a, ++i) {
            out[k][static_cast<Eigen::Index>(a)] =
                frame.steady[i] + stage.wind[i] - damped[i] - stage.drag[i] * stage.w[i];
        }
    }
    return out;
}

// Of the forces from outside about the centre of each part where the stage ends, N m s, and `about`
// the centre where it began if that is not null. What acts on a part as a whole, as weight does,
// has no torque about its centre: it is left out of each corner's, exactly.
std::vector<Vec3> impulses(const Stage& stage, const std::vector<RigidPart>* about)
{
    const CornerBody& body = stage.frame.body;
    const std::vector<Vec3> outside = outside_forces(stage);
    std::vector<Vec3> sum(body.parts, Vec3::Zero());
    std::vector<Vec3> centre(body.parts, Vec3::Zero()), out(body.parts, Vec3::Zero());
    std::vector<double> mass(body.parts, 0);
    const auto end = [&](std::size_t k) {
        return Vec3(at(stage.x0, k) + stage.tau * at(stage.w, k));
    };
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t part = body.part_of(k);
        sum[part] += outside[k];
        centre[part] += body.mass[k] * end(k);
        mass[part] += body.mass[k];
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t part = body.part_of(k);
        const Vec3 own = outside[k] - body.mass[k] / mass[part] * sum[part];
        out[part] += stage.tau * (end(k) - centre[part] / mass[part]).cross(own);
    }
    for (std::size_t p = 0; about && p < body.parts; ++p) {
        out[p] += stage.tau * (centre[p] / mass[p] - (*about)[p].centre).cross(sum[p]);
    }
    return out;
}

// Turns the velocities v of parts that are not held, about their centres, by the least change with
// which sum m (x x v) about the centre where each began is what is due.
void turn_to(const Stage& stage, const std::vector<std::uint8_t>& held,
             const std::vector<RigidPart>& began, const std::vector<Vec3>& due,
             const Aligned<double>& x, Aligned<double>& v)
{
    const CornerBody& body = stage.frame.body;
    const auto parts = rigid_parts(stage, x, v);
    std::vector<Vec3> turn(body.parts);
    for (std::size_t p = 0; p < body.parts; ++p) {
        const Vec3 off = parts[p].centre - began[p].centre;
        const Vec3 has = parts[p].momentum + parts[p].mass * off.cross(parts[p].velocity);
        turn[p] = spin_of(parts[p].inertia, due[p] - has);
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t part = body.part_of(k);
        if (held[part] != 0) continue;
        const Vec3 change = turn[part].cross(at(x, k) - parts[part].centre);
        for (std::size_t a = 0; a < 3; ++a) {
            v[4 * k + a] += change[static_cast<Eigen::Index>(a)];
        }
    }
}

}  // namespace

std::vector<std::uint8_t> held_parts(const Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    std::vector<std::uint8_t> held = axes_of_parts(stage.frame.loads.pins, body);
    held.resize(body.parts);
    for (const PointContact& c : stage.contacts) {
        for (std::size_t a = 0; a < c.count; a += 8) held[body.part_of(c.corners[a])] = all_axes;
    }
    return held;
}

namespace {

// Where corners start, but for lifting.
Aligned<double> unlifted(const Stage& stage)
{
    Aligned<double> out = stage.x0;
    for (std::size_t i = 0; i < stage.lifted.size(); ++i) out[i] -= stage.lifted[i];
    return out;
}

// How fast at most each part slides on a collider, or hits it, m/s; what touches another part,
// which gives way, has no end of it.
std::vector<double> speeds_of_touches(const Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    std::vector<double> out(body.parts, 0);
    const double* const x = stage.x.data();
    for (const PlaneTouch& touch : stage.holds) {
        if (!(touch.depth(x) > 0)) continue;
        double& most = out[body.part_of(touch.corners[0])];
        most = std::max(most, touch.velocity(stage.v0.data()).norm());
    }
    for (const PlaneTouch& touch : stage.touches) {
        if (!(touch.depth(x) > 0)) continue;
        for (std::size_t a = 0; a < touch.count; a += 8) {
            out[body.part_of(touch.corners[a])] = std::numeric_limits<double>::infinity();
        }
    }
    return out;
}

// Whether it goes on turning as it does where it touches something at that speed, and far enough
// for the square of the angle to show: it rolls.
bool rolls(const RigidPart& part, double speed, double tau)
{
    constexpr double little = 0.1;  // of its speed at its radius of gyration
    constexpr double far = 0.002;   // rad
    const double radius = std::sqrt(0.5 * part.inertia.trace() / part.mass);
    return tau * part.spin.norm() > far && speed <= little * radius * part.spin.norm();
}

}  // namespace

void turn_free_parts(Stage& stage)
{
    // Below this turn of a stage, rad, its square is rounding, and nothing changes. Beyond half a
    // turn the stage is too long to follow it.
    constexpr double least = 1e-6, most = std::numbers::pi;
    const CornerBody& body = stage.frame.body;
    const double tau = stage.tau;
    stage.base.clear();
    auto held = held_parts(stage);
    // Of what rolls on something, as a wheel, forces alone are taken where it turns to.
    auto pinned = axes_of_parts(stage.frame.loads.pins, body);
    pinned.resize(body.parts);
    if (has_sheets(body) || stage.frame.options.leaps) pinned = held;
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {
        held[stage.rigid.part(i)] = pinned[stage.rigid.part(i)] = all_axes;
    }
    if (std::all_of(pinned.begin(), pinned.end(), [](auto h) { return h != 0; })) return;
    const auto parts = rigid_parts(stage, stage.x0, stage.v0);
    const std::vector<double> speed = speeds_of_touches(stage);
    std::vector<Turn> turns;
    for (std::size_t p = 0; p < body.parts; ++p) {
        turns.push_back(turn_freely(parts[p], tau));
        if (held[p] != 0 && !rolls(parts[p], speed[p], tau)) pinned[p] = all_axes;
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const RigidPart& part = parts[body.part_of(k)];
        const Turn& turn = turns[body.part_of(k)];
        const double angle = tau * part.spin.norm();
        if (pinned[body.part_of(k)] != 0 || !(angle > least && angle < most)) continue;
        const bool starts = stage.turns_start && held[body.part_of(k)] == 0;
        if (stage.base.empty()) stage.base.assign(stage.frame.n, 0);
        const Vec3 from = at(stage.x0, k);
        const Vec3 arm = turn.by * (from - part.centre);
        const Vec3 to = part.centre + tau * part.velocity + arm;
        const Vec3 before = part.velocity + part.spin.cross(from - part.centre);
        const Vec3 velocity = part.velocity + turn.spin.cross(arm);
        for (std::size_t a = 0; a < 3; ++a) {
            const auto axis = static_cast<Eigen::Index>(a);
            if (held[body.part_of(k)] == 0) {
                stage.w[4 * k + a] += velocity[axis] - before[axis];  // as a guess
            }
            if (starts) stage.x0[4 * k + a] = to[axis] - tau * velocity[axis];
            stage.base[4 * k + a] = starts ? velocity[axis] : (to[axis] - from[axis]) / tau;
        }
    }
    if (!stage.turns_start || stage.base.empty()) return;
    std::vector<Vec3> due(body.parts);
    for (std::size_t p = 0; p < body.parts; ++p) due[p] = parts[p].momentum;
    // Elastic forces have no torque about x^: w has there what v0 has.
    Aligned<double> turned = stage.x0;
    for (std::size_t i = 0; i < stage.frame.n; ++i) turned[i] += tau * stage.base[i];
    turn_to(stage, held, parts, due, turned, stage.v0);
}

void start_rigid_parts(Stage& stage)
{
    RigidBodies& rigid = stage.rigid;
    if (rigid.none()) return;
    const auto parts = rigid_parts(stage, stage.x0, stage.v0);
    for (std::size_t i = 0; i < rigid.count(); ++i) {
        const RigidPart& part = parts[rigid.part(i)];
        rigid.motion[i] = {.began = part, .v = part.velocity, .s = part.spin};
    }
}

namespace {

// N m s, at the end of the stage.
Vec3 momentum_of(const RigidMotion& motion)
{
    return motion.by * motion.began.inertia * motion.by.transpose() * motion.s;
}

// Where the motion of a rigid part takes it: its turn since the stage began, and its spin then.
Turn turn_of(const Stage& stage, const RigidMotion& motion)
{
    RigidPart part = motion.began;
    part.spin = motion.s;
    part.momentum = momentum_of(motion) - motion.less_momentum;
    Turn out = turn_freely(part, stage.tau);
    if (motion.less_momentum.isZero(0)) return out;
    out.spin = spin_of(out.by * part.inertia * out.by.transpose(), momentum_of(motion));
    return out;
}

Vec3 place_of(const Stage& stage, const RigidMotion& motion, const Mat3& turn, std::uint32_t slot)
{
    const Vec3 arm = turn * (at(stage.began, slot) - motion.began.centre);
    const Vec3 x = motion.began.centre + stage.tau * (motion.v - motion.less_v) + arm;
    return stage.lifted.empty() ? x : Vec3(x + at(stage.lifted, slot));
}

}  // namespace

void place_by_means(Stage& stage, std::size_t i)
{
    RigidMotion& m = stage.rigid.motion[i];
    m.less_v = 0.5 * (m.v - m.began.velocity);
    m.less_momentum = 0.5 * (momentum_of(m) - m.began.momentum);
    if (!stage.lifted.empty()) m.less_v += at(stage.lifted, stage.rigid.corners(i)[0]) / stage.tau;
}

void turn_rigid_parts(Stage& stage)
{
    RigidBodies& rigid = stage.rigid;
    if (rigid.none()) return;
    if (stage.base.empty()) stage.base.assign(stage.frame.n, 0);
    for (std::size_t i = 0; i < rigid.count(); ++i) {
        RigidMotion& m = rigid.motion[i];
        const Turn turn = turn_of(stage, m);
        m.by = turn.by, m.s = turn.spin;
        const Mat3 inertia = m.by * m.began.inertia * m.by.transpose();
        const Vec3 spin_before = spin_of(inertia, m.began.momentum);
        for (const auto k : rigid.corners(i)) {
            const Vec3 x = place_of(stage, m, m.by, k);
            const Vec3 arm = m.by * (at(stage.began, k) - m.began.centre);
            const Vec3 w = m.v + m.s.cross(arm);
            const auto put = [&](Aligned<double>& to, const Vec3& value) {
                Eigen::Map<Vec3>(to.data() + 4 * std::size_t{k}) = value;
            };
            put(stage.x, x), put(stage.w, w), put(stage.base, w);
            put(stage.x0, x - stage.tau * w);
            put(stage.v0, m.began.velocity + spin_before.cross(arm));
        }
    }
    rigid.look_at(stage.x.data());
}

std::vector<double> take_rigid_motion(Stage& stage)
{
    RigidBodies& rigid = stage.rigid;
    std::vector<double> most(rigid.count(), 0);
    for (std::size_t i = 0; i < rigid.count(); ++i) {
        RigidMotion& m = rigid.motion[i];
        rigid.nearest(i, stage.w.data(), m.v, m.s);
        rigid.spread(i, m.v, m.s, stage.w.data());
        const Turn turn = turn_of(stage, m);
        for (const auto k : rigid.corners(i)) {
            const Vec3 along = at(stage.x0, k) + stage.tau * at(stage.w, k);
            const double off = (place_of(stage, m, turn.by, k) - along).norm();
            const double in_cubes = off / stage.frame.body.edge_at(k);
            most[i] = std::isfinite(off) ? std::max(most[i], in_cubes)
                                         : std::numeric_limits<double>::infinity();
        }
    }
    return most;
}

namespace {

// Sheets, solids beside them, and parts with joints that touch each other and nothing else are one:
// forces between them add up to nothing.
struct SheetGroups {
    std::vector<std::uint32_t> of;      // of each part, a part of its group
    std::vector<std::uint8_t> held;     // of each of these: by a pin or a collider
    std::vector<std::uint8_t> touches;  // likewise: another sheet, or itself
};
SheetGroups sheet_groups(const Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    geometry::UnionFind groups(body.parts);
    std::vector<std::uint8_t> held = axes_of_parts(stage.frame.loads.pins, body);
    held.resize(body.parts);
    std::vector<std::uint8_t> touches(body.parts, 0);
    for (const PointContact& c : stage.contacts) {
        const std::uint32_t part = body.part_of(c.corners[0]);
        if (c.count > 8) {
            groups.join(part, body.part_of(c.corners[8]));
            touches[part] = 1;
        } else {
            held[part] = 1;
        }
    }
    SheetGroups out{groups.roots(), held, touches};
    for (std::size_t p = 0; p < body.parts; ++p) {
        out.held[out.of[p]] |= held[p];
        out.touches[out.of[p]] |= touches[p];
    }
    return out;
}

// N m s, about a place.
Vec3 momentum_about(const RigidPart& part, const Vec3& place)
{
    return part.momentum + part.mass * (part.centre - place).cross(part.velocity);
}

// Turns the velocities of groups that touch, by the least change with which their angular momenta
// are those of x and v and what came from outside. Where corners go from x0 to x0 + tau w, both
// have the same moment of M w.
void turn_groups(Stage& stage, const SheetGroups& groups, const Aligned<double>& x,
                 const Aligned<double>& v)
{
    const CornerBody& body = stage.frame.body;
    const Aligned<double> arms = unlifted(stage);
    const auto began = rigid_parts(stage, x, v), has = rigid_parts(stage, arms, stage.w);
    std::vector<RigidPart> all(body.parts);
    for (std::size_t p = 0; p < body.parts; ++p) {
        all[groups.of[p]].mass += has[p].mass;
        all[groups.of[p]].centre += has[p].mass * has[p].centre;
    }
    for (RigidPart& group : all) {
        if (group.mass > 0) group.centre /= group.mass;
    }
    for (std::size_t p = 0; p < body.parts; ++p) {
        RigidPart& group = all[groups.of[p]];
        const Vec3 off = has[p].centre - group.centre;
        group.inertia += has[p].inertia + has[p].mass * (off.squaredNorm() * Mat3::Identity() -
                                                         off * off.transpose());
        group.momentum +=
            momentum_about(began[p], group.centre) - momentum_about(has[p], group.centre);
    }
    const std::vector<Vec3> outside = outside_forces(stage);
    for (std::size_t k = 0; k < body.corners; ++k) {
        RigidPart& group = all[groups.of[body.part_of(k)]];
        group.momentum += stage.tau * (at(arms, k) - group.centre).cross(outside[k]);
    }
    for (RigidPart& group : all) group.spin = spin_of(group.inertia, group.momentum);
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::uint32_t g = groups.of[body.part_of(k)];
        if (groups.held[g] != 0 || groups.touches[g] == 0) continue;
        const Vec3 change = all[g].spin.cross(at(arms, k) - all[g].centre);
        for (std::size_t a = 0; a < 3; ++a) {
            stage.w[4 * k + a] += change[static_cast<Eigen::Index>(a)];
        }
    }
}

}  // namespace

void balance_free_parts(Stage& stage, const Aligned<double>& before_x,
                        const Aligned<double>& before_v, Balance balance)
{
    const CornerBody& body = stage.frame.body;
    const auto held = held_parts(stage);
    const bool in_groups = body.sheets || body.solids || !stage.frame.loads.joints.empty();
    if (in_groups) {
        const SheetGroups groups = sheet_groups(stage);
        balance_linear(stage, groups.of, groups.held);
        if (balance == Balance::end) turn_groups(stage, groups, before_x, before_v);
    }
    if (std::all_of(held.begin(), held.end(), [](auto h) { return h != 0; })) return;
    if (!in_groups) {
        std::vector<std::uint32_t> own(body.parts);
        std::iota(own.begin(), own.end(), 0u);
        balance_linear(stage, own, held);
    }
    if (balance == Balance::linear) return;
    Aligned<double> arms = unlifted(stage);
    if (balance == Balance::middle) {
        for (std::size_t i = 0; i < stage.frame.n; ++i) arms[i] += stage.tau * stage.v0[i];
    }
    const auto began = rigid_parts(stage, before_x, before_v);
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {  // which turn about the arms they have
        for (const auto k : stage.rigid.corners(i)) {
            const Vec3 arm = began[stage.rigid.part(i)].centre + stage.rigid.arm(k);
            Eigen::Map<Vec3>(arms.data() + 4 * std::size_t{k}) = arm;
        }
    }
    // At its end Euler's step has lost tau^2 v x F of the orbit about where the part began.
    std::vector<Vec3> due = impulses(stage, balance == Balance::middle ? &began : nullptr);
    for (std::size_t p = 0; p < body.parts; ++p) due[p] += began[p].momentum;
    turn_to(stage, held, began, due, arms, stage.w);
}

Aligned<double> deforming(const Stage& stage, const Aligned<double>& x, const Aligned<double>& v)
{
    const CornerBody& body = stage.frame.body;
    const auto held = held_parts(stage);
    const auto parts = rigid_parts(stage, x, v);
    Aligned<double> out = v;
    for (std::size_t k = 0; k < body.corners; ++k) {
        const RigidPart& part = parts[body.part_of(k)];
        if (held[body.part_of(k)] != 0) continue;
        const Vec3 rigid = part.velocity + part.spin.cross(at(x, k) - part.centre);
        for (std::size_t a = 0; a < 3; ++a) {
            out[4 * k + a] -= rigid[static_cast<Eigen::Index>(a)];
        }
    }
    return out;
}

}  // namespace physics
