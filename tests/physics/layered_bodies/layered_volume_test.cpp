#include "layered_fixtures.hpp"

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered_mesh.hpp"

#include <gtest/gtest.h>

namespace physics {

using namespace layered_fixtures;

namespace {

// Of the surface that is drawn of body 0, m^3.
double drawn(const LayeredScene& scene)
{
    return geometry::enclosed_volume(layered_mesh(scene, {.cell = 0.006, .body = 0}));
}

// A plate with its lower side at y, that comes down.
LayeredBody ceiling_at(double y)
{
    Skeleton plate{.kind = SkeletonKind::box, .points = {}, .half_size = {0.5, 0.05, 0.5}};
    plate.place.translate(Vec3(0, y + 0.05 + soft.thickness, 0));
    LayeredBody body = make_layered_body(soft_layer({plate}), BaseKind::still, 1, 0.1);
    body.matter.rigid = true;
    return body;
}

// Presses body 0 of a scene under a ceiling, body 1, that comes down by 7 mm in each of six frames.
// What is drawn of it must stay at `volume` within half a percent.
void press(LayeredScene scene, double volume)
{
    EXPECT_NEAR(drawn(scene) / volume, 1, 0.005);
    std::vector<LayeredPart> parts = scene.parts;
    for (int frame = 0; frame < 6; ++frame) {
        parts[1].pose.translate(Vec3(0, -0.007, 0));
        scene = advance(scene, parts, {}, 1.0 / 24, 2);
        EXPECT_NEAR(drawn(scene) / volume, 1, 0.005) << frame;
        EXPECT_TRUE(scene.states[0].report.warnings.empty());
    }
}

}  // namespace

// With the bulge that matter has by default: 0.1 m wide, half as high as the compression.
TEST(LayeredVolume, ABallInAViseKeepsTheVolumeThatIsDrawn)
{
    LayeredBody pressed = ball({0, 0.1, 0}, 2e4, 0.012);
    pressed.control.proportional = 10;
    const double r = 0.1;
    press(scene_of({pressed, ceiling_at(0.2), floor_at(0)}),
          4.0 / 3 * std::numbers::pi * r * r * r);
}

// Three balls of one body that overlap from the start by 1 mm and do not blend: where they are
// apart each has its volume, less the three lenses, and the surface bulges where they touch.
TEST(LayeredVolume, PartsThatPressEachOtherKeepTheVolumeThatIsDrawn)
{
    ImplicitLayer layer =
        soft_layer({point({-0.0995, 0.1, 0}), point({0.0995, 0.1, 0}), point({0, 0.272, 0})}, true);
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    LayeredBody heap = make_layered_body(layer, BaseKind::rigid, 1000, 0.012);
    heap.matter.stiffness = 2e4;
    heap.matter.self_contact = true;
    heap.control.proportional = 10;
    const auto lens = [](double d) {
        const double depth = 0.1 - d / 2;
        return 2 * std::numbers::pi * depth * depth * (0.3 - depth) / 3;
    };
    const double balls = 3 * 4.0 / 3 * std::numbers::pi * 1e-3;
    press(scene_of({heap, ceiling_at(0.372), floor_at(0)}),
          balls - lens(0.199) - 2 * lens(std::hypot(0.0995, 0.172)));
}

// A part of a figure that lies across another one that it is not linked to: both blend with a
// third. At rest what is sought is what is drawn.
TEST(LayeredVolume, TheVolumeAtRestIsThatOfTheUnionOfParts)
{
    ImplicitLayer layer =
        soft_layer({point({0, 0, 0}), point({0.12, 0.05, 0}), point({0.12, -0.05, 0})}, true);
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    layer.blend.links = {{0, 1, 1}, {0, 2, 1}};
    const LayeredBody body = make_layered_body(layer, BaseKind::rigid, 1000, 0.01);
    const double sum = body.volume[0] + body.volume[1] + body.volume[2];
    EXPECT_NEAR(drawn(scene_of({body})) / sum, 1, 0.005);
}

// The surface moves by half the thickness at most: a ball of 0.1 m has (1.5)^3 times its volume
// then.
TEST(LayeredVolume, AVolumeThatIsNotReachedIsTold)
{
    LayeredBody body = ball({0, 0, 0});
    body.control.proportional = 10;
    LayeredScene scene = scene_of({body});
    EXPECT_TRUE(scene.states[0].report.warnings.empty());
    std::vector<LayeredPart> parts = scene.parts;
    parts[0].inflation = 4;
    scene = advance(scene, parts, weightless, 1.0 / 24, 2);
    ASSERT_EQ(scene.states[0].report.warnings.size(), 1u);
    EXPECT_NE(scene.states[0].report.warnings[0].find("3.3"), std::string::npos);
    EXPECT_NE(scene.states[0].report.warnings[0].find("instead of 4"), std::string::npos);
    parts[0].inflation = 3;
    scene = advance(scene, parts, weightless, 1.0 / 24, 2);
    EXPECT_TRUE(scene.states[0].report.warnings.empty());
}

}  // namespace physics
