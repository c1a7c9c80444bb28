#include "physics/lattice/step_motion.hpp"

#include "physics/body/collider_contact.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/lattice/lattice_pull.hpp"

#include <Eigen/Geometry>

#include <cmath>

namespace physics {

namespace {

constexpr int contact_rounds = 8;

// Measures from the middle of the particles after `visit` has been at the pieces begin .. end
// of them, which may move them and returns the sum of their places.
template <class Visit> void take_origin(FrameState& step, const Visit& visit)
{
    const Vec3 sum = geometry::ordered_sum<Vec3>(step.n, particles_a_task, Vec3::Zero(), visit);
    step.origin = sum / double(step.n);
}
// The same particle by particle.
template <class Visit> void take_origin_after(FrameState& step, const Visit& visit)
{
    take_origin(step, [&](std::size_t begin, std::size_t end) {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = begin; i < end; ++i) {
            visit(i);
            sum += step.state.x[i];
        }
        return sum;
    });
}

struct Wind {
    Aligned<double> force, drag;  // numbers, N and N s/m
};

void find_wind(const FrameState& step, Wind& wind)
{
    wind.force.assign(step.body.base.numbers, 0);
    wind.drag = wind.force;
    Aligned<double> x(step.body.base.numbers, 0), v(step.body.base.numbers, 0);
    for (std::size_t i = 0; i < step.n; ++i) {
        for (std::size_t d = 0; d < 3; ++d) {
            x[4 * i + d] = step.state.x[i][Eigen::Index(d)];
            v[4 * i + d] = step.state.v[i][Eigen::Index(d)];
        }
    }
    add_wind(step.body.base, step.forces, x.data(), v.data(), wind.force, wind.drag);
    add_radial(step.body.base, step.forces, x.data(), wind.force);
}

}  // namespace

void find_origin(FrameState& step)
{
    take_origin_after(step, [](std::size_t) {});
}

void push_from_outside(FrameState& step)
{
    Wind wind;
    if (step.windy) find_wind(step, wind);
    const Vec3 fall = step.dt * step.gravity;
    const std::vector<std::uint32_t>& piece = step.pieces->of;
    if (step.pieces->count == 1 && !step.touches && !step.windy && !step.damped && !step.in_plane &&
        step.steady.empty()) {
        const RigidRest& rest = step.rest.front();
        const CommonPush common{fall - rest.drift, rest.spin, rest.pivot, step.dt};
        take_origin(step, [&](std::size_t begin, std::size_t end) {
            return push_together(common, end - begin, step.state.x[begin].data(),
                                 step.state.v[begin].data());
        });
        return;
    }
    const auto push = [&](std::size_t i) {
        const double m = step.body.base.mass[i];
        Vec3& v = step.state.v[i];
        const RigidRest& rest = step.rest[piece[i]];
        v += fall - rest.drift - rest.spin.cross(Vec3(step.state.x[i] - rest.pivot));
        if (!step.steady.empty())
            v += step.dt / m * Eigen::Map<const Vec3>(step.steady.data() + 4 * i);
        if (step.damped) v *= std::exp(-step.body.base.damping_of(i) / m * step.dt);
        if (step.windy) {
            // The drag is implicit, so that light bodies follow the wind and no more.
            v = (m * v + step.dt * Eigen::Map<const Vec3>(wind.force.data() + 4 * i)) /
                (m + step.dt * wind.drag[4 * i]);
        }
        if (step.in_plane) v[step.body.flat_axis] = 0;
    };
    if (step.touches) {
        geometry::parallel_for(step.n, particles_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) push(i);
        });
    } else {
        take_origin_after(step, [&](std::size_t i) {
            push(i);
            step.state.x[i] += step.dt * step.state.v[i];
        });
    }
}

void collide(FrameState& step, double share)
{
    if (!step.touches) {
        step.state.holds.clear();
        return;
    }
    const bool first = step.state.time == 0 && share < 1.5 / step.options.substeps;
    const bool pairs = step.body.options.contact.on;
    for (BallState& ball : step.state.balls) ball.v += step.dt * step.gravity;
    std::vector<PosedCollider> colliders;
    for (const Collider& c : step.loads.colliders) {
        colliders.push_back(pose_collider(c, share, step.frame, step.body.base.h, first,
                                          step.body.base.skin.thickest));
    }
    const ContactScene scene{step.body.base,    step.state,
                             step.inverse_mass, step.dt,
                             step.loads.balls,  step.torn_skin ? &*step.torn_skin : nullptr};
    step.pushes.skin = find_skin_pushes(scene, colliders);
    step.pushes.balls = find_ball_pushes(scene, colliders);
    if (pairs) {
        const BodyContactOptions& contact = step.options.contact;
        find_pair_pushes(scene, step.body.side, step.body.pieces.of,
                         contact.distance_in(step.body.base.h), contact.friction, step.pushes.pairs,
                         step.body.options.contact.self ? &step.body.along : nullptr);
    }
    solve_pushes(scene, step.pushes, contact_rounds, step.state.v, step.state.balls);
    step.state.holds = holds_of(step.pushes.skin, step.state.v, step.dt);
    if (!step.in_plane) return;
    for (Vec3& v : step.state.v) v[step.body.flat_axis] = 0;
}

void move(FrameState& step, double share)
{
    if (step.touches)
        take_origin_after(step,
                          [&](std::size_t i) { step.state.x[i] += step.dt * step.state.v[i]; });
    const auto& pins = step.loads.pins;
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const std::uint32_t k = pins.corner[p];
        step.state.x[k] = step.pin_paths.at(p, share);
        step.state.v[k] = step.pin_paths.velocity(p, share) / step.frame;
    }
    for (BallState& ball : step.state.balls) {
        ball.x += step.dt * ball.v;
        const double angle = step.dt * ball.spin.norm();
        if (!(angle > 0)) continue;
        const Eigen::Quaterniond turned =
            Eigen::Quaterniond(Eigen::AngleAxisd(angle, ball.spin.normalized())) *
            Eigen::Quaterniond(ball.turn[0], ball.turn[1], ball.turn[2], ball.turn[3]);
        ball.turn = Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z()).normalized();
    }
}

}  // namespace physics
