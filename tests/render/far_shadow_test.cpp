// Shadows of and on what lies farther from the stage than the near shadow map reaches.

#include "pictures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace tests;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;
using render::Camera;
using render::Image;
using render::Look;
using render::Scene;

Look look_of(bool soft, int size = 200)
{
    Look look = plain_look(size);
    look.style = soft ? render::Style::studio : render::Style::plain;
    look.soft = soft;
    look.occlusion = 0;
    look.shadow = render::ShadowQuality::medium;
    look.light_elevation = std::numbers::pi / 2;
    look.light = Vec3f::Constant(0.8f);
    look.floor = Vec3f::Constant(0.5f);
    return look;
}

// Of a place in a square picture.
double brightness_at(const Image& image, const Camera& camera, const Vec3& place)
{
    const geometry::Mat3 axes = render::camera_axes(camera);
    const Vec3 q = axes * (place - camera.eye);
    const double half = image.height / 2.0, tan_y = std::tan(camera.field_of_view / 2);
    const int x = int(half + half * q[0] / (q[2] * tan_y));
    const int y = int(half - half * q[1] / (q[2] * tan_y));
    return render::linear_from_srgb(float(pixel(image, x, y)[1]) / 255);
}

render::Surface at(TriMesh mesh, const Vec3f& place)
{
    for (Vec3f& p : mesh.positions) p += place;
    return surface(std::move(mesh));
}

// The stage is 1 stage unit from its centre to a corner.
geometry::Box small_stage()
{
    return box_about_origin(1 / std::sqrt(3.0));
}

// A card of 1 x 1 held 0.6 over the floor, four stage units beside the stage, where nothing else
// is. The light comes from straight above.
TEST(FarShadow, AThingFarFromTheStageCastsAShadowAsLargeAsItself)
{
    for (const bool soft : {false, true}) {
        Scene scene;
        scene.stage = small_stage();
        scene.ground = 0;
        scene.surfaces = {at(geometry::grid(1, 1, 4, 4), {4, 0.6f, 0})};
        const Camera camera{{4, 2, 6}, {4, 0, 0}, {0, 1, 0}, 2 * std::atan(0.3)};
        Look look = look_of(soft);
        const Image image = render::draw(scene, camera, look);
        look.shadow = render::ShadowQuality::off;
        const Image without = render::draw(scene, camera, look);
        // The floor fades away with the distance, so what is told is the share of its own light.
        const auto share = [&](double x) {
            return brightness_at(image, camera, {x, 0, 0.1}) /
                   brightness_at(without, camera, {x, 0, 0.1});
        };
        EXPECT_LT(share(4), 0.6) << soft;
        // A texel of a map of 9 stage units is 0.009, a pixel 0.02; the filter reaches 3 texels.
        for (const double side : {-1.0, 1.0}) {
            EXPECT_NEAR(share(4 + 0.44 * side), share(4), 0.05) << soft;
            EXPECT_NEAR(share(4 + 0.56 * side), 1, 0.02) << soft;
        }
    }
}

// Balls are casters of another kind.
TEST(FarShadow, BallsFarFromTheStageCastShadowsOnThingsThere)
{
    Scene scene;
    scene.stage = small_stage();
    render::Balls balls;
    balls.centres = {{6, 0.5f, 0}};
    balls.radius = 0.2f;
    balls.colours = {Vec3f(0.5f, 0.5f, 0.5f)};
    scene.balls = {balls};
    scene.surfaces = {at(geometry::grid(2, 2, 4, 4), {6, 0, 0})};
    const Camera camera{{6, 2, 6}, {6, 0, 0}, {0, 1, 0}, 2 * std::atan(0.3)};
    const Image image = render::draw(scene, camera, look_of(false));
    EXPECT_LT(brightness_at(image, camera, {6, 0, 0.05}),
              0.8 * brightness_at(image, camera, {6.5, 0, 0.05}));
}

// A roof over a table, both 16 stage units wide: they cross the near map's edge on all sides. All
// of the table lies in the roof's shadow, and none of it does without the roof.
TEST(FarShadow, TheMapsMeetWithoutASeam)
{
    for (const bool soft : {false, true}) {
        Scene scene;
        scene.stage = small_stage();
        scene.surfaces = {at(geometry::grid(16, 16, 32, 32), {0, -0.5f, 0})};
        const Camera camera{{0, 0.9, 9}, {0, -0.5, 0}, {0, 1, 0}, 2 * std::atan(0.5)};
        double mean[2] = {};
        for (const bool roofed : {false, true}) {
            if (roofed) scene.surfaces.push_back(at(geometry::grid(16, 16, 32, 32), {0, 2, 0}));
            Look look = look_of(soft);
            look.light_azimuth = 0.4;
            look.light_elevation = 1.2;
            const Image image = render::draw(scene, camera, look);
            double low = 1, high = 0;
            for (double x = -3.3; x < 3.4; x += 0.1) {
                for (double z = -4; z < 3; z += 0.1) {
                    const double here = brightness_at(image, camera, {x, -0.5, z});
                    low = std::min(low, here), high = std::max(high, here);
                }
            }
            // Highlights change over the table as the eye's angle does.
            EXPECT_LT(high - low, 0.12 * high) << soft << roofed;
            mean[roofed] = 0.5 * (low + high);
        }
        EXPECT_LT(mean[1], 0.8 * mean[0]);
    }
}

// What is far away, out of sight, changes nothing of the shadows near the stage, nor how sharp they
// are.
TEST(FarShadow, ShadowsNearTheStageKeepTheirPixels)
{
    for (const bool soft : {false, true}) {
        for (const auto antialias : {render::Antialias::none, render::Antialias::samples4}) {
            Scene scene;
            scene.stage = small_stage();
            scene.ground = -0.5;
            scene.surfaces = {at(geometry::grid(0.6, 0.6, 4, 4), {0, 0.2f, 0})};
            const Camera camera{{0, 2, 3}, {0, -0.4, 0}, {0, 1, 0}, 2 * std::atan(0.25)};
            Look look = look_of(soft);
            look.antialias = antialias;
            look.light_elevation = 1.1;
            const Image alone = render::draw(scene, camera, look);
            scene.surfaces.push_back(at(geometry::grid(0.6, 0.6, 4, 4), {7, 0.2f, 0}));
            EXPECT_TRUE(alone.rgba == render::draw(scene, camera, look).rgba) << soft;
        }
    }
}

}  // namespace
