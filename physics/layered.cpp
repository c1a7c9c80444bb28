#include "physics/layered.hpp"

#include "geometry/sets.hpp"
#include "physics/layered_bullet.hpp"
#include "physics/layered_forces.hpp"
#include "physics/layered_pace.hpp"
#include "physics/layered_system.hpp"
#include "physics/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <stdexcept>

namespace physics {

using geometry::BlendLink;
using geometry::Skeleton;

namespace {

// Puts the frames where their cubes carry them.
void follow_cubes(const LayeredBody& body, LayeredState& state)
{
    const CubeBase& base = *body.base.cubes;
    for (std::size_t f = 0; f < body.base.frames.size(); ++f) {
        const FrameHold hold = base.hold(f, body.base.frames[f], state.cubes.x);
        const Transform at = hold.moved * body.base.frames[f];
        Vec6 twist = Vec6::Zero();
        for (std::size_t a = 0; a < hold.by.size(); ++a) {
            twist += hold.by[a] * state.cubes.v[base.corners(f)[a]];
        }
        state.position[f] = at.translation();
        state.rotation[f] = Eigen::Quaterniond(at.linear()).normalized().coeffs();
        state.velocity[f] = twist.head<3>();
        state.spin[f] = twist.tail<3>();
    }
}

LayeredState start(const LayeredPart& part)
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
        follow_cubes(body, state);
    }
    state.translation.assign(body.layer.skeletons.size(), 0);
    state.part = body.layer.blend.part;
    if (state.part.empty() && body.layer.blend.rule != geometry::BlendRule::sum) {
        state.part.resize(body.layer.skeletons.size());
        std::iota(state.part.begin(), state.part.end(), 0u);
    }
    state.links = body.layer.blend.links;
    return state;
}

}  // namespace

LayeredScene start(std::vector<LayeredPart> parts)
{
    LayeredScene scene;
    for (const LayeredPart& part : parts) scene.states.push_back(start(part));
    scene.parts = std::move(parts);
    return scene;
}

std::size_t LayeredState::bytes() const
{
    return position.size() * (3 * sizeof(Vec3) + sizeof(Eigen::Vector4d)) +
           (translation.size() + volume.size() + inflation.size() + expected_error.size() +
            distance.size()) *
               sizeof(double) +
           pressed.size() * sizeof(float) + links.size() * sizeof(BlendLink) +
           part.size() * sizeof(std::uint32_t) + 2 * cubes.x.size() * sizeof(Vec3) +
           cubes.rotation.size() * sizeof(float);
}

std::size_t LayeredScene::bytes() const
{
    std::size_t sum = 0;
    for (const LayeredState& state : states) sum += sizeof(state) + state.bytes();
    return sum;
}

double interpenetration(const LayeredScene& scene)
{
    double worst = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        double thinnest = std::numeric_limits<double>::infinity();
        for (const geometry::Contribution& c : scene.parts[b].body->layer.contributions) {
            thinnest = std::min(thinnest, c.thickness);
        }
        worst = std::max(worst, scene.states[b].penetration / thinnest);
    }
    return worst;
}

std::size_t particle_count(const LayeredScene& scene)
{
    std::size_t count = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (scene.parts[b].body->base.kind != BaseKind::particles) continue;
        for (const Vec3& p : scene.states[b].position) count += p.allFinite();
    }
    return count;
}

// What chains of skeletons that are in reach of each other hold together.
static geometry::Sets chains(std::uint32_t count, const auto& in_reach)
{
    geometry::Sets sets(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = i + 1; j < count; ++j) {
            if (in_reach(i, j)) sets.join(i, j);
        }
    }
    return sets;
}

// To which piece of a soft substance each skeleton belongs.
static std::vector<std::uint32_t> pieces_of(const LayeredBody& body, const LayeredState& state)
{
    if (!state.part.empty()) return state.part;
    const ImplicitLayer& layer = body.layer;  // all blend that are in reach
    return chains(static_cast<std::uint32_t>(layer.skeletons.size()),
                  [&](std::uint32_t i, std::uint32_t j) {
                      const Vec3& at = state.position[layer.frame[i]];
                      return (at - state.position[layer.frame[j]]).norm() <
                             layer.contributions[i].radius + layer.contributions[j].radius;
                  })
        .roots();
}

std::size_t piece_count(const LayeredScene& scene)
{
    std::size_t count = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const LayeredBody& body = *scene.parts[b].body;
        if (body.base.kind != BaseKind::particles) continue;
        const std::vector<std::uint32_t> piece = pieces_of(body, scene.states[b]);
        count += std::set(piece.begin(), piece.end()).size();
    }
    return count;
}

double fastest(const LayeredScene& scene)
{
    double most = 0;
    for (const LayeredState& state : scene.states) {
        for (const Vec3& v : state.velocity) most = std::max(most, v.norm());
    }
    return most;
}

LayeredMoment::LayeredMoment(const LayeredScene& scene, double mesh_seconds)
{
    const std::size_t n = scene.parts.size();
    fields.reserve(n);
    walks.reserve(n);
    for (std::size_t b = 0; b < n; ++b) {
        const LayeredBody& body = *scene.parts[b].body;
        const LayeredState& state = scene.states[b];
        std::vector<Transform> at;
        std::vector<Twist> moving;
        for (std::size_t f = 0; f < state.position.size(); ++f) {
            Transform t = Transform::Identity();
            t.translate(state.position[f]).rotate(Eigen::Quaterniond(state.rotation[f]));
            at.push_back(t);
            moving.push_back({state.velocity[f], state.spin[f]});
        }
        ImplicitLayer layer = body.layer;
        layer.blend.part = state.part;
        layer.blend.links = state.links;
        fields.push_back(geometry::make_field(layer, at, state.translation));
        SeedWalk before;
        before.distance = state.distance;
        walks.push_back(physics::walk(fields.back(), body.seeds, at,
                                      state.distance.empty() ? nullptr : &before,
                                      body.control.proportional > 0));
        frames.push_back(std::move(at));
        twists.push_back(std::move(moving));
    }
    for (const LayeredPart& part : scene.parts) {
        meshes.push_back({part.mesh_before ? part.body->layer.skeletons[0].mesh : nullptr,
                          part.mesh_before, mesh_seconds});
    }
    for (std::size_t b = 0; b < n; ++b) {
        bodies.push_back({&fields[b], &scene.parts[b].body->seeds, &walks[b], frames[b], twists[b],
                          scene.parts[b].body->layer.frame, scene.parts[b].body->matter,
                          meshes[b].before ? &meshes[b] : nullptr});
    }
    contacts = find_contacts(bodies);
}

namespace {

// Cubes whose corners go by `dv`, and the frames that they carry. Warns where neighbours part by
// more than a cube in one step: that is more than its linear forces know of.
void move_cubes(const LayeredBody& body, std::span<const Vec6> dv, double dt, LayeredState& state)
{
    const geometry::Cubes& cubes = body.base.cubes->source().cubes;
    for (std::size_t k = 0; k < state.cubes.x.size(); ++k) {
        state.cubes.v[k] += dv[k].head<3>();
        state.cubes.x[k] += dt * state.cubes.v[k];
    }
    state.cubes.time += dt;
    double most = 0;
    for (const auto& corners : cubes.corners) {
        for (const std::uint32_t k : corners) {
            most = std::max(most, (state.cubes.v[k] - state.cubes.v[corners[0]]).norm());
        }
    }
    if (dt * most > cubes.size && state.report.converged) {
        state.report.converged = false;
        state.report.warnings.emplace_back(
            "cubes under a layer are torn along by more than their size in a step; raise substeps");
    }
    follow_cubes(body, state);
}

// Frames on their way for dt seconds.
void coast(const LayeredBody& body, double dt, LayeredState& state)
{
    for (std::size_t f = 0; f < state.position.size(); ++f) {
        state.position[f] += dt * state.velocity[f];
        const Eigen::Quaterniond before(state.rotation[f]);
        const double angle = dt * state.spin[f].norm();
        if (angle > 0) {
            const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, state.spin[f].normalized()));
            state.rotation[f] = (turn * before).normalized().coeffs();
        }
        if (body.base.kind != BaseKind::rigid) continue;
        // The turn keeps the angular momentum, not the spin.
        const Mat3 R = before.toRotationMatrix();
        const Vec3 momentum = R * body.base.inertia[f] * R.transpose() * state.spin[f];
        const Mat3 after = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
        state.spin[f] = after * body.base.inertia[f].inverse() * after.transpose() * momentum;
    }
}

void move(const LayeredBody& body, std::span<const Vec6> dv, double dt, LayeredState& state)
{
    for (std::size_t f = 0; f < state.position.size(); ++f) {
        state.velocity[f] += dv[f].head<3>();
        state.spin[f] += dv[f].tail<3>();
    }
    coast(body, dt, state);
}

// Sends told frames straight, at constant spin, to where they are to be in `left` seconds.
void drive(const std::vector<Transform>& motion, double left, LayeredState& state)
{
    for (std::size_t f = 0; f < state.position.size(); ++f) {
        state.velocity[f] = (motion[f].translation() - state.position[f]) / left;
        const Eigen::Quaterniond now(state.rotation[f]);
        const Eigen::AngleAxisd turn(Eigen::Quaterniond(motion[f].linear()) * now.conjugate());
        const double angle =
            turn.angle() > std::numbers::pi ? turn.angle() - 2 * std::numbers::pi : turn.angle();
        state.spin[f] = angle / left * turn.axis();
    }
}

// Gives pinned corners the velocity that brings them to where they are to be in `left` seconds.
void drive_pins(const LayeredPart& part, double left, LayeredState& state)
{
    if (part.pins.corner.empty()) return;
    for (std::size_t i = 0; i < part.pins.corner.size(); ++i) {
        const std::uint32_t k = part.pins.corner[i];
        state.cubes.v[k] = (part.pins.target[i] - state.cubes.x[k]) / left;
    }
    follow_cubes(*part.body, state);
}

std::vector<float> pressed_distances(const LayeredMoment& moment, std::uint32_t body)
{
    const SeedWalk& walk = moment.walks[body];
    std::vector<float> pressed(walk.distance.size());
    for (std::size_t i = 0; i < pressed.size(); ++i) {
        pressed[i] = static_cast<float>(walk.valid[i] ? walk.distance[i] : -1);
    }
    for (const LayerContact& contact : moment.contacts.contacts) {
        if (contact.body == body) pressed[contact.seed] = static_cast<float>(contact.distance);
    }
    return pressed;
}

// What the walk saw of body number b.
void keep_seen(const LayeredMoment& moment, std::uint32_t b, LayeredState& state)
{
    state.distance = moment.walks[b].distance;
    state.pressed = pressed_distances(moment, b);
    state.volume = local_volumes(moment.bodies, b, moment.contacts);
    state.penetration = std::max(state.penetration, moment.contacts.penetration[b]);
}

// What a part is told to seek of each territory's volume, on the way from one frame to the next.
std::vector<double> sought(const LayeredPart& from, const LayeredPart& to, double share)
{
    std::vector<double> result;
    for (std::size_t s = 0; s < to.body->layer.skeletons.size(); ++s) {
        result.push_back(from.sought(s) + (to.sought(s) - from.sought(s)) * share);
    }
    return result;
}

// Moves the contributions as the controllers of `control` do in dt seconds, in which the inflation
// sought goes from state.inflation to `after`.
void keep_volume(const LayeredBody& body, const VolumeControl& control, const SeedWalk& walk,
                 const std::vector<double>& after, double dt, LayeredState& state)
{
    if (!(control.proportional > 0)) return;
    std::vector<double> target, target_after, thickness;
    for (std::size_t s = 0; s < state.volume.size(); ++s) {
        target.push_back(state.inflation[s] * body.volume[s]);
        target_after.push_back(after[s] * body.volume[s]);
        thickness.push_back(body.layer.contributions[s].thickness);
    }
    control_volume(control,
                   {state.volume, target, target_after, walk.volume_slope, state.part, thickness},
                   dt, state.translation, state.expected_error);
}

double volume_error(const LayeredBody& body, const LayeredState& state)
{
    if (!(body.control.proportional > 0) || state.volume.empty()) return 0;
    const double target =
        std::inner_product(body.volume.begin(), body.volume.end(), state.inflation.begin(), 0.0);
    const double now = std::accumulate(state.volume.begin(), state.volume.end(), 0.0);
    return std::abs(now / target - 1);
}

// The last step's motion has changed volumes since the controllers saw them. Mends that before
// anybody looks, by Newton steps in which nothing moves; leaves what the last walk saw.
void settle_volumes(LayeredScene& now, double mesh_seconds)
{
    constexpr int most_rounds = 3;
    constexpr double enough = 1e-3;
    if (std::none_of(now.parts.begin(), now.parts.end(),
                     [](const LayeredPart& part) { return part.body->control.proportional > 0; })) {
        return;
    }
    for (int round = 0;; ++round) {
        const LayeredMoment moment(now, mesh_seconds);
        double worst = 0;
        for (std::uint32_t b = 0; b < now.parts.size(); ++b) {
            keep_seen(moment, b, now.states[b]);
            now.states[b].inflation = sought(now.parts[b], now.parts[b], 1);
            worst = std::max(worst, volume_error(*now.parts[b].body, now.states[b]));
        }
        if (!(worst > enough) || round == most_rounds) return;
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            if (!(volume_error(*now.parts[b].body, now.states[b]) > enough)) continue;
            constexpr double at_once = std::numeric_limits<double>::infinity();
            keep_volume(*now.parts[b].body, {at_once, 0}, moment.walks[b], now.states[b].inflation,
                        1, now.states[b]);
        }
    }
}

// Parts of a soft substance. A part falls into what chains of overlapping spheres of influence hold
// together; what once came apart comes together by fusion only. Where two parts press harder than
// the threshold, the pair of skeletons there starts to blend, over `fusion_time`; from the first
// pair that blends fully the others in reach follow; parts of which all pairs in reach blend fully
// become one, which changes nothing in the field.
void update_parts(const LayeredBody& body, std::uint32_t number, const LayeredMoment& moment,
                  double dt, LayeredState& state)
{
    const Field& field = moment.fields[number];
    const Substance& substance = body.base.substance;
    const auto n = static_cast<std::uint32_t>(field.count());
    const auto centre = [&](std::uint32_t i) { return field.points[field.first[i]]; };
    const auto in_reach = [&](std::uint32_t i, std::uint32_t j) {
        return (centre(i) - centre(j)).norm() < field.profile[i].R + field.profile[j].R;
    };

    // Separation.
    geometry::Sets sets = chains(n, [&](std::uint32_t i, std::uint32_t j) {
        return state.part[i] == state.part[j] && in_reach(i, j);
    });

    // Fusion: links that still matter, grown; new ones where it presses hard enough.
    std::vector<BlendLink> links;
    for (BlendLink link : state.links) {
        if (!in_reach(link.a, link.b)) continue;
        link.weight =
            substance.fusion_time > 0 ? std::min(1.0, link.weight + dt / substance.fusion_time) : 1;
        links.push_back(link);
    }
    const auto add_link = [&](std::uint32_t i, std::uint32_t j) {
        if (i > j) std::swap(i, j);
        if (sets.root(i) == sets.root(j)) return;
        for (const BlendLink& link : links) {
            if (link.a == i && link.b == j) return;
        }
        links.push_back({i, j, substance.fusion_time > 0 ? 1e-3 : 1});
    };
    for (const LayerContact& contact : moment.contacts.contacts) {
        if (contact.body == number && contact.other == number &&
            body.matter.stiffness * contact.compression > substance.fusion_threshold) {
            add_link(contact.skeleton, contact.other_skeleton);
        }
    }
    const std::vector<BlendLink> begun = links;
    for (const BlendLink& full : begun) {
        if (full.weight < 1) continue;
        bool whole = true;
        const std::uint32_t A = sets.root(full.a), B = sets.root(full.b);
        if (A == B) continue;
        for (std::uint32_t i = 0; i < n; ++i) {
            if (sets.root(i) != A) continue;
            for (std::uint32_t j = 0; j < n; ++j) {
                if (sets.root(j) != B || !in_reach(i, j)) continue;
                add_link(i, j);
                const auto linked =
                    std::find_if(links.begin(), links.end(), [&](const BlendLink& l) {
                        return l.a == std::min(i, j) && l.b == std::max(i, j);
                    });
                whole &= linked != links.end() && linked->weight >= 1;
            }
        }
        if (whole) sets.join(A, B);
    }
    for (std::uint32_t i = 0; i < n; ++i) state.part[i] = sets.root(i);
    std::erase_if(links, [&](const BlendLink& l) { return state.part[l.a] == state.part[l.b]; });
    state.links = std::move(links);
}

// Puts meshes that change their shape to where they are after so many of the frame's steps, with
// where they were, or would have been, a step before. `told` has them at its end, `last` as the
// frame began.
void move_meshes(LayeredScene& now, const LayeredScene& last, const std::vector<LayeredPart>& told,
                 float step, int steps)
{
    for (std::size_t b = 0; b < told.size(); ++b) {
        if (!told[b].mesh_before) continue;
        geometry::TriMesh mesh = told[b].body->layer.skeletons[0].mesh->mesh;
        geometry::TriMesh earlier = mesh;
        const float each = 1 / static_cast<float>(steps), done = each * step;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const geometry::Vec3f& from = told[b].mesh_before->positions[v];
            const geometry::Vec3f way = mesh.positions[v] - from;
            mesh.positions[v] = from + done * way;
            earlier.positions[v] = mesh.positions[v] - each * way;
        }
        const std::vector<Skeleton>& before = last.parts[b].body->layer.skeletons;
        const bool ready = !before.empty() && before[0].mesh &&
                           before[0].mesh->mesh.positions == mesh.positions &&
                           before[0].mesh->mesh.topology == mesh.topology;
        LayeredBody body = *told[b].body;
        body.layer.skeletons[0].mesh =
            ready ? before[0].mesh
                  : std::make_shared<const geometry::SkeletonMesh>(std::move(mesh));
        now.parts[b].body = std::make_shared<const LayeredBody>(std::move(body));
        now.parts[b].mesh_before = std::make_shared<const geometry::TriMesh>(std::move(earlier));
    }
}

// A frame of the film, that starts as `scene` is and ends as `told`.
struct Span {
    const LayeredScene& scene;
    const std::vector<LayeredPart>& told;
    const LayeredWorld& world;
    double dt;

    LayeredScene begin() const
    {
        LayeredScene now{told, scene.states};
        for (LayeredState& state : now.states) {
            state.report = {};
            state.penetration = 0;
        }
        return now;
    }
};

// Gives what is told where to be the velocity that it takes, `left` seconds before the frame's end.
void drive_all(double left, LayeredScene& now)
{
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        drive_pins(now.parts[b], left, now.states[b]);
        if (!is_told(now.parts[b].body->base.kind)) continue;
        drive(told_frames(now.parts[b]), left, now.states[b]);
    }
}

// What is seen of all bodies in step number `step` of so many, and what their controllers do in it.
void watch(const Span& frame, const LayeredMoment& moment, int step, int steps, LayeredScene& now)
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

void step_implicitly(const Span& frame, int steps, LayeredScene& now)
{
    const double h = frame.dt / steps;
    for (int step = 0; step < steps; ++step) {
        drive_all(frame.dt - h * step, now);
        move_meshes(now, frame.scene, frame.told, static_cast<float>(step), steps);
        const LayeredMoment moment(now, h);
        LayeredSystem system(now, moment, h);
        add_forces(now, moment, frame.world, system);
        Report report;
        const std::vector<Vec6> dv = system.solve(report);
        watch(frame, moment, step, steps, now);
        for (std::size_t b = 0; b < now.parts.size(); ++b) {
            const LayeredBody& body = *now.parts[b].body;
            LayeredState& state = now.states[b];
            if (body.base.cubes) {
                state.cubes.rotation = system.rotations(b);
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
int step_with_bullet(const Span& frame, int steps, int most, LayeredScene& now)
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
    const auto begin_again = [&](const ExplicitPace& pace) {
        // One step too long has gone too deep and sees too much: by threes at most.
        const double enough = std::min({1.1 * pace.steps, 3.0 * steps, double(most)});
        return std::max(steps + 1, static_cast<int>(enough));
    };
    ExplicitPace hardest;
    for (int step = 0; step <= steps; ++step) {
        const bool end = step == steps;  // what the last half step came into, or is to come out of
        if (!end) {
            drive_all(frame.dt - h * step, now);
            drift();
        }
        const float at = static_cast<float>(step) + (end ? 0 : 0.5f);
        move_meshes(now, frame.scene, frame.told, at, steps);
        const LayeredMoment moment(now, h);
        LayeredSystem system(now, moment, h, RigidBodies::bullet);
        add_forces(now, moment, frame.world, system);
        const ExplicitPace pace = explicit_pace(now, system, frame.dt);
        if (pace.steps > steps && steps < most) return begin_again(pace);
        for (LayeredState& state : now.states) state.pace = 0;
        now.states[pace.part].pace = pace.steps / frame.dt;
        if (end) break;
        if (pace.steps > hardest.steps) hardest = pace;
        const double share = std::min(1.0, steps / pace.steps);
        bodies.push(now, moment, system, share * share, h);
        watch(frame, moment, step, steps, now);
        drift();
    }
    if (hardest.steps > steps) {
        Report& report = now.states[hardest.part].report;
        report.converged = false;
        report.warnings.push_back(fmt::format(
            "body {} is pushed so stiffly that Bullet needs {:.0f} steps a frame to stay stable, "
            "and gets {}: what pushes it was weakened; set rigid_bodies to implicit, raise "
            "substeps or make the layers softer",
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
               (scene.states[b].distance.empty() ||
                scene.states[b].distance.size() == parts[b].body->seeds.count());
    }
    if (!same) {
        throw std::invalid_argument(
            fmt::format("layered bodies changed while they moved: a scene of {} goes on with the "
                        "same bodies, frames and skeletons, got {}",
                        scene.states.size(), parts.size()));
    }
    check_rigid_bodies(parts, world.rigid_bodies);
    const Span frame{scene, parts, world, dt};
    LayeredScene now = frame.begin();
    if (!(dt > 0) || now.states.empty()) return now;
    int steps = choose_steps(now, world.gravity, dt, std::max(1, substeps));
    if (world.rigid_bodies == RigidBodies::implicit) {
        step_implicitly(frame, steps, now);
    } else {
        const int most = std::max(steps, most_steps(std::max(1, substeps)));
        for (const LayeredState& state : now.states) {
            const double enough = std::min<double>(most, std::ceil(1.1 * dt * state.pace));
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
        const std::vector<Transform> at = told_frames(now.parts[b]);
        for (std::size_t f = 0; f < at.size(); ++f) {
            now.states[b].position[f] = at[f].translation();
            now.states[b].rotation[f] = Eigen::Quaterniond(at[f].linear()).normalized().coeffs();
        }
    }
    settle_volumes(now, dt);
    return now;
}

double volume_error(const LayeredScene& scene)
{
    double worst = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        worst = std::max(worst, volume_error(*scene.parts[b].body, scene.states[b]));
    }
    return worst;
}

}  // namespace physics
