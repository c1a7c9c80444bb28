// Writes docs/layered-bullet.md: rigid bodies coated by implicit layers, moved by Bullet and by the
// implicit step.
//   layered_bullet_bench [docs/layered-bullet.md]

#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/layered_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>
#include <numbers>

namespace {

using namespace physics;
using geometry::SkeletonKind;

bool free_body(const LayeredPart& part)
{
    return part.body->base.kind == BaseKind::rigid;
}

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
    double microseconds = 0, steps = 0, frames = 0;
    bool warned = false;
};

// Follows a case by frames of dt, each of one step where more are not needed.
Course follow(const Case& scenario, double dt, RigidBodies rigid_bodies)
{
    LayeredScene scene = scenario.start;
    const Momenta before = momenta(scene, scenario.gravity);
    const double whole = before.energy - scenario.rest_energy;
    Course course;
    course.frames = std::round(scenario.seconds / dt);
    for (int i = 0; i < course.frames; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        scene = advance(scene, scene.parts, {scenario.gravity, 0, rigid_bodies}, dt, 1);
        course.steps += scene.states[0].report.steps;
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
        course.warned |= !scene.states[0].report.converged;
    }
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

// A star: the report warned that forces were weakened.
std::string energy(double e, const Course& course)
{
    return fmt::format("{:.3f}{}", e, course.warned ? "*" : "");
}

// What the two took, and how often they stepped.
std::string cost(const Course& bullet, const Course& own)
{
    return fmt::format("{:.1f} | {:.1f} | {:.0f} | {:.0f}", bullet.steps / bullet.frames,
                       own.steps / own.frames, 1e-3 * bullet.microseconds, 1e-3 * own.microseconds);
}
constexpr const char* cost_head = "steps a frame: Bullet | implicit | ms in all: Bullet | implicit";

void falls(std::ostream& out, const char* title, const char* what, const Case& scenario)
{
    out << "## " << title << "\n\n"
        << what
        << "\n\n| frame, ms | energy at most: Bullet | implicit | at the end: Bullet | implicit | "
           "layer pressed by: Bullet | implicit | "
        << cost_head << " |\n|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (const double ms : steps_ms) {
        const Course bullet = follow(scenario, 1e-3 * ms, RigidBodies::bullet);
        const Course own = follow(scenario, 1e-3 * ms, RigidBodies::implicit);
        out << fmt::format("| {} | {} | {} | {} | {} | {:.1f} % | {:.1f} % | {} |\n", ms,
                           energy(bullet.most, bullet), energy(own.most, own),
                           energy(bullet.end, bullet), energy(own.end, own), 100 * bullet.deepest,
                           100 * own.deepest, cost(bullet, own));
    }
    out << '\n';
}

void flights(std::ostream& out, const char* title, const char* what, const Case& scenario)
{
    out << "## " << title << "\n\n"
        << what
        << "\n\n| frame, ms | energy at most: Bullet | implicit | at the end: Bullet | implicit | "
           "momentum lost: Bullet | implicit | angular: Bullet | implicit | hinge apart, mm: "
           "Bullet "
           "| implicit | "
        << cost_head << " |\n|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    for (const double ms : steps_ms) {
        const Course bullet = follow(scenario, 1e-3 * ms, RigidBodies::bullet);
        const Course own = follow(scenario, 1e-3 * ms, RigidBodies::implicit);
        out << fmt::format("| {} | {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.3f} "
                           "| {:.3f} | {} |\n",
                           ms, energy(bullet.most, bullet), energy(own.most, own),
                           energy(bullet.end, bullet), energy(own.end, own), bullet.linear,
                           own.linear, bullet.angular, own.angular, 1e3 * bullet.gap, 1e3 * own.gap,
                           cost(bullet, own));
    }
    out << '\n';
}

}  // namespace

int main(int argc, char** argv)
{
    std::ofstream file;
    if (argc > 1) file.open(argv[1]);
    std::ostream& out = argc > 1 ? file : std::cout;
    out << "# Rigid bodies under layers: Bullet or the implicit step\n\n`Layered` has a parameter, "
           "`rigid_bodies`:\n\n- `implicit` (the default) solves rigid bodies, hinges, springs, "
           "particles, cubes and contact in one backward Euler step. It is stable at any stiffness "
           "and any step. While layers bounce it takes shorter steps. Use it for bodies that "
           "bounce, "
           "fall, lean, lie in heaps or are worked by tools, and for all bodies that are not "
           "rigid.\n- `bullet` lets Bullet move the rigid bodies and their hinges, with the forces "
           "of the layers as external forces. It keeps swings and tumbling too. It takes as many "
           "steps as the stiffness of the contact needs: 0.3 radians of the fastest oscillation in "
           "each. Use it for "
           "bodies that are thrown, swing or spin. Contacts that need more than 64 times "
           "the requested steps are weakened until they do not, and the log warns.\n\nWritten by "
           "`layered_bullet_bench docs/layered-bullet.md` on one machine. Each row is a second of "
           "motion, in frames of one step unless more are needed. Energy is the kinetic and "
           "potential energy, as a share of the initial energy. What a pressed layer stores is not "
           "counted, so a value above 1 is energy that the method creates. A star: the report "
           "warned that forces were weakened.\n\n";
    falls(out, "A ball dropped on the ground",
          "4 kg, a layer of 10 cm, K = 1e8 Pa, dropped by 20 cm, one second. There is no friction: "
          "an exact ball bounces back to its initial height.",
          ball_on_ground());
    falls(out, "A forearm dropped on the ground",
          "The forearm of graphs/figure_falls.json: K = 4e5 Pa, friction, tilted, dropped from "
          "half a metre, one second.",
          forearm_on_ground());
    flights(out, "Two limbs on a hinge, struck by a ball",
            "The same material, no gravity, one second. The impact loses energy by friction.",
            limbs_on_hinge(true));
    flights(out, "Two limbs on a hinge, alone",
            "No contact: rigid bodies and a joint. They rotate and fold for a second; exact bodies "
            "keep their energy.",
            limbs_on_hinge(false));
    return out.good() ? 0 : 1;
}
