#pragma once

// Bodies coated by layers, for tests.

#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/layered_step.hpp"
#include "tests/physics/layers/layer_fixtures.hpp"

#include <numbers>

namespace physics::layered_fixtures {

using geometry::Contribution;
using geometry::Skeleton;
using geometry::SkeletonKind;
using layer_fixtures::point;

inline const Contribution soft{.thickness = 0.1, .stiffness = 10, .radius = 0.22};

inline ImplicitLayer soft_layer(std::vector<Skeleton> skeletons, bool own_frames = false)
{
    ImplicitLayer layer;
    layer.skeletons = std::move(skeletons);
    layer.contributions.assign(layer.skeletons.size(), soft);
    for (std::uint32_t i = 0; i < layer.skeletons.size(); ++i) {
        layer.frame.push_back(own_frames ? i : 0);
    }
    return layer;
}

inline LayeredBody ball(const Vec3& at, double stiffness = 2e4, double spacing = 0.03)
{
    LayeredBody body = make_layered_body(soft_layer({point(at)}), BaseKind::rigid, 1000, spacing);
    body.matter.stiffness = stiffness;
    body.matter.friction = 0;
    return body;
}

inline LayeredBody floor_at(double y)
{
    Skeleton plane{.kind = SkeletonKind::plane, .points = {}};
    plane.place.translate(Vec3(0, y - soft.thickness, 0));
    LayeredBody body = make_layered_body(soft_layer({plane}), BaseKind::still, 1, 0.1);
    body.matter.rigid = true;
    return body;
}

inline LayeredScene scene_of(std::vector<LayeredBody> bodies)
{
    std::vector<LayeredPart> parts(bodies.size());
    for (std::size_t b = 0; b < parts.size(); ++b) {
        parts[b].body = std::make_shared<const LayeredBody>(std::move(bodies[b]));
    }
    return start(std::move(parts));
}

inline Vec3 momentum(const LayeredScene& scene)
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (scene.parts[b].body->base.kind == BaseKind::still) continue;
        for (std::size_t f = 0; f < scene.states[b].velocity.size(); ++f) {
            sum += scene.parts[b].body->base.mass[f] * scene.states[b].velocity[f];
        }
    }
    return sum;
}

inline Vec3 angular_momentum(const LayeredScene& scene)
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const Base& base = scene.parts[b].body->base;
        const LayeredState& state = scene.states[b];
        for (std::size_t f = 0; f < state.velocity.size(); ++f) {
            const geometry::Mat3 R = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
            sum += base.mass[f] * state.position[f].cross(state.velocity[f]);
            if (base.kind == BaseKind::rigid) {
                sum += R * base.inertia[f] * R.transpose() * state.spin[f];
            }
        }
    }
    return sum;
}

inline const LayeredWorld weightless{.gravity = Vec3::Zero()};

// Where ball() comes to rest over a floor at 0, m: the floor carries the weight. With
// compression d at the middle the flat cut has radius a^2 = r0^2 - h^2, and the force
// K k 2 pi (r0 a^2/2 - (r0^3 - h^3)/3) = m g gives h.
inline double resting_height(const LayeredBody& ball)
{
    const double weight = ball.base.mass[0] * 9.81;
    double low = 0.05, high = 0.1;
    for (int i = 0; i < 60; ++i) {
        const double h = 0.5 * (low + high);
        const double force = ball.matter.stiffness * 10 * 2 * std::numbers::pi *
                             (0.1 * (0.01 - h * h) / 2 - (1e-3 - h * h * h) / 3);
        (force > weight ? low : high) = h;
    }
    return low;
}

// Two limbs along x on a hinge between them, about z.
inline LayeredBody two_limbs(double lowest, double highest)
{
    Skeleton upper{.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {0.4, 0, 0}}};
    Skeleton lower{.kind = SkeletonKind::segment, .points = {{0.5, 0, 0}, {0.9, 0, 0}}};
    ImplicitLayer layer = soft_layer({upper, lower}, true);
    layer.blend.rule = geometry::BlendRule::largest_group;
    layer.blend.links = {{0, 1, 1}};
    LayeredBody body = make_layered_body(layer, BaseKind::rigid, 1000, 0.06);
    Hinge& hinge = add_hinge(body.base, 0, 1, {0.45, 0, 0}, {0, 0, 1});
    hinge.lowest = lowest;
    hinge.highest = highest;
    return body;
}

// How far the two points of the only hinge of body 0 are apart, m, and its angle, rad.
struct HingeState {
    double gap = 0, angle = 0;
};
inline HingeState hinge_state(const LayeredScene& scene)
{
    const Hinge& hinge = scene.parts[0].body->base.hinges[0];
    const LayeredMoment moment(scene);
    const Transform &a = moment.frames[0][hinge.a], &b = moment.frames[0][hinge.b];
    return {(a * hinge.point_a - b * hinge.point_b).norm(), hinge_angle(hinge, a, b)};
}

}  // namespace physics::layered_fixtures
