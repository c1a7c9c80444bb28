// Writes docs/layered-bullet.md: bodies coated by implicit layers, their base structures stepped by
// Bullet with the layers' contact handed to it as forces, beside Aspic's own step.
//   layered_bullet_bench [docs/layered-bullet.md]

#include <fmt/format.h>

#include <iostream>

#ifndef ASPIC_HAVE_BULLET

int main()
{
    std::cout << "Bullet was not found when this was built.\n";
}

#else

#include "physics/layered.hpp"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <memory>
#include <numbers>

namespace {

using namespace physics;
using geometry::SkeletonKind;

btVector3 to_bullet(const Vec3& v)
{
    return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())};
}

btQuaternion to_bullet(const Eigen::Quaterniond& q)
{
    return {btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())};
}

Vec3 from_bullet(const btVector3& v)
{
    return {double(v.x()), double(v.y()), double(v.z())};
}

bool free_body(const LayeredPart& part)
{
    return part.body->base.kind == BaseKind::rigid;
}

// The free bodies of a scene in a world of Bullet's, which sees no shapes: contact is the layers'.
class BulletBase {
public:
    BulletBase(const LayeredScene& scene, const Vec3& gravity)
        : dispatcher_(&configuration_),
          world_(&dispatcher_, &broadphase_, &solver_, &configuration_), bodies_(scene.parts.size())
    {
        world_.setGravity(to_bullet(gravity));
        for (std::size_t b = 0; b < scene.parts.size(); ++b) {
            if (!free_body(scene.parts[b])) continue;
            for (std::size_t f = 0; f < scene.states[b].position.size(); ++f) add(scene, b, f);
            for (const Hinge& hinge : scene.parts[b].body->base.hinges) add(b, hinge);
        }
    }
    BulletBase(const BulletBase&) = delete;
    BulletBase& operator=(const BulletBase&) = delete;
    ~BulletBase()
    {
        for (const auto& hinge : hinges_) world_.removeConstraint(hinge.get());
        for (const auto& of_part : bodies_) {
            for (const Limb& limb : of_part) world_.removeRigidBody(limb.body.get());
        }
    }

    // Moves the scene's free bodies on by dt seconds under these forces.
    void step(LayeredScene& scene, const std::vector<std::vector<Wrench>>& wrenches, double dt)
    {
        for (std::size_t b = 0; b < bodies_.size(); ++b) {
            for (std::size_t f = 0; f < bodies_[b].size(); ++f) {
                bodies_[b][f].body->applyCentralForce(to_bullet(wrenches[b][f].force));
                bodies_[b][f].body->applyTorque(to_bullet(wrenches[b][f].torque));
            }
        }
        world_.stepSimulation(btScalar(dt), 0);
        for (std::size_t b = 0; b < bodies_.size(); ++b) {
            for (std::size_t f = 0; f < bodies_[b].size(); ++f) {
                const Limb& limb = bodies_[b][f];
                const btTransform& at = limb.body->getCenterOfMassTransform();
                const btQuaternion q = at.getRotation();
                const Eigen::Quaterniond turn(double(q.w()), double(q.x()), double(q.y()),
                                              double(q.z()));
                LayeredState& state = scene.states[b];
                state.position[f] = from_bullet(at.getOrigin());
                state.rotation[f] = (turn * limb.axes.conjugate()).normalized().coeffs();
                state.velocity[f] = from_bullet(limb.body->getLinearVelocity());
                state.spin[f] = from_bullet(limb.body->getAngularVelocity());
            }
        }
    }

private:
    struct Limb {
        std::unique_ptr<btRigidBody> body;
        Eigen::Quaterniond axes;  // of inertia, in the frame
    };

    void add(const LayeredScene& scene, std::size_t b, std::size_t f)
    {
        const Base& base = scene.parts[b].body->base;
        const LayeredState& state = scene.states[b];
        const Eigen::SelfAdjointEigenSolver<Mat3> own(base.inertia[f]);
        Mat3 axes = own.eigenvectors();
        if (axes.determinant() < 0) axes.col(0) *= -1;
        Limb limb{nullptr, Eigen::Quaterniond(axes)};
        limb.body = std::make_unique<btRigidBody>(btScalar(base.mass[f]), nullptr, &no_shape_,
                                                  to_bullet(own.eigenvalues()));
        limb.body->setCenterOfMassTransform(
            btTransform(to_bullet(Eigen::Quaterniond(state.rotation[f]) * limb.axes),
                        to_bullet(state.position[f])));
        limb.body->setLinearVelocity(to_bullet(state.velocity[f]));
        limb.body->setAngularVelocity(to_bullet(state.spin[f]));
        limb.body->setDamping(0, 0);
        limb.body->setActivationState(DISABLE_DEACTIVATION);
        world_.addRigidBody(limb.body.get(), 1, 0);
        bodies_[b].push_back(std::move(limb));
    }

    void add(std::size_t b, const Hinge& hinge)
    {
        const Limb &one = bodies_[b][hinge.a], &two = bodies_[b][hinge.b];
        const auto own = [](const Limb& limb, const Vec3& v) {
            return to_bullet(Vec3(limb.axes.conjugate() * v));
        };
        hinges_.push_back(std::make_unique<btHingeConstraint>(
            *one.body, *two.body, own(one, hinge.point_a), own(two, hinge.point_b),
            own(one, hinge.axis_a), own(two, hinge.axis_b)));
        hinges_.back()->setLimit(1, -1);  // none
        world_.addConstraint(hinges_.back().get(), true);
    }

    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDbvtBroadphase broadphase_;
    btSequentialImpulseConstraintSolver solver_;
    btDiscreteDynamicsWorld world_;
    btEmptyShape no_shape_;
    std::vector<std::vector<Limb>> bodies_;
    std::vector<std::unique_ptr<btHingeConstraint>> hinges_;
};

struct Momenta {
    Vec3 linear = Vec3::Zero();   // N s
    Vec3 angular = Vec3::Zero();  // N m s, about the world's origin
    double energy = 0;            // J, of motion and height
};

Momenta momenta(const LayeredScene& scene, const Vec3& gravity)
{
    Momenta sum;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (!free_body(scene.parts[b])) continue;
        const Base& base = scene.parts[b].body->base;
        const LayeredState& state = scene.states[b];
        for (std::size_t f = 0; f < state.position.size(); ++f) {
            const Mat3 turn = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
            const Vec3 p = base.mass[f] * state.velocity[f];
            const Vec3 spin = turn * base.inertia[f] * turn.transpose() * state.spin[f];
            sum.linear += p;
            sum.angular += state.position[f].cross(p) + spin;
            sum.energy += 0.5 * (p.dot(state.velocity[f]) + spin.dot(state.spin[f])) -
                          base.mass[f] * gravity.dot(state.position[f]);
        }
    }
    return sum;
}

// How far a hinge's points have come apart, m.
double hinge_gap(const LayeredScene& scene)
{
    double most = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const LayeredState& state = scene.states[b];
        for (const Hinge& hinge : scene.parts[b].body->base.hinges) {
            const auto at = [&](std::uint32_t f, const Vec3& p) {
                return Vec3(state.position[f] + Eigen::Quaterniond(state.rotation[f]) * p);
            };
            most = std::max(most, (at(hinge.a, hinge.point_a) - at(hinge.b, hinge.point_b)).norm());
        }
    }
    return most;
}

// How far into their layer the lowest skeleton has been pressed by the ground at 0: 1 is all of it.
double pressed(const LayeredScene& scene)
{
    double most = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (!free_body(scene.parts[b])) continue;
        const ImplicitLayer& layer = scene.parts[b].body->layer;
        for (std::size_t s = 0; s < layer.skeletons.size(); ++s) {
            const std::uint32_t f = layer.frame[s];
            for (const Vec3& p : layer.skeletons[s].points) {
                const double y = (scene.states[b].position[f] +
                                  Eigen::Quaterniond(scene.states[b].rotation[f]) * p)
                                     .y();
                most = std::max(most, 1 - y / layer.contributions[s].thickness);
            }
        }
    }
    return most;
}

struct Case {
    LayeredScene start;
    Vec3 gravity = Vec3::Zero();
    double rest_energy = 0;  // J, where the energy is counted from
    double seconds = 1;
};

struct Course {
    double most = 0, end = 0;        // of the energy at the start
    double deepest = 0;              // pressed(), at worst
    double linear = 0, angular = 0;  // momentum at the end less that at the start, of its size
    double gap = 0;                  // m, of hinges, at worst
    double microseconds = 0, steps = 0;
    double soonest = 1e9;  // s: 2 / sqrt(K k A / m), its least over the contacts that there were
};

// Follows a case by frames of dt. `step` moves the scene on and says in how many steps.
template <class Step> Course follow(const Case& scenario, double dt, const Step& step)
{
    LayeredScene scene = scenario.start;
    const Momenta before = momenta(scene, scenario.gravity);
    const double whole = before.energy - scenario.rest_energy;
    Course course;
    const auto frames = static_cast<int>(std::lround(scenario.seconds / dt));
    for (int i = 0; i < frames; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        course.steps += step(scene);
        course.microseconds +=
            std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin)
                .count();
        const Momenta now = momenta(scene, scenario.gravity);
        course.end = (now.energy - scenario.rest_energy) / whole;
        course.most = std::max(course.most, course.end);
        course.deepest = std::max(course.deepest, pressed(scene));
        course.gap = std::max(course.gap, hinge_gap(scene));
        course.linear = (now.linear - before.linear).norm() / before.linear.norm();
        course.angular = (now.angular - before.angular).norm() / before.angular.norm();
        if (!std::isfinite(now.energy) || course.most > 1e6) {
            course.most = course.end = std::numeric_limits<double>::infinity();
            break;
        }
    }
    return course;
}

Course by_aspic(const Case& scenario, double dt)
{
    return follow(scenario, dt, [&](LayeredScene& scene) {
        scene = advance(scene, scene.parts, {scenario.gravity, 0}, dt, 1);
        return scene.states[0].report.steps;
    });
}

Course by_bullet(const Case& scenario, double dt)
{
    BulletBase base(scenario.start, scenario.gravity);
    double soonest = std::numeric_limits<double>::infinity();
    Course course = follow(scenario, dt, [&](LayeredScene& scene) {
        const LayeredMoment moment(scene);
        std::vector<double> stiffness(scene.parts.size(), 0);
        for (const LayerContact& contact : moment.contacts.contacts) {
            const double slope = moment.fields[contact.body].profile[contact.skeleton].k;
            stiffness[contact.body] +=
                contact_law(moment.bodies, contact).stiffness * slope * contact.area;
        }
        for (std::size_t b = 0; b < scene.parts.size(); ++b) {
            scene.states[b].distance = moment.walks[b].distance;
            if (!(stiffness[b] > 0)) continue;
            const double mass = scene.parts[b].body->base.mass[0];
            soonest = std::min(soonest, 2 / std::sqrt(stiffness[b] / mass));
        }
        base.step(scene, moment.contacts.wrenches, dt);
        return 1;
    });
    course.soonest = soonest;
    return course;
}

LayeredPart rigid_body(ImplicitLayer layer, double density, double spacing,
                       const LayerMatter& matter)
{
    LayeredBody body = make_layered_body(std::move(layer), BaseKind::rigid, density, spacing);
    body.matter = matter;
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(std::move(body));
    return part;
}

LayeredPart ground()
{
    Collider plane;
    plane.friction = 0;
    return rigid_part(plane);
}

// A ball of 4 kg and 10 cm at K = 1e8 Pa, dropped by 20 cm. No friction: it should bounce for ever.
Case ball_on_ground()
{
    ImplicitLayer layer;
    layer.skeletons = {{.kind = SkeletonKind::point, .points = {{0, 0.3, 0}}}};
    layer.contributions = {{.thickness = 0.1, .stiffness = 10, .radius = 0.2}};
    layer.frame = {0};
    const double density = 4 / (4.0 / 3 * std::numbers::pi * 1e-3);
    Case out;
    out.gravity = {0, -9.81, 0};
    out.rest_energy = 4 * 9.81 * 0.1;
    out.start =
        start({rigid_body(layer, density, 0.005, {.stiffness = 1e8, .friction = 0}), ground()});
    return out;
}

// The matter of graphs/figure_falls.json.
constexpr LayerMatter flesh{
    .stiffness = 4e5, .friction = 2e4, .bulge_width = 0.02, .bulge_height = 0.15};

ImplicitLayer limbs(int count, double height)
{
    ImplicitLayer layer;
    for (int i = 0; i < count; ++i) {
        const double side = i == 0 ? 1 : -1;
        layer.skeletons.push_back({.kind = SkeletonKind::segment,
                                   .points = {{0.04 * side, height, 0}, {0.3 * side, height, 0}}});
        layer.contributions.push_back({.thickness = 0.065, .stiffness = 14, .radius = 0.2});
        layer.frame.push_back(static_cast<std::uint32_t>(i));
    }
    if (count > 1) layer.blend.rule = geometry::BlendRule::smooth_groups;
    if (count > 1) layer.blend.links = {{0, 1, 1}};
    return layer;
}

// A forearm of that figure, half a metre above the ground, tilted so that an end comes first.
Case forearm_on_ground()
{
    Case out;
    out.gravity = {0, -9.81, 0};
    LayeredPart arm = rigid_body(limbs(1, 0), 1000, 0.01, flesh);
    out.rest_energy = arm.body->base.mass[0] * 9.81 * 0.065;
    arm.pose.translate(Vec3(0, 0.5, 0)).rotate(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
    out.start = start({arm, ground()});
    return out;
}

// Two such limbs on a hinge without limits or friction, far from everything; `hit`: a ball comes
// and strikes one.
Case limbs_on_hinge(bool hit)
{
    LayeredBody body = make_layered_body(limbs(2, 0), BaseKind::rigid, 1000, 0.01);
    body.matter = flesh;
    add_hinge(body.base, 0, 1, Vec3::Zero(), Vec3::UnitZ());
    LayeredPart pair;
    pair.body = std::make_shared<const LayeredBody>(std::move(body));
    std::vector<LayeredPart> parts{pair};
    if (hit) {
        ImplicitLayer layer;
        layer.skeletons = {{.kind = SkeletonKind::point, .points = {{0.25, -0.2, 0.01}}}};
        layer.contributions = {{.thickness = 0.1, .stiffness = 10, .radius = 0.2}};
        layer.frame = {0};
        LayeredPart ball = rigid_body(layer, 1000, 0.01, flesh);
        ball.velocity = {0, 3, 0};
        parts.push_back(ball);
    }
    Case out;
    out.start = start(std::move(parts));
    if (!hit) {  // turns as a whole, and folds
        LayeredState& state = out.start.states[0];
        state.spin = {Vec3(0.5, 1, 6), Vec3(0.5, 1, -2)};
        for (std::size_t f = 0; f < 2; ++f) {
            state.velocity[f] = Vec3(0.3, 0.2, 0) + state.spin[f].cross(state.position[f]);
        }
    }
    return out;
}

constexpr double steps_ms[] = {0.1, 1, 2, 5, 10, 50, 100};

std::string energy(double e)
{
    return std::isfinite(e) ? fmt::format("{:.3f}", e) : "without bound";
}

void falls(std::ostream& out, const char* title, const char* what, const Case& scenario)
{
    out << "## " << title << "\n\n"
        << what
        << "\n\n| frame, ms | energy at most: Bullet | Aspic | at the end: Bullet | Aspic | layer "
           "pressed by: Bullet | Aspic | steps of Aspic a frame | us a step: Bullet | Aspic |\n"
           "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    double soonest = 0;
    for (const double ms : steps_ms) {
        const double dt = 1e-3 * ms;
        const Course bullet = by_bullet(scenario, dt), own = by_aspic(scenario, dt);
        if (soonest == 0) soonest = bullet.soonest;
        out << fmt::format("| {} | {} | {} | {} | {} | {:.1f} % | {:.1f} % | {:.1f} | {:.0f} | "
                           "{:.0f} |\n",
                           ms, energy(bullet.most), energy(own.most), energy(bullet.end),
                           energy(own.end), 100 * bullet.deepest, 100 * own.deepest,
                           own.steps / std::round(scenario.seconds / dt),
                           bullet.microseconds / bullet.steps, own.microseconds / own.steps);
    }
    // The shortest step of a ladder of eighths of an octave that makes energy.
    double unstable = 0;
    for (int i = 0; unstable == 0 && i < 72; ++i) {
        const double dt = 2e-4 * std::exp2(0.125 * i);
        if (by_bullet(scenario, dt).most > 1.02) unstable = dt;
    }
    out << fmt::format(
        "\nBullet makes energy (more than 2 % of what there was) from steps of {:.2f} "
        "ms on. By the formula, 2 / sqrt(K k A / m) with the largest contact that "
        "there was, it may from {:.2f} ms on.\n\n",
        1e3 * unstable, 1e3 * soonest);
}

void flights(std::ostream& out, const char* title, const char* what, const Case& scenario)
{
    out << "## " << title << "\n\n"
        << what
        << "\n\n| frame, ms | energy at most: Bullet | Aspic | at the end: Bullet | Aspic | "
           "momentum lost: Bullet | Aspic | angular: Bullet | Aspic | hinge apart, mm: Bullet | "
           "Aspic | us a step: Bullet | Aspic |\n"
           "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (const double ms : steps_ms) {
        const Course bullet = by_bullet(scenario, 1e-3 * ms), own = by_aspic(scenario, 1e-3 * ms);
        out << fmt::format("| {} | {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.3f} "
                           "| {:.3f} | {:.0f} | {:.0f} |\n",
                           ms, energy(bullet.most), energy(own.most), energy(bullet.end),
                           energy(own.end), bullet.linear, own.linear, bullet.angular, own.angular,
                           1e3 * bullet.gap, 1e3 * own.gap, bullet.microseconds / bullet.steps,
                           own.microseconds / own.steps);
    }
    out << '\n';
}

}  // namespace

int main(int argc, char** argv)
{
    std::ofstream file;
    if (argc > 1) file.open(argv[1]);
    std::ostream& out = argc > 1 ? file : std::cout;
    out << fmt::format(
        "# Implicit layers on Bullet's bodies and on ours\n\n"
        "Written by `layered_bullet_bench docs/layered-bullet.md` with Bullet {} ({} precision), "
        "on the machine at hand. Both are given the same bodies, and the same contact found by the "
        "same code at the start of each step. Bullet's rigid bodies and hinges take it as outside "
        "forces; Aspic's step has its stiffness and damping in its system. Energy is that of "
        "motion and height, as a share of what there was: what a layer stores while it is pressed "
        "is not counted, so more than 1 is made from nothing.\n\n",
        btGetVersion(), sizeof(btScalar) == 4 ? "single" : "double");
    falls(out, "A ball dropped on the ground",
          "4 kg, a layer of 10 cm, K = 1e8 Pa, dropped by 20 cm, one second. Nothing rubs: the "
          "exact ball bounces back to where it was let go.",
          ball_on_ground());
    falls(out, "A forearm dropped on the ground",
          "That of graphs/figure_falls.json: K = 4e5 Pa, friction, tilted, dropped from half a "
          "metre, one second.",
          forearm_on_ground());
    flights(out, "Two limbs on a hinge, struck by a ball",
            "The same matter, no gravity, one second. The blow itself loses energy by friction.",
            limbs_on_hinge(true));
    flights(out, "Two limbs on a hinge, alone",
            "Nothing touches: rigid bodies and a joint. They turn and fold for a second; the exact "
            "ones keep their energy.",
            limbs_on_hinge(false));
    return out.good() ? 0 : 1;
}

#endif
