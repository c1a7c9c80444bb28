#include "physics/bricks/impacts.hpp"

#include "physics/bricks/bounce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace physics {
namespace {

// What a part gets from another one, or from a collider: the sums over its points.
struct Impact {
    double impulse = 0;            // N s
    double bounce = 0;             // N s, by the share that each leaves with
    double slows = 0;              // N s m/s, by the speed that it loses in the stage then
    Vec3 place = Vec3::Zero();     // N s m, where the stage began
    Vec3 along = Vec3::Zero();     // N s
    Vec3 velocity = Vec3::Zero();  // N s m/s, of the collider
};

Meeting meeting_of(const Stage& stage, const PlaneTouch& touch)
{
    const CornerBody& body = stage.frame.body;
    const bool parts = touch.count > 8;
    return {body.part_of(touch.corners[0]), parts,
            parts ? body.part_of(touch.corners[8]) : touch.other};
}

std::map<Meeting, Impact> impacts(const Stage& stage, const SolvedStage& solved)
{
    std::map<Meeting, Impact> out;
    Comings comings(stage);
    for (const auto* touches : {&stage.touches, &stage.holds}) {
        for (const PlaneTouch& touch : *touches) {
            if (!(touch.rebound > 0)) continue;
            const double impulse = stage.tau * touch.stiffness * touch.depth(solved.end.data());
            if (!(impulse > 0)) continue;
            Impact& impact = out[meeting_of(stage, touch)];
            impact.impulse += impulse;
            impact.bounce += impulse * touch.bounce;
            impact.slows += impulse * stage.tau * comings.of(touch).acceleration;
            impact.place += impulse * place_of_touch(touch, solved.x);
            impact.along += impulse * touch.normal;
            impact.velocity += impulse * touch.drift;
        }
    }
    return out;
}

// Of an impulse of 1 N s along n at p: what it changes. What is held along some axes does not turn.
struct Kick {
    Vec3 velocity = Vec3::Zero(), momentum = Vec3::Zero(), spin = Vec3::Zero();
};
Kick kick(const RigidPart& part, std::uint8_t held, const Vec3& p, const Vec3& n)
{
    Kick out{.velocity = n / part.mass};
    if (held == 0) {
        out.momentum = (p - part.centre).cross(n);
        out.spin = spin_of(part.inertia, out.momentum);
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
        if ((held >> i & 1) != 0) out.velocity[i] = 0;
    }
    return out;
}

void add(const Kick& kick, double impulse, RigidPart& to)
{
    to.velocity += impulse * kick.velocity;
    to.momentum += impulse * kick.momentum;
    to.spin += impulse * kick.spin;
}

// How two part along n: what they are to, and do.
struct Parting {
    Vec3 n = Vec3::Zero(), p = Vec3::Zero();  // p: m, where they touch
    double came = 0, wanted = 0, has = 0;     // m/s, came: below 0
};
Parting parting(const Meeting& who, const Impact& impact, const std::vector<RigidPart>& before,
                const std::vector<RigidPart>& after)
{
    Parting out;
    const double length = impact.along.norm();
    if (!(length > 0)) return out;
    out.n = impact.along / length, out.p = impact.place / impact.impulse;
    const auto speed = [&](const std::vector<RigidPart>& parts) {
        Vec3 v = velocity_at(parts[who.part], out.p) - impact.velocity / impact.impulse;
        if (who.parts) v -= velocity_at(parts[who.other], out.p);
        return out.n.dot(v);
    };
    out.came = speed(before);
    out.wanted = -(impact.bounce * out.came + impact.slows) / impact.impulse;
    out.has = speed(after);
    return out;
}

// Parts with the momenta that they have where the stage ends, and the arms that they began with.
std::vector<RigidPart> parts_after(const Stage& stage, const std::vector<RigidPart>& before)
{
    std::vector<RigidPart> out = rigid_parts(stage, stage.x0, stage.w);
    for (std::size_t p = 0; p < out.size(); ++p) {
        out[p].centre = before[p].centre, out[p].inertia = before[p].inertia;
        out[p].spin = spin_of(out[p].inertia, out[p].momentum);
    }
    return out;
}

// A part does not move itself.
bool is_alone(const Meeting& who)
{
    return who.parts && who.other == who.part;
}

}  // namespace

Risen risen(const Stage& stage, const SolvedStage& solved)
{
    constexpr double rigid = 1.0 / 3;  // of that speed: what has as much by then gets all of it
    Risen out;
    const auto met = impacts(stage, solved);
    if (met.empty()) return out;
    const auto before = rigid_parts(stage, solved.x, solved.v);
    const auto after = parts_after(stage, before);
    for (const auto& [who, impact] : met) {
        const Parting part = parting(who, impact, before, after);
        if (is_alone(who) || !(part.wanted > 0)) continue;
        out[who] = part.has > 0 ? std::min(part.has / (rigid * part.wanted), 1.0) : 0;
    }
    return out;
}

namespace {

// rad/s, of a part that swings on what it hits, as a stage of implicit Euler tells it. A mass on a
// spring that is pushed out at the speed e v when it comes at v has the speed
//   v1 = v (e s - 1) / (1 + s),   s = (w tau)^2
// where the stage ends. Where s is large, little tells it from a rigid body: infinity.
double rate_of(const Parting& part, double tau)
{
    constexpr double most = 30;
    const double e = part.wanted / -part.came, v1 = part.has / -part.came;
    if (!(1 + v1 > 0)) return 0;
    const double s = v1 < e ? (1 + v1) / (e - v1) : std::numeric_limits<double>::infinity();
    return s < most ? std::sqrt(s) / tau : std::numeric_limits<double>::infinity();
}

// The share of its speed that implicit Euler leaves to a part that swings at `rate` through half a
// period, in steps of dt: exp(-w dt / 2) a radian.
double left_by_steps(double rate, double dt)
{
    if (rate == 0) return 1;  // it is not slowed yet
    return std::exp(-0.5 * std::numbers::pi * rate * dt);
}

// Who pressed on whom already where the stage began.
std::set<Meeting> pressed_before(const Stage& stage)
{
    std::set<Meeting> out;
    for (const auto* touches : {&stage.touches, &stage.holds}) {
        for (const PlaneTouch& touch : *touches) {
            if (touch.began > touch.slack) out.insert(meeting_of(stage, touch));
        }
    }
    return out;
}

}  // namespace

Risen risen_by_error(const Stage& stage, const SolvedStage& solved, double finest)
{
    constexpr double vibrates = 1.15;  // what was squashed keeps some of its speed as vibration
    constexpr double begun = 0.5;      // lest what is being squashed becomes rigid meanwhile
    Risen out;
    const auto met = impacts(stage, solved);
    if (met.empty()) return out;
    const auto before = rigid_parts(stage, solved.x, solved.v);
    const auto after = parts_after(stage, before);
    const auto pressed = pressed_before(stage);
    const double most = 2 * stage.frame.options.error * stage.frame.body.h;  // m
    for (const auto& [who, impact] : met) {
        const Parting part = parting(who, impact, before, after);
        if (is_alone(who) || !(part.wanted > 0) || !(part.came < 0)) continue;
        const double rate = rate_of(part, stage.tau);
        const double dt =
            std::clamp(std::sqrt(most / (-part.came * rate)), finest, stage.frame.seconds);
        const double e = part.wanted / -part.came;
        const double least =
            pressed.contains(who) ? begun * e : std::min(vibrates * e, 0.5 + 0.5 * e);
        out[who] = !std::isfinite(rate) ? rigid_yet : left_by_steps(rate, dt) > least ? 0 : 1;
    }
    return out;
}

namespace {

// Gives the velocities of parts what they have got since they were `found`.
void move_parts(Stage& stage, const Aligned<double>& began, const std::vector<RigidPart>& found,
                const std::vector<RigidPart>& after)
{
    const CornerBody& body = stage.frame.body;
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        if (stage.rigid.of_corner(k) != RigidBodies::not_rigid) continue;
        const RigidPart &to = after[body.part_of(k)], &from = found[body.part_of(k)];
        const Vec3 arm = Eigen::Map<const Vec3>(&began[4 * k]) - to.centre;
        const Vec3 change = to.velocity - from.velocity + (to.spin - from.spin).cross(arm);
        Eigen::Map<Vec3>(&stage.w[4 * k]) += change;
    }
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {
        RigidMotion& motion = stage.rigid.motion[i];
        const RigidPart& to = after[stage.rigid.part(i)];
        motion.v = to.velocity;
        motion.s = spin_of(motion.by * to.inertia * motion.by.transpose(), to.momentum);
    }
    const Aligned<double> pressed = stage.x;  // what touches stays known by where it was pressed to
    turn_rigid_parts(stage);
    stage.x = pressed;
}

// All that pushes rigid parts in the stage.
std::vector<Push> pushes_of_rigid(const Stage& stage, const SolvedStage& solved)
{
    std::vector<Push> out;
    if (stage.rigid.none()) return out;
    Comings comings(stage);
    for (const auto* touches : {&stage.touches, &stage.holds}) {
        for (const PlaneTouch& touch : *touches) {
            if (stage.rigid.of_corner(touch.corners[0]) == RigidBodies::not_rigid) continue;
            const double impulse = stage.tau * touch.stiffness * touch.depth(solved.end.data());
            if (!(impulse > 0)) continue;
            out.push_back({&touch, impulse, hits(stage, comings.of(touch))});
        }
    }
    return out;
}

// Gives each two parts that meet the speed that they lack. Returns the work of colliders by that,
// J, on each part.
std::vector<double> make_up(const Stage& stage, const std::map<Meeting, Impact>& met,
                            const std::vector<RigidPart>& before, const Risen& risen,
                            std::vector<RigidPart>& after)
{
    const auto held = axes_of_parts(stage.frame.loads.pins, stage.frame.body);
    std::vector<double> work(before.size(), 0);
    for (const auto& meeting : met) {
        const Meeting& who = meeting.first;
        const auto share = risen.find(who);
        if (share == risen.end() || held[who.part] == all_axes || is_alone(who)) continue;
        const auto [n, p, came, wanted, has] = parting(who, meeting.second, before, after);
        if (!(has < wanted)) continue;
        const bool two = who.parts;
        const Kick own = kick(after[who.part], held[who.part], p, n);
        Kick other;
        if (two) other = kick(after[who.other], held[who.other], p, n);
        const double gives =
            n.dot(own.velocity + own.spin.cross(p - after[who.part].centre)) +
            (two ? n.dot(other.velocity + other.spin.cross(p - after[who.other].centre)) : 0);
        if (!(gives > 0)) continue;  // it is held against the push
        // The less it rises yet, the less it is a rigid body.
        const double impulse = (wanted - has) * share->second / gives;
        add(own, impulse, after[who.part]);
        if (two) {
            add(other, -impulse, after[who.other]);
        } else {
            const Vec3 drift = meeting.second.velocity / meeting.second.impulse;
            work[who.part] += impulse * n.dot(drift);
        }
    }
    return work;
}

}  // namespace

void finish_impacts(Stage& stage, const SolvedStage& solved, const Risen& risen)
{
    const auto met = impacts(stage, solved);
    const auto pushes = pushes_of_rigid(stage, solved);
    if (met.empty() && pushes.empty()) return;
    const auto before = rigid_parts(stage, solved.x, solved.v);
    const auto found = parts_after(stage, before);
    auto after = found;
    const std::vector<double> work = make_up(stage, met, before, risen, after);
    keep_impact_energy(stage, solved, pushes, before, work, after);
    const auto same = [](const RigidPart& a, const RigidPart& b) {
        return a.velocity == b.velocity && a.momentum == b.momentum;
    };
    if (std::equal(found.begin(), found.end(), after.begin(), same)) return;
    move_parts(stage, solved.x, found, after);
}

}  // namespace physics
