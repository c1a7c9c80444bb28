#include "physics/layered_bodies/layered_forces.hpp"

#include "physics/layered_bodies/layered_loads.hpp"
#include "physics/layers/velocity_at.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// N s/m: what damps an impact that rests: 2 (1 - e) times the critical damping, so that what does
// not bounce comes to rest without a swing. Under Bullet, where damping takes steps as stiffness
// does, half of the critical one. Against u, so that rolling is free. A layer that parts is pulled
// back by no more than half of what it pushes: by a fifth of that one slows down that comes out
// damped.
double resting_damping(const Impact& impact, bool held, double u)
{
    const double c =
        (held ? 1 : 4) * (1 - std::sqrt(impact.restitution_sq)) * impact.stiffness / impact.rate;
    return u > 0 ? std::min(c, 1.5 * impact.force / u) : c;
}

void damp_resting(const Impacts& impacts, LayeredSystem& system)
{
    for (const Impact& impact : impacts.all) {
        if (impact.bounces() || !(impact.rate > 0)) continue;
        const double u = impact.parting(system.velocity) + impact.shape;
        const double c = resting_damping(impact, impact.held(system), u);
        std::vector<FrameRow> rows;
        for (const ImpactFrame& at : impact.frames) {
            system.right[at.frame] -= system.dt * c * u * at.along;
            rows.push_back({at.body, at.frame, at.along});
        }
        add_along(system, rows, c, 0);
    }
}

// Contact forces, with the stiffness that the layers have there: moved together by x along the
// normal, two layers of slopes s_i and s_j compress by x s_i s_j / (s_i + s_j); a rigid one by x
// s_i.
void add_contacts(const LayeredScene& scene, const LayeredMoment& moment, const Impacts& impacts,
                  LayeredSystem& system)
{
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        for (std::size_t f = 0; f < moment.contacts.wrenches[b].size(); ++f) {
            const Wrench& wrench = moment.contacts.wrenches[b][f];
            add_force(system, system.frame(b, f), wrench.force, wrench.torque);
        }
    }
    for (std::size_t c = 0; c < moment.contacts.contacts.size(); ++c) {
        const LayerContact& contact = moment.contacts.contacts[c];
        const LayerContactLaw law = contact_law(moment.bodies, contact);
        const bool rigid = scene.parts[contact.other].body->matter.rigid;
        const auto [si, sj] = slopes_at(moment, contact);
        const double K = law.stiffness * (rigid ? si : si * sj / (si + sj));
        const double share = rigid ? contact.area : 0.5 * contact.area;
        const Mat3 across = contact.normal * contact.normal.transpose();
        const std::uint32_t fa = scene.parts[contact.body].body->layer.frame[contact.skeleton];
        const std::uint32_t fb =
            scene.parts[contact.other].body->layer.frame[contact.other_skeleton];
        const std::size_t a = system.frame(contact.body, fa), b = system.frame(contact.other, fb);
        const Vec3 arm_a = contact.position - moment.frames[contact.body][fa].translation();
        const Vec3 arm_b = contact.position - moment.frames[contact.other][fb].translation();
        const Impact* const impact = impacts.of(c);
        const bool bounces = impact && impact->bounces();
        const ContactRows& pushed = impacts.rows[c];
        const bool held = system.held[a] || system.held[b];
        const double load = (rigid ? 1 : 0.5) * law.stiffness * contact.load;
        if (bounces || pushed.blended) {
            const Vec3 force = load * contact.normal;
            add_force(system, a, force, arm_a.cross(force));
            add_force(system, b, -force, -arm_b.cross(force));
        }
        const double stiffness = bounces && !held ? 0 : share * K;
        add_pair(system, a, b, arm_a, arm_b,
                 share * (law.along * Mat3::Identity() + (law.damping - law.along) * across),
                 pushed.blended ? Mat3(Mat3::Zero()) : Mat3(stiffness * across));
        if (!pushed.blended) continue;
        if (!bounces) {  // else its elasticity is counted, and comes by aim()
            for (const FrameRow& row : pushed.rows) {
                system.right[row.frame] += system.dt * load * row.along;
            }
        }
        add_along(system, pushed.rows, 0, stiffness);
    }
    damp_resting(impacts, system);
}

// Viscous friction where two rigid bodies touch; none on a collider without friction.
void add_rubbing(const LayeredMoment& moment, const LayerStop& stop, std::size_t a, std::size_t b,
                 const Vec3& arm_a, const Vec3& arm_b, LayeredSystem& system)
{
    const LayerMatter& own = moment.bodies[stop.body].matter;
    const LayerMatter& other = moment.bodies[stop.other].matter;
    if (!(stop.area > 0) || !(other.grip > 0)) return;
    const bool collider = other.grip < std::numeric_limits<double>::infinity();
    const double lambda = collider ? own.friction : 0.5 * (own.friction + other.friction);
    const Mat3 C = stop.area * lambda * (Mat3::Identity() - stop.normal * stop.normal.transpose());
    const Vec3 slip = velocity_at(moment.bodies[stop.other], stop.other_skeleton, stop.position) -
                      velocity_at(moment.bodies[stop.body], stop.skeleton, stop.position);
    const Vec3 force = C * slip;
    add_force(system, a, force, arm_a.cross(force));
    add_force(system, b, -force, -arm_b.cross(force));
    add_pair(system, a, b, arm_a, arm_b, C, Mat3::Zero());
}

void add_stops(const LayeredScene& scene, const LayeredMoment& moment, const Vec3& gravity,
               const std::vector<double>& lag, LayeredSystem& system)
{
    for (const LayerStop& stop : moment.contacts.stops) {
        const std::uint32_t fa = scene.parts[stop.body].body->layer.frame[stop.skeleton];
        const std::uint32_t fb = scene.parts[stop.other].body->layer.frame[stop.other_skeleton];
        const std::size_t a = system.frame(stop.body, fa), b = system.frame(stop.other, fb);
        const Vec3 arm_a = stop.position - moment.frames[stop.body][fa].translation();
        const Vec3 arm_b = stop.position - moment.frames[stop.other][fb].translation();
        const std::size_t before = system.stops.size();
        add_stop(system, a, b, arm_a, arm_b, stop.normal,
                 stop_room(moment, stop, falls_together(scene, stop, gravity, lag), system.dt));
        if (system.stops.size() > before && !scene.parts[stop.body].body->matter.rigid) {
            system.stops.back().body = stop.body, system.stops.back().other = stop.other;
        }
        add_rubbing(moment, stop, a, b, arm_a, arm_b, system);
    }
}

// A force of size f (positive: apart) and damping c along or against the line from b to a.
void add_central(LayeredSystem& system, std::size_t a, std::size_t b, const Vec3& line, double f,
                 double stiffness, const Mat3& damping, const Vec3& slip)
{
    const double r = line.norm();
    const Vec3 n = r > 0 ? Vec3(line / r) : Vec3(Vec3::UnitY());
    const Vec3 force = f * n - damping * slip;
    add_force(system, a, force);
    add_force(system, b, -force);
    add_pair(system, a, b, Vec3::Zero(), Vec3::Zero(), damping, stiffness * n * n.transpose());
}

// Two that push each other turn out of their line by f y / r, which no step knows of: where it is
// long, an offset y would grow to 1 + dt^2 f / (m r) times itself, and what is squeezed between
// others would be shot off. A stiffness across the line, with no force, makes up for what is too
// much for the step.
void hold_in_line(LayeredSystem& system, std::size_t a, std::size_t b, const Vec3& line, double f)
{
    constexpr double little = 0.1;  // of an offset, by which it may grow
    const double r = line.norm();
    if (!(f > 0) || !(r > 0)) return;
    double inverse = 0;  // 1/kg
    for (const std::size_t one : {a, b}) {
        if (!system.held[one]) inverse += 1 / system.mass[one](0, 0);
    }
    if (inverse == 0) return;
    const double much = f / r - little / (inverse * system.dt * system.dt);
    if (!(much > 0)) return;
    const Vec3 n = line / r;
    add_pair(system, a, b, Vec3::Zero(), Vec3::Zero(), Mat3::Zero(),
             much * (Mat3::Identity() - n * n.transpose()));
}

void add_springs(const LayeredScene& scene, std::size_t b, LayeredSystem& system)
{
    const LayeredState& state = scene.states[b];
    for (const LayerSpring& spring : scene.parts[b].body->base.springs) {
        const Vec3 line = state.position[spring.a] - state.position[spring.b];
        const double r = line.norm();
        const Vec3 n = r > 0 ? Vec3(line / r) : Vec3(Vec3::UnitY());
        add_central(system, system.frame(b, spring.a), system.frame(b, spring.b), line,
                    spring.stiffness * (spring.rest - r), spring.stiffness,
                    spring.damping * n * n.transpose(),
                    state.velocity[spring.a] - state.velocity[spring.b]);
    }
}

// About each axis of a frame, on average. kg m^2
double mean_inertia(const LayeredSystem& system, std::size_t f)
{
    return system.mass[f].bottomRightCorner<3, 3>().trace() / 3;
}

// The share of what is out of place that joints close in a step: all of it in a whole one. Were it
// so in steps cut short, these would throw limbs apart by the speed that it takes.
double closes(const LayeredSystem& system)
{
    return system.dt / system.longest;
}

// A hinge's two points, half a radius of gyration to either side, are held together by springs so
// stiff that a whole step leaves a hundredth of what was apart.
void join_hinge(const Hinge& hinge, const Transform& at_a, const Transform& at_b, std::size_t a,
                std::size_t b, double inertia, LayeredSystem& system)
{
    const double mass = std::min(system.mass[a](0, 0), system.mass[b](0, 0));
    const double half = std::sqrt(inertia / mass);
    const double k = 100 * mass / (system.dt * system.dt);
    for (const double side : {-half, half}) {
        const Vec3 pa = at_a * (hinge.point_a + side * hinge.axis_a);
        const Vec3 pb = at_b * (hinge.point_b + side * hinge.axis_b);
        const Vec3 arm_a = pa - at_a.translation(), arm_b = pb - at_b.translation();
        const Vec3 force = -k * closes(system) * (pa - pb);
        add_force(system, a, force, arm_a.cross(force));
        add_force(system, b, -force, -arm_b.cross(force));
        add_pair(system, a, b, arm_a, arm_b, Mat3::Zero(), k * Mat3::Identity());
    }
}

// Held frames are joined, and stopped at their limits, by Bullet: here only springs pull at those.
void add_hinges(const LayeredScene& scene, const LayeredMoment& moment, std::size_t b,
                LayeredSystem& system)
{
    for (const Hinge& hinge : scene.parts[b].body->base.hinges) {
        const Transform& at_a = moment.frames[b][hinge.a];
        const Transform& at_b = moment.frames[b][hinge.b];
        const std::size_t a = system.frame(b, hinge.a), c = system.frame(b, hinge.b);
        const Vec3 axis = at_a.linear() * hinge.axis_a;
        const double angle = hinge_angle(hinge, at_a, at_b);
        double stiffness = hinge.stiffness, torque = -hinge.stiffness * (angle - hinge.rest);
        if (!system.held[a]) {
            const double inertia = std::min(mean_inertia(system, a), mean_inertia(system, c));
            join_hinge(hinge, at_a, at_b, a, c, inertia, system);
            const double beyond = !has_limits(hinge)      ? 0
                                  : angle > hinge.highest ? angle - hinge.highest
                                  : angle < hinge.lowest  ? angle - hinge.lowest
                                                          : 0;
            if (beyond != 0) {  // as stiff as the joint, nearly
                const double stop = 10 * inertia / (system.dt * system.dt);
                stiffness += stop;
                torque -= stop * closes(system) * beyond;
            }
        }
        const Vec3 spin = moment.twists[b][hinge.b].angular - moment.twists[b][hinge.a].angular;
        torque -= hinge.damping * spin.dot(axis);
        add_force(system, c, Vec3::Zero(), torque * axis);
        add_force(system, a, Vec3::Zero(), -torque * axis);
        const Mat3 about = axis * axis.transpose();
        add_angular_pair(system, a, c, hinge.damping * about, stiffness * about);
    }
}

// A joint and its two frames, as they are now.
struct JointMoment {
    const Joint& joint;
    Transform at_a, at_b;
    Twist twist_a, twist_b;
    std::size_t a, b;      // in the system; a is not used where it is the world
    double mass, inertia;  // of the lighter frame

    bool to_world() const { return joint.a == Joint::world; }
    double rate(const JointRow& row) const
    {
        if (row.angular) return row.along.dot(twist_b.angular - twist_a.angular);
        return row.along.dot(twist_b.linear + twist_b.angular.cross(row.arm_b) - twist_a.linear -
                             twist_a.angular.cross(row.arm_a));
    }
};

// A force or torque f along the row on b, and against it on a, with its stiffness and damping.
void add_row(const JointMoment& at, const JointRow& row, double f, double stiffness, double damping,
             LayeredSystem& system)
{
    const Vec3 force = f * row.along;
    const Mat3 along = row.along * row.along.transpose();
    const Mat3 C = damping * along, K = stiffness * along;
    if (row.angular) {
        add_force(system, at.b, Vec3::Zero(), force);
        if (at.to_world()) return add_angular_hold(system, at.b, C, K);
        add_force(system, at.a, Vec3::Zero(), -force);
        return add_angular_pair(system, at.a, at.b, C, K);
    }
    add_force(system, at.b, force, row.arm_b.cross(force));
    if (at.to_world()) return add_hold(system, at.b, row.arm_b, C, K);
    add_force(system, at.a, -force, -row.arm_a.cross(force));
    add_pair(system, at.a, at.b, row.arm_a, row.arm_b, C, K);
}

// As hinges: by springs so stiff that a whole step leaves a hundredth of what is out of place, and
// a tenth of what is beyond a limit. Held frames are joined by Bullet.
void add_joint(const JointMoment& at, LayeredSystem& system)
{
    const double dt = system.dt;
    if (!system.held[at.b]) {
        const JointRows rows = joint_rows(at.joint, at.at_a, at.at_b);
        for (const JointRow& row : rows.all()) {
            const double beyond = row.value > row.highest  ? row.value - row.highest
                                  : row.value < row.lowest ? row.value - row.lowest
                                                           : 0;
            const bool bound = row.lowest < row.highest;
            if (bound && beyond == 0) continue;
            const double k = (bound ? 10 : 100) * (row.angular ? at.inertia : at.mass) / (dt * dt);
            add_row(at, row, -k * closes(system) * beyond, k, 0, system);
        }
    }
    const double stiffness = at.joint.stiffness, damping = at.joint.damping;
    if (stiffness == 0 && damping == 0) return;
    const JointRows rows = free_rows(at.joint, at.at_a, at.at_b);
    for (const JointRow& row : rows.all()) {
        const double f = -stiffness * row.value - damping * at.rate(row);
        add_row(at, row, f, stiffness, damping, system);
    }
}

void add_joints(const LayeredScene& scene, const LayeredMoment& moment, std::size_t b,
                LayeredSystem& system)
{
    for (const Joint& joint : scene.parts[b].body->base.joints) {
        const bool to_world = joint.a == Joint::world;
        const std::size_t two = system.frame(b, joint.b);
        const std::size_t one = to_world ? two : system.frame(b, joint.a);
        add_joint({joint, to_world ? scene.parts[b].pose : moment.frames[b][joint.a],
                   moment.frames[b][joint.b], to_world ? Twist{} : moment.twists[b][joint.a],
                   moment.twists[b][joint.b], one, two,
                   std::min(system.mass[one](0, 0), system.mass[two](0, 0)),
                   std::min(mean_inertia(system, one), mean_inertia(system, two))},
                  system);
    }
}

double weight_between(const Field& field, const std::vector<std::vector<std::uint32_t>>& on_frame,
                      std::size_t p, std::size_t q)
{
    double weight = 0;
    for (const std::uint32_t i : on_frame[p]) {
        for (const std::uint32_t j : on_frame[q]) weight = std::max(weight, field.weights(i, j));
    }
    return weight;
}

void add_particles(const LayeredScene& scene, const LayeredMoment& moment, std::size_t b,
                   LayeredSystem& system)
{
    const LayeredBody& body = *scene.parts[b].body;
    const LayeredState& state = scene.states[b];
    const Substance& s = body.base.substance;
    const double r0 = s.rest_distance, most = s.reach * r0;
    const auto window = [&](double r) {
        const double u = 1 - r * r / (most * most);
        return u > 0 ? u * u : 0;
    };
    const auto force = [&](double r) {
        const double q = std::pow(r0 / std::max(r, 0.3 * r0), 4);  // bounded where they coincide
        return s.stiffness * (q * q - q) * window(r);
    };
    const auto on_frame = skeletons_on_frames(body);
    for (std::size_t p = 0; p < state.position.size(); ++p) {
        for (std::size_t q = p + 1; q < state.position.size(); ++q) {
            const Vec3 line = state.position[p] - state.position[q];
            const double r = line.norm();
            if (!(r < most)) continue;
            // What has come apart pulls no more; what fuses begins to.
            const double weight = moment.fields[b].rule == geometry::BlendRule::sum
                                      ? 1
                                      : weight_between(moment.fields[b], on_frame, p, q);
            if (!(weight > 0)) continue;
            // Where the force is bounded it has the stiffness of where that begins.
            const double step = 1e-4 * r0, near = std::max(r, 0.3 * r0 + step);
            const double stiffness =
                std::max(0.0, (force(near - step) - force(near + step)) / (2 * step));
            const std::size_t one = system.frame(b, p), two = system.frame(b, q);
            add_central(system, one, two, line, weight * force(r), weight * stiffness,
                        weight * s.friction * window(r) * Mat3::Identity(),
                        state.velocity[p] - state.velocity[q]);
            hold_in_line(system, one, two, line, weight * force(r));
        }
    }
}

void add_weight(const LayeredScene& scene, std::size_t b, const LayeredWorld& world,
                LayeredSystem& system)
{
    const std::size_t corners = scene.states[b].cubes.x.size();
    const std::size_t begin = corners > 0 ? system.corner(b, 0) : system.frame(b, 0);
    const std::size_t count = corners > 0 ? corners : mass_count(scene.parts[b].body->base);
    for (std::size_t f = begin; f < begin + count; ++f) {
        if (system.held[f]) continue;
        add_force(system, f, system.mass[f](0, 0) * world.gravity);
        if (world.drag > 0) add_drag(system, f, world.drag);
    }
}

}  // namespace

FallTogether falls_together(const LayeredScene& scene, const LayerStop& stop, const Vec3& gravity,
                            const std::vector<double>& lag)
{
    const double along = stop.normal.dot(gravity);
    const auto falls = [&](std::uint32_t body) {
        return scene.parts[body].body->base.kind == BaseKind::rigid ? along : 0.0;
    };
    const double own = falls(stop.body), other = falls(stop.other);
    return {other - own, 0.5 * (lag[stop.other] * other - lag[stop.body] * own)};
}

namespace {

double closing_speed(const LayeredMoment& moment, const LayerStop& stop)
{
    return stop.normal.dot(
        velocity_at(moment.bodies[stop.other], stop.other_skeleton, stop.position) -
        velocity_at(moment.bodies[stop.body], stop.skeleton, stop.position));
}

double bounce_of(const LayeredMoment& moment, const LayerStop& stop)
{
    const LayerMatter& own = moment.bodies[stop.body].matter;
    return own.rigid ? std::max(own.bounce, moment.bodies[stop.other].matter.bounce) : 0;
}

}  // namespace

bool bounces_off(const LayeredMoment& moment, const LayerStop& stop, const FallTogether& fall,
                 double dt)
{
    constexpr double least_speed = 0.3;  // m/s; below, what hits comes to rest
    if (!(bounce_of(moment, stop) > 0)) return false;
    const double speed = closing_speed(moment, stop);
    return speed > least_speed && stop.gap < (speed + dt * std::max(0.0, fall.rate)) * dt;
}

double stop_room(const LayeredMoment& moment, const LayerStop& stop, const FallTogether& fall,
                 double dt)
{
    const ContactBody& own = moment.bodies[stop.body];
    const double kept =
        own.matter.rigid ? 0 : 0.1 * moment.fields[stop.body].profile[stop.skeleton].e;
    if (bounces_off(moment, stop, fall, dt)) {
        // It bounces off the surface, not off where it is.
        const double bounce = bounce_of(moment, stop);
        const double there = closing_speed(moment, stop) + fall.behind;
        const double work = 2 * fall.rate * stop.gap;
        const double leaves_sq = bounce * bounce * (there * there + work) - work;
        return -(std::sqrt(std::max(0.0, leaves_sq)) - 0.5 * dt * fall.rate) * dt;
    }
    const double clear = stop.gap - kept;
    return clear - 0.8 * std::min(0.0, clear) - stop.closing * dt;
}

void add_forces(const LayeredScene& scene, const LayeredMoment& moment, const LayeredWorld& world,
                const Impacts& impacts, LayeredSystem& system)
{
    add_contacts(scene, moment, impacts, system);
    add_stops(scene, moment, free_fall(world), impacts.lag, system);
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const BaseKind kind = scene.parts[b].body->base.kind;
        if (is_told(kind)) continue;
        add_weight(scene, b, world, system);
        add_springs(scene, b, system);
        add_hinges(scene, moment, b, system);
        add_joints(scene, moment, b, system);
        if (kind == BaseKind::particles) add_particles(scene, moment, b, system);
    }
    add_fields(scene, moment, world.forces, system);
}

}  // namespace physics
