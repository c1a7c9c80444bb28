#pragma once

// Layers in contact, for tests.

#include "physics/layers/layer_contact.hpp"

#include <list>

namespace physics::layer_fixtures {

using geometry::Contribution;
using geometry::Skeleton;
using geometry::SkeletonKind;

// Owns what ContactBody names. A list keeps the addresses.
struct Thing {
    ImplicitLayer layer;
    std::vector<Transform> frames;
    std::vector<Twist> twists;
    geometry::Field field;
    SurfaceSamples samples;
    SampleWalk walk;
    LayerMatter matter;

    Thing(ImplicitLayer l, double spacing, const LayerMatter& m = {},
          std::vector<Transform> at = {Transform::Identity()})
        : layer(std::move(l)), frames(std::move(at)), twists(frames.size()),
          field(geometry::make_field(layer, frames)), samples(make_surface_samples(layer, spacing)),
          walk(physics::walk(field, samples, frames)), matter(m)
    {}
    ContactBody body() const
    {
        return {&field, &samples, &walk, frames, twists, layer.frame, matter};
    }
};

inline std::vector<ContactBody> bodies(const std::list<Thing>& things)
{
    std::vector<ContactBody> result;
    for (const Thing& thing : things) result.push_back(thing.body());
    return result;
}

inline ImplicitLayer layer_of(std::vector<Skeleton> skeletons, const Contribution& contribution)
{
    ImplicitLayer layer;
    layer.skeletons = std::move(skeletons);
    layer.contributions.assign(layer.skeletons.size(), contribution);
    layer.frame.assign(layer.skeletons.size(), 0);
    return layer;
}

inline Skeleton point(const Vec3& p)
{
    return {.kind = SkeletonKind::point, .points = {p}};
}

// The accuracy page's contact: two equal points, linear, k = 1, r0 = 1, half distance 0.9.
inline const Contribution unit{.thickness = 1, .stiffness = 1, .radius = 2, .stiffening = 0};
inline constexpr double h = 0.9;

inline std::list<Thing> two_balls(double spacing)
{
    LayerMatter matter{.stiffness = 1, .friction = 0, .bulge_width = 0.3, .bulge_height = 0.5};
    std::list<Thing> things;
    // Turned a little, so that no row of samples lies in the border by symmetry.
    Transform turn = Transform::Identity();
    turn.translate(Vec3(-h, 0, 0)).rotate(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()));
    things.emplace_back(layer_of({point({0, 0, 0})}, unit), spacing, matter, std::vector{turn});
    turn.setIdentity();
    turn.translate(Vec3(h, 0, 0)).rotate(Eigen::AngleAxisd(0.7, Vec3(-1, 2, 1).normalized()));
    things.emplace_back(layer_of({point({0, 0, 0})}, unit), spacing, matter, std::vector{turn});
    return things;
}

}  // namespace physics::layer_fixtures
