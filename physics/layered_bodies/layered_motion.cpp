#include "physics/layered_bodies/layered_motion.hpp"

#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/same_triangles.hpp"
#include "physics/layered_bodies/net_base.hpp"

#include <algorithm>
#include <numbers>

namespace physics {

using geometry::Skeleton;

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
            "Cubes under a layer move more than their own size per step; raise substeps.");
    }
    follow_cubes(body, state);
}

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

namespace {

// Sends a frame straight, at constant spin, to where it is to be in `left` seconds.
void drive_frame(const Transform& to, double left, std::size_t f, LayeredState& state)
{
    state.velocity[f] = (to.translation() - state.position[f]) / left;
    const Eigen::Quaterniond now(state.rotation[f]);
    const Eigen::AngleAxisd turn(Eigen::Quaterniond(to.linear()) * now.conjugate());
    const double angle =
        turn.angle() > std::numbers::pi ? turn.angle() - 2 * std::numbers::pi : turn.angle();
    state.spin[f] = angle / left * turn.axis();
}

void drive(const std::vector<Transform>& motion, double left, LayeredState& state)
{
    for (std::size_t f = 0; f < state.position.size(); ++f) drive_frame(motion[f], left, f, state);
}

void drive_held(const LayeredPart& part, double left, LayeredState& state)
{
    if (part.held.empty()) return;
    const std::vector<Transform> told = told_frames(part);
    for (const HeldFrame& held : part.held) {
        Transform to = told[held.frame];
        to.pretranslate(held.way);
        drive_frame(to, left, held.frame, state);
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

}  // namespace

void keep_first_poses(const LayeredScene& scene, std::vector<LayeredPart>& told)
{
    for (std::size_t b = 0; b < told.size(); ++b) {
        if (told[b].body->base.kind != BaseKind::rigid) continue;
        if (!told[b].held.empty()) told[b].frames = told_frames(told[b]);
        told[b].pose = scene.parts[b].pose;
    }
}

void drive_all(double left, LayeredScene& now)
{
    for (std::size_t b = 0; b < now.parts.size(); ++b) {
        drive_pins(now.parts[b], left, now.states[b]);
        drive_held(now.parts[b], left, now.states[b]);
        follow_masses(*now.parts[b].body, now.states[b]);
        if (!is_told(now.parts[b].body->base.kind)) continue;
        drive(told_frames(now.parts[b]), left, now.states[b]);
    }
}

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
                           geometry::same_triangles(before[0].mesh->mesh, mesh) &&
                           before[0].mesh->mesh.positions == mesh.positions;
        LayeredBody body = *told[b].body;
        body.layer.skeletons[0].mesh =
            ready ? before[0].mesh
                  : std::make_shared<const geometry::SkeletonMesh>(std::move(mesh));
        now.parts[b].body = std::make_shared<const LayeredBody>(std::move(body));
        now.parts[b].mesh_before = std::make_shared<const geometry::TriMesh>(std::move(earlier));
    }
}

}  // namespace physics
