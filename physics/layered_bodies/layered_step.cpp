#include "physics/layered_bodies/layered_step.hpp"

#include "geometry/base/stop.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/body/following_forces.hpp"
#include "physics/layered_bodies/inner_motion.hpp"
#include "physics/layered_bodies/layered_bullet.hpp"
#include "physics/layered_bodies/layered_forces.hpp"
#include "physics/layered_bodies/layered_motion.hpp"
#include "physics/layered_bodies/layered_solve.hpp"
#include "physics/layered_bodies/layered_volume.hpp"
#include "physics/layered_bodies/step_length.hpp"
#include "physics/layered_bodies/substance_parts.hpp"
#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace physics {

// Turns all that has mass about the middle of it.
static void spin_up(const LayeredBody& body, const Vec3& spin, LayeredState& state)
{
    if (spin.isZero(0) || is_told(body.base.kind)) return;
    if (body.base.cubes) {
        const auto& cubes = body.base.cubes->source().cubes.corners;
        Vec3 centre = Vec3::Zero();
        for (const auto& corners : cubes) {
            for (const std::uint32_t k : corners) centre += state.cubes.x[k];
        }
        centre /= static_cast<double>(8 * cubes.size());
        for (std::size_t k = 0; k < state.cubes.x.size(); ++k) {
            state.cubes.v[k] += spin.cross(state.cubes.x[k] - centre);
        }
        return;
    }
    double mass = 0;
    Vec3 moment = Vec3::Zero();
    for (std::size_t f = 0; f < state.position.size(); ++f) {
        mass += body.base.mass[f];
        moment += body.base.mass[f] * state.position[f];
    }
    for (std::size_t f = 0; f < state.position.size(); ++f) {
        state.velocity[f] += spin.cross(state.position[f] - moment / mass);
        if (body.base.kind == BaseKind::rigid) state.spin[f] = spin;
    }
}

static LayeredState start(const LayeredPart& part)
{
    const LayeredBody& body = *part.body;
    LayeredState state;
    for (const Transform& frame : told_frames(part)) {
        state.position.push_back(frame.translation());
        state.rotation.push_back(Eigen::Quaterniond(frame.linear()).coeffs());
    }
    state.velocity.assign(body.base.frames.size(), part.velocity);
    state.spin.assign(body.base.frames.size(), Vec3::Zero());
    if (body.base.cubes) {
        state.cubes = rest_state(body.base.cubes->bricks());
        for (Vec3& x : state.cubes.x) x = part.pose * x;
        state.cubes.v.assign(state.cubes.x.size(), part.velocity);
    }
    spin_up(body, part.spin, state);
    if (body.base.cubes) follow_cubes(body, state);
    state.translation.assign(body.layer.skeletons.size(), 0);
    state.part = body.layer.blend.part;
    if (state.part.empty() && body.layer.blend.rule != geometry::BlendRule::sum) {
        state.part.resize(body.layer.skeletons.size());
        std::iota(state.part.begin(), state.part.end(), 0u);
    }
    state.links = body.layer.blend.links;
    return state;
}

LayeredScene start(std::vector<LayeredPart> parts)
{
    LayeredScene scene;
    for (const LayeredPart& part : parts) scene.states.push_back(start(part));
    scene.parts = std::move(parts);
    settle_volumes(scene, 0);
    return scene;
}

void check_rigid_bodies(std::span<const LayeredPart> parts, RigidBodies rigid_bodies)
{
    if (rigid_bodies == RigidBodies::implicit) return;
    for (std::size_t b = 0; b < parts.size(); ++b) {
        const BaseKind kind = parts[b].body->base.kind;
        if (kind == BaseKind::rigid || kind == BaseKind::still) continue;
        throw std::invalid_argument(fmt::format(
            "rigid_bodies = bullet supports rigid and still bodies only; body {} is {}. Set "
            "rigid_bodies to implicit, or move that body in a Layered node of its own.",
            b, kind == BaseKind::particles ? "made of particles" : "carried by cubes"));
    }
}

namespace {

// A frame of the film, that starts as `scene` is and ends as `told`.
struct FilmFrame {
    const LayeredScene& scene;
    const std::vector<LayeredPart>& told;
    const LayeredWorld& world;
    double dt;

    LayeredScene begin() const
    {
        LayeredScene now{told, scene.states};
        for (std::size_t b = 0; b < now.states.size(); ++b) {
            LayeredState& state = now.states[b];
            state.report = {};
            state.penetration = 0;
            // A mesh that moves is sampled anew: the walk of each sample begins at its skeleton.
            if (state.distance.size() == told[b].body->samples.count()) continue;
            state.distance.clear();
            state.pressed.clear();
        }
        return now;
    }
};

// What is seen of all bodies in step number `step` of so many, and what their controllers do in it.
void watch(const FilmFrame& frame, const LayeredMoment& moment, int step, int steps,
           LayeredScene& now)
{
    const double h = frame.dt / steps;
    for (std::uint32_t b = 0; b < now.parts.size(); ++b) {
        const LayeredBody& body = *now.parts[b].body;
        LayeredState& state = now.states[b];
        const auto inflation = [&](int at) {
            return sought(frame.scene.parts[b], frame.told[b], static_cast<double>(at) / steps);
        };
        keep_seen(moment, b, state);
        state.inflation = inflation(step);
        keep_volume(body, body.control, moment.walks[b], inflation(step + 1), h, state);
        if (body.base.kind == BaseKind::particles &&
            body.layer.blend.rule != geometry::BlendRule::sum) {
            update_parts(body, b, moment, h, state);
        }
        state.time += h;
        state.report.steps += 1;
    }
}

// Volumes that nothing controls are told of the last step alone.
Drawn drawn_in(int step, int steps)
{
    return step + 1 == steps ? Drawn::all : Drawn::controlled;
}

void step_implicitly(const FilmFrame& frame, int steps, LayeredScene& now)
{
    const double h = frame.dt / steps;
    for (int step = 0; step < steps; ++step) {
        geometry::stop_if_asked();
        drive_all(frame.dt - h * step, now);
        move_meshes(now, frame.scene, frame.told, static_cast<float>(step), steps);
        // As they are at the step's end: forces there meet what backward Euler makes of frames.
        change_shapes(frame.told, static_cast<double>(step + 1) / steps, now);
        const LayeredMoment moment(now, h, drawn_in(step, steps));
        LayeredSystem system = make_system(now, moment, h);
        add_forces(now, moment, frame.world, system);
        Report report;
        const std::vector<Vec6> dv = solve(system, report);
        watch(frame, moment, step, steps, now);
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            const LayeredBody& body = *now.parts[b].body;
            LayeredState& state = now.states[b];
            if (body.base.cubes) {
                state.cubes.rotation = cube_rotations(system, b);
                move_cubes(body, std::span(dv).subspan(system.corner(b, 0)), h, state);
            } else {
                move(body, std::span(dv).subspan(system.frame(b, 0), state.position.size()), h,
                     state);
            }
            state.report.iterations += report.iterations;
            state.report.converged &= report.converged;
        }
    }
}

// Rigid bodies by Bullet, under forces found in the middle of each step. Returns `steps`, or how
// many more to begin the frame again with: as soon as contact has become so stiff that they are too
// few, but no more than `most`. With so many it goes on: forces that are too stiff even so lose of
// their strength what they must to stay stable, and the report warns. What it leaves is looked at
// too, or the frame's last half step could come into a layer unseen and the next one's first come
// out of it, with energy made or lost: the state says how many steps it wants.
int step_with_bullet(const FilmFrame& frame, int steps, int most, LayeredScene& now)
{
    const double h = frame.dt / steps;
    BulletBodies bodies(now, frame.world);
    const auto drift = [&] {
        bodies.drift(now, 0.5 * h);
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            const LayeredBody& body = *now.parts[b].body;
            if (body.base.kind == BaseKind::still) coast(body, 0.5 * h, now.states[b]);
        }
    };
    const auto begin_again = [&](const ExplicitSteps& wanted) {
        // One step too long has gone too deep and sees too much: by threes at most.
        const double enough = std::min({1.1 * wanted.steps, 3.0 * steps, double(most)});
        return std::max(steps + 1, static_cast<int>(enough));
    };
    ExplicitSteps hardest;
    for (int step = 0; step <= steps; ++step) {
        geometry::stop_if_asked();
        const bool end = step == steps;  // what the last half step came into, or is to come out of
        if (!end) {
            drive_all(frame.dt - h * step, now);
            drift();
        }
        const float at = static_cast<float>(step) + (end ? 0 : 0.5f);
        move_meshes(now, frame.scene, frame.told, at, steps);
        change_shapes(frame.told, static_cast<double>(at) / steps, now);
        const LayeredMoment moment(now, h, drawn_in(step, steps));
        LayeredSystem system = make_system(now, moment, h, RigidBodies::bullet);
        add_forces(now, moment, frame.world, system);
        const ExplicitSteps wanted = explicit_steps(now, system, frame.dt);
        if (wanted.steps > steps && steps < most) return begin_again(wanted);
        for (LayeredState& state : now.states) state.steps_per_second = 0;
        now.states[wanted.part].steps_per_second = wanted.steps / frame.dt;
        if (end) break;
        if (wanted.steps > hardest.steps) hardest = wanted;
        const double share = std::min(1.0, steps / wanted.steps);
        bodies.push(now, moment, system, share * share, h);
        watch(frame, moment, step, steps, now);
        drift();
    }
    if (hardest.steps > steps) {
        Report& report = now.states[hardest.part].report;
        report.converged = false;
        report.warnings.push_back(fmt::format(
            "Body {} needs {:.0f} steps per frame to stay stable with Bullet, and gets {}: its "
            "contact forces were weakened. Set rigid_bodies to implicit, raise substeps, or "
            "lower the layers' stiffness.",
            hardest.part, std::ceil(hardest.steps), steps));
    }
    return steps;
}

bool same_cubes(const LayeredPart& part, const LayeredState& state)
{
    const auto& cubes = part.body->base.cubes;
    return state.cubes.x.size() == (cubes ? cubes->source().cubes.corner_count() : 0) &&
           state.cubes.v.size() == state.cubes.x.size();
}

// Exactly there; skeletons that had frames of their own are back in those of their body.
void keep_told(const std::vector<Transform>& at, LayeredState& state)
{
    for (auto* of_frames : {&state.position, &state.velocity, &state.spin}) {
        of_frames->resize(at.size(), Vec3::Zero());
    }
    state.rotation.resize(at.size());
    for (std::size_t f = 0; f < at.size(); ++f) {
        state.position[f] = at[f].translation();
        state.rotation[f] = Eigen::Quaterniond(at[f].linear()).normalized().coeffs();
    }
}

}  // namespace

LayeredScene advance(const LayeredScene& scene, std::vector<LayeredPart> parts,
                     const LayeredWorld& world, double dt, int substeps)
{
    for (const LayeredPart& part : parts) {
        check_pins(part.pins, part.body->base.cubes
                                  ? part.body->base.cubes->source().cubes.corner_count()
                                  : 0);
    }
    bool same = parts.size() == scene.states.size();
    for (std::size_t b = 0; same && b < parts.size(); ++b) {
        same = parts[b].body->base.frames.size() == scene.states[b].position.size() &&
               parts[b].body->layer.skeletons.size() == scene.states[b].translation.size() &&
               told_frames(parts[b]).size() == scene.states[b].position.size() &&
               same_cubes(parts[b], scene.states[b]) &&
               (parts[b].muscle.empty() ||
                parts[b].muscle.size() == scene.states[b].translation.size()) &&
               (scene.states[b].distance.empty() || parts[b].body->base.kind == BaseKind::still ||
                scene.states[b].distance.size() == parts[b].body->samples.count());
    }
    if (!same) {
        throw std::invalid_argument(fmt::format(
            "the layered bodies changed between frames: a scene of {} bodies must keep its "
            "bodies, frames and skeletons, got {} bodies. A mesh that moves needs base = still",
            scene.states.size(), parts.size()));
    }
    check_rigid_bodies(parts, world.rigid_bodies);
    check_forces(world.forces);
    require_no_following(world.forces, "Layered");
    const FilmFrame frame{scene, parts, world, dt};
    LayeredScene now = frame.begin();
    if (!(dt > 0) || now.states.empty()) return now;
    split_moved_frames(scene, dt, now);
    int steps = choose_steps(now, world.gravity, dt, std::max(1, substeps));
    if (world.rigid_bodies == RigidBodies::implicit) {
        step_implicitly(frame, steps, now);
    } else {
        const int most = std::max(steps, most_steps(std::max(1, substeps)));
        for (const LayeredState& state : now.states) {
            const double enough =
                std::min<double>(most, std::ceil(1.1 * dt * state.steps_per_second));
            steps = std::max(steps, static_cast<int>(enough));
        }
        const std::vector<LayeredState> begin = now.states;
        for (int more = step_with_bullet(frame, steps, most, now); more > steps;
             more = step_with_bullet(frame, steps, most, now)) {
            steps = more;
            now.states = begin;
        }
    }
    now.parts = frame.told;
    // Still frames end exactly where they were told to.
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        if (now.parts[b].body->base.kind != BaseKind::still) continue;
        keep_told(told_frames(now.parts[b]), now.states[b]);
    }
    settle_volumes(now, dt);
    return now;
}

}  // namespace physics
