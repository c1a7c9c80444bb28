#include "physics/layered_bodies/layered_fields.hpp"

#include "physics/layered_bodies/layered_step.hpp"
#include "tests/geometry/fields/ray_march.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics {

using namespace layered_fixtures;

// Two balls that press each other and the floor, with bulges: each body's surface is met where
// brute force meets it.
TEST(LayeredFields, PressedBodiesAreMetWhereBruteForceMeetsThem)
{
    std::vector<LayeredBody> bodies;
    for (const double x : {-0.085, 0.085}) {
        bodies.push_back(ball({x, 0.09, 0}));
        bodies.back().matter.bulge_width = 0.04;
        bodies.back().matter.bulge_height = 0.4;
    }
    bodies.push_back(floor_at(0));
    const LayeredScene scene = scene_of(std::move(bodies));
    const std::vector<LayeredField> layers = layered_fields(scene);
    ASSERT_EQ(layers.size(), 2u) << "the floor draws itself";
    EXPECT_EQ(layers[1].name, "body 1");
    for (const LayeredField& layer : layers) {
        geometry::Box around;
        around.add(Vec3(-0.2, -0.02, -0.12));
        around.add(Vec3(0.2, 0.2, 0.12));
        const auto rays = geometry::ray_march::rays_at(around, 400, 21);
        EXPECT_GT(geometry::ray_march::expect_as_brute_force(layer.field, rays, 4000, 1e-9), 80);
    }
}

// A thin limb across a thick one of the same body: they do not blend, press each other and bulge.
TEST(LayeredFields, PartsOfOneBodyThatPressEachOtherAreMetWhereBruteForceMeetsThem)
{
    Skeleton thick{.kind = SkeletonKind::segment, .points = {{-0.2, 0, 0}, {0.2, 0, 0}}};
    Skeleton thin{.kind = SkeletonKind::segment, .points = {{0, 0.14, -0.2}, {0.05, 0.16, 0.2}}};
    ImplicitLayer layer = soft_layer({thick, thin}, true);
    layer.contributions[1] = {.thickness = 0.06, .stiffness = 14, .radius = 0.16};
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    LayeredBody body = make_layered_body(layer, BaseKind::still, 1000, 0.02);
    body.matter.self_contact = true;
    body.matter.bulge_width = 0.03;
    body.matter.bulge_height = 0.3;
    const LayeredScene scene = scene_of({body});
    const LayeredField limbs = layered_fields(scene)[0];
    geometry::Box around;
    around.add(Vec3(-0.1, 0.0, -0.15));
    around.add(Vec3(0.15, 0.25, 0.15));
    const auto rays = geometry::ray_march::rays_at(around, 500, 33);
    EXPECT_GT(geometry::ray_march::expect_as_brute_force(limbs.field, rays, 4000, 1e-9), 150);
}

// Between two equal balls pressed together lies a plane, which both surfaces share: rays that come
// from either side to the other's surface end there, at the same depth.
TEST(LayeredFields, PressedBodiesEndAtOneCommonSurface)
{
    const LayeredScene scene = scene_of({ball({-0.08, 0, 0}), ball({0.08, 0, 0})});
    const std::vector<LayeredField> layers = layered_fields(scene);
    EXPECT_NEAR(layers[0].compression({0, 0, 0}), 0.2, 1e-12);  // k (e - 0.08)
    std::array<geometry::RayHit, 2> met;
    for (std::size_t b = 0; b < 2; ++b) {
        const geometry::Ray ray{{b == 0 ? 1.0 : -1.0, 0.01, 0.02}, {b == 0 ? -1.0 : 1.0, 0, 0}, 0};
        geometry::trace(layers[b].field, geometry::iso_cells(layers[b].field), std::span(&ray, 1),
                        1e-9, std::span(&met[b], 1));
        EXPECT_NEAR(met[b].t, 1, 1e-8);
    }
    EXPECT_LT((met[0].normal + met[1].normal).norm(), 1e-6);
}

}  // namespace physics
