#include "render/draw.hpp"

#include "geometry/mesh/merge.hpp"
#include "pictures.hpp"
#include "tests/geometry/files.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <thread>

namespace {

using namespace tests;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;
using render::Camera;
using render::Image;
using render::Look;
using render::Scene;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Looks along -z from 10 m at the origin; the picture is 10 tan(fov / 2) = 2 m high at z = 0.
Camera camera_ahead()
{
    return {{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.2)};
}

// One flat square in the plane z, facing the camera, in one unlit colour.
render::Surface card(double z, double half, const Vec3f& colour)
{
    TriMesh mesh = geometry::grid(2 * half, 2 * half, 1, 1);
    for (Vec3f& p : mesh.positions) p = Vec3f(p.x(), -p.z(), float(z));
    for (Vec3f& n : mesh.normals) n = Vec3f::UnitZ();
    render::Surface out = surface(std::move(mesh));
    out.paint.by = render::Paint::By::constant;
    out.paint.colour = colour;
    out.receives = false;
    return out;
}

TEST(Draw, AnEmptySceneIsItsBackdrop)
{
    const Image image = render::draw({}, camera_ahead(), plain_look(32));
    ASSERT_EQ(image.rgba.size(), 32u * 32 * 4);
    EXPECT_EQ(covered_pixels(image), 0);
}

// A sphere of radius r at distance d spans the cone sin a = r / d: in the picture a disc of radius
// tan a / tan(fov / 2) half-heights. r = 1, d = 10: tan a = 1 / sqrt(99); a picture of 256 pixels
// gives a radius of 128 * 0.100504 / 0.2 = 64.32. The mesh's faces lie inside the sphere, by up
// to (edge / r)^2 / 8 = 0.02 % of it.
TEST(Draw, ASphereCoversTheDiscThatPerspectiveSays)
{
    Scene scene;
    scene.surfaces = {surface(geometry::icosphere(1, 5))};
    const Image image = render::draw(scene, camera_ahead(), plain_look(256));
    const double radius = 128 / std::sqrt(99.0) / 0.2;
    const double expected = std::numbers::pi * radius * radius;
    // Pixel centres in a disc: the count is off by about sqrt(radius) for a smooth outline.
    EXPECT_NEAR(covered_pixels(image), expected, 40);
    for (const int at : {127, 128}) {
        EXPECT_TRUE(covered(image, at, 128 - 63));
        EXPECT_FALSE(covered(image, at, 128 - 66));
        EXPECT_TRUE(covered(image, 128 + 62, at));
        EXPECT_FALSE(covered(image, 128 + 65, at));
    }
}

// A rough white ball lit from where the camera is, and by nothing else. At image radius s, in radii
// of the ball, the normal makes an angle with the light whose cosine is sqrt(1 - s^2). A dielectric
// keeps 4 % of the light from the diffuse part; as its roughness is 1, the highlight gives a
// quarter of that back. The tone map takes off 0.04.
TEST(Draw, ALitSphereFollowsLambert)
{
    Scene scene;
    TriMesh mesh = geometry::icosphere(1, 5);
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    topology->materials = {{"white", {1, 1, 1}, 1, 1, 0}};
    topology->material.clear();
    mesh.topology = topology;
    scene.surfaces = {surface(std::move(mesh))};
    Look look = plain_look(256);
    look.light_azimuth = 0;
    look.light_elevation = 0;
    look.light = Vec3f::Constant(0.5f);
    look.sky = look.bounce = Vec3f::Zero();
    Camera far = camera_ahead();  // nearly parallel rays
    far.eye.z() = 1000;
    far.field_of_view = 2 * std::atan(2.0 / 1000);
    const Image image = render::draw(scene, far, look);
    for (const double s : {0.0, 0.3, 0.6, 0.8}) {
        const auto p = pixel(image, 128 + int(std::lround(64 * s)), 128);
        const double at = (double(std::lround(64 * s)) + 0.5) / 64;
        const double lambert = 0.5 * std::sqrt(1 - at * at);
        const double shown = render::linear_from_srgb(float(p[0]) / 255);
        // Two levels of 8 bits, and the half vector's leaving the normal away from the middle.
        EXPECT_NEAR(shown, 0.97 * lambert - 0.04, 0.01) << s;
        EXPECT_EQ(p[0], p[1]);
        EXPECT_EQ(p[1], p[2]);
    }
}

TEST(Draw, TheNearerThingIsSeenWhateverTheOrder)
{
    const auto red = card(0, 0.5, {0.7f, 0, 0}), green = card(1, 0.5, {0, 0.7f, 0});
    for (const bool swapped : {false, true}) {
        Scene scene;
        scene.surfaces = swapped ? std::vector{green, red} : std::vector{red, green};
        const auto p = pixel(render::draw(scene, camera_ahead(), plain_look()), 64, 64);
        EXPECT_LT(p[0], 8);
        EXPECT_GT(p[1], 200);
    }
}

// An edge that crosses the last quarter of a pixel and three quarters of the next while the shutter
// is open: the first is covered at 1 - 0.25^2 / 2, the second at 0.75^2 / 2, whichever way the edge
// goes. Of 16 samples at most two more or less are covered.
TEST(Draw, AMovingEdgeIsBlurredAlikeInBothDirections)
{
    constexpr int size = 32, middle = 16;
    constexpr float pixel_size = 4.0f / size, half = 1;
    const auto light = [](int step) { return render::linear_from_srgb(float(step) / 255); };
    for (const int exposures : {1, 16, 20}) {
        for (const bool forth : {false, true}) {
            auto white = card(0, half, Vec3f::Constant(0.7f));
            auto left = std::make_shared<TriMesh>(*white.mesh);
            auto right = std::make_shared<TriMesh>(*white.mesh);
            for (Vec3f& p : left->positions) p.x() -= half + 0.25f * pixel_size;
            for (Vec3f& p : right->positions) p.x() -= half - 0.75f * pixel_size;
            white.mesh = forth ? right : left;
            white.before = forth ? left : right;
            Scene scene;
            scene.surfaces = {white};
            Look look = plain_look(size);
            look.backdrop_top = look.backdrop_horizon = {0, 0, 0};
            look.antialias = render::Antialias::samples16;
            look.shutter = 1;
            look.exposures = exposures;
            const Image image = render::draw(scene, camera_ahead(), look);
            const float whole = light(pixel(image, middle - 3, middle)[1]);
            const auto cover = [&](int x) { return light(pixel(image, x, middle)[1]) / whole; };
            EXPECT_NEAR(cover(middle - 1), 0.969, 2.0 / 16) << forth << ' ' << exposures;
            EXPECT_NEAR(cover(middle), 0.281, 2.0 / 16) << forth << ' ' << exposures;
        }
    }
}

// As a scan in PLY has them: colours of vertices, and no material or one that assimp made up.
TEST(Draw, VerticesShowTheirColoursWhereNoMaterialIsStated)
{
    const auto shown = [](std::vector<geometry::Material> materials) {
        auto red = card(0, 0.5, {});
        TriMesh mesh = *red.mesh;
        mesh.colours.assign(mesh.positions.size(), Vec3f(0.7f, 0, 0));
        auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
        topology->materials = std::move(materials);
        topology->material.clear();
        mesh.topology = topology;
        red.mesh = std::make_shared<const TriMesh>(std::move(mesh));
        red.paint.by = render::Paint::By::material;
        Scene scene;
        scene.surfaces = {red};
        return pixel(render::draw(scene, camera_ahead(), plain_look()), 64, 64);
    };
    const float made_up = render::linear_from_srgb(0.852f);
    for (const auto& unstated :
         {std::vector<geometry::Material>{}, std::vector<geometry::Material>{{}},
          std::vector<geometry::Material>{{"DefaultMaterial", Vec3f::Constant(made_up)}},
          std::vector<geometry::Material>{{"", {1, 1, 1}}}}) {  // glTF without a material
        EXPECT_GT(shown(unstated)[0], 200);
        EXPECT_LT(shown(unstated)[1], 8);
    }
    const auto green = shown({{"paint", {0, 0.7f, 0}}});
    EXPECT_LT(green[0], 8);
    EXPECT_GT(green[1], 200);
}

// Red at 60 % over green over the backdrop's 0.5 blue, in linear light: 0.6 red + 0.4 (0.5 green +
// 0.25 blue) = (0.6, 0.2, 0.1), whichever order the surfaces come in. Before the eye sees it the
// tone map takes x - 6.25 x^2 of the least channel x, or 0.04, from all three.
TEST(Draw, TransparentThingsAreLaidOverEachOtherFromFarToNear)
{
    auto red = card(1, 0.5, {1, 0, 0}), green = card(0, 0.5, {0, 1, 0});
    red.opacity = 0.6f;
    green.opacity = 0.5f;
    for (const auto antialias : {render::Antialias::none, render::Antialias::samples4}) {
        for (const bool swapped : {false, true}) {
            Scene scene;
            scene.surfaces = swapped ? std::vector{green, red} : std::vector{red, green};
            Look look = plain_look();
            look.antialias = antialias;
            const auto p = pixel(render::draw(scene, camera_ahead(), look), 64, 64);
            const Vec3f expected = render::srgb_from_linear(Vec3f(0.56f, 0.16f, 0.06f));
            // Half a level of 8 bits in colour and opacity, and one of dither.
            for (int k = 0; k < 3; ++k) EXPECT_NEAR(p[std::size_t(k)], 255 * expected[k], 3.0);
        }
    }
}

// Of the point (x, 0, z) in a square picture.
int brightness_at(const Image& image, const Camera& camera, double x, double z)
{
    const Vec3 forward = (camera.target - camera.eye).normalized();
    const Vec3 right = forward.cross(Vec3::UnitY()).normalized(), up = right.cross(forward);
    const Vec3 q = Vec3(x, 0, z) - camera.eye;
    const double half = 0.5 * image.width;
    const double scale = half / (q.dot(forward) * std::tan(camera.field_of_view / 2));
    return pixel(image, int(half + scale * q.dot(right)), int(half - scale * q.dot(up)))[1];
}

// A card held level 1 m over the floor, lit from straight above: its shadow lies under it, as large
// as the card, and nowhere else.
TEST(Draw, TheFloorShowsTheShadowWhereTheLightSaysSo)
{
    Scene scene;
    TriMesh mesh = geometry::grid(1, 1, 4, 4);
    for (Vec3f& p : mesh.positions) p.y() = 1;
    scene.surfaces = {surface(std::move(mesh))};
    scene.ground = 0;
    scene.stage = box_about_origin(1);
    Look look = plain_look(256);
    look.shadow = render::ShadowQuality::medium;
    look.light_elevation = std::numbers::pi / 2;
    look.light = Vec3f::Constant(0.8f);
    // Seen from below the card's edge: from the side, so that the floor under it is in view.
    Camera camera{{0, 4, 8}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.3)};
    const Image image = render::draw(scene, camera, look);
    const auto brightness = [&](double x, double z) { return brightness_at(image, camera, x, z); };
    const int lit = brightness(1.2, 0.5), dark = brightness(0, 0.2);
    EXPECT_LT(dark, lit - 40);
    // Its edge is at x = 0.5, soft over 3 texels of 2 * 1.5 / 1024 m each side.
    EXPECT_NEAR(brightness(0.45, 0.2), dark, 6);
    EXPECT_NEAR(brightness(0.55, 0.2), lit, 6);
    EXPECT_NEAR(brightness(-0.45, 0.2), dark, 6);
    EXPECT_NEAR(brightness(-0.55, 0.2), lit, 6);
    look.shadow = render::ShadowQuality::off;
    EXPECT_GT(pixel(render::draw(scene, camera, look), 128, 140)[1], dark + 40);
}

// The sun 1.5 degrees high: a post of 1 m casts a shadow of 38 m, beyond where the floor has faded
// away.
TEST(Draw, ALowLightCastsALongStraightShadow)
{
    Scene scene;
    TriMesh post = geometry::box({0.4, 1, 0.4}, {1, 1, 1});
    for (Vec3f& p : post.positions) p.y() += 0.5f;
    scene.surfaces = {surface(std::move(post))};
    scene.ground = 0;
    scene.stage = box_about_origin(1);
    const Camera camera{{0, 16, 8}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.5)};
    Look look = plain_look(256);
    look.shadow = render::ShadowQuality::medium;
    look.light_elevation = 1.5 * std::numbers::pi / 180;
    look.light = Vec3f::Constant(16);
    for (const double degrees : {20.0, 70.0, 155.0, 260.0}) {
        look.light_azimuth = degrees * std::numbers::pi / 180;
        const Image image = render::draw(scene, camera, look);
        const double x = -std::sin(look.light_azimuth), z = -std::cos(look.light_azimuth);
        for (const double far : {1.0, 2.5, 4.0}) {
            const int dark = brightness_at(image, camera, far * x, far * z);
            for (const double beside : {-0.6, 0.6}) {
                EXPECT_LT(dark,
                          brightness_at(image, camera, far * x + beside * z, far * z - beside * x) -
                              20)
                    << degrees << ' ' << far;
            }
        }
    }
}

TEST(Draw, AThingDoesNotShadowItself)
{
    // Lit at a slant from the camera's side, every visible point of the ball that faces the light
    // is lit: with and without a shadow the picture is the same but for the rim of its own shadow.
    Scene scene;
    scene.surfaces = {surface(geometry::icosphere(1, 5))};
    Look look = plain_look(128);
    look.light_azimuth = 0.3;
    look.light_elevation = 0.3;
    const Image without = render::draw(scene, camera_ahead(), look);
    for (const auto quality : {render::ShadowQuality::low, render::ShadowQuality::high}) {
        look.shadow = quality;
        const Image with = render::draw(scene, camera_ahead(), look);
        const Vec3 light = render::direction(0.3, 0.3);
        for (int y = 0; y < 128; y += 3) {
            for (int x = 0; x < 128; x += 3) {
                const Vec3 n((x - 63.5) / 32, (63.5 - y) / 32, 0);
                if (n.norm() > 0.97) continue;
                const Vec3 normal(n.x(), n.y(), std::sqrt(1 - n.squaredNorm()));
                if (normal.dot(light) < 0.15) continue;
                EXPECT_NEAR(pixel(with, x, y)[1], pixel(without, x, y)[1], 3) << x << ' ' << y;
            }
        }
    }
}

TEST(Draw, BothSidesOfAnOpenSheetAreLit)
{
    // A sheet that faces away from the camera, light from behind the camera: what is seen is its
    // back, and that is as bright as a front would be.
    auto front = card(0, 0.5, {1, 1, 1});
    front.receives = true;
    auto back = front;
    auto flipped = std::make_shared<TriMesh>(*front.mesh);
    auto topology = std::make_shared<geometry::MeshTopology>(*flipped->topology);
    for (auto* list : {&topology->triangles, &topology->normal_triangles}) {
        for (auto& t : *list) std::swap(t[1], t[2]);
    }
    flipped->topology = topology;
    for (Vec3f& n : flipped->normals) n = -n;
    back.mesh = flipped;
    Look look = plain_look();
    look.light_azimuth = 0.2;
    look.light_elevation = 0.1;
    Scene a, b;
    a.surfaces = {front};
    b.surfaces = {back};
    const auto p = pixel(render::draw(a, camera_ahead(), look), 64, 64);
    EXPECT_EQ(p, pixel(render::draw(b, camera_ahead(), look), 64, 64));
    EXPECT_GT(p[0], 150);
    // A file that winds a face against its normals shows the same.
    auto wrong = std::make_shared<TriMesh>(*front.mesh);
    topology = std::make_shared<geometry::MeshTopology>(*wrong->topology);
    for (auto* list : {&topology->triangles, &topology->normal_triangles}) {
        std::swap((*list)[0][1], (*list)[0][2]);
    }
    wrong->topology = topology;
    back.mesh = wrong;
    b.surfaces = {back};
    const Image image = render::draw(b, camera_ahead(), look);
    for (const int x : {56, 72}) {  // on either side of the diagonal; dither is a level
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(pixel(image, x, 64)[k], p[k], 1);
    }
}

TEST(Draw, AnAttributeIsShownInItsColours)
{
    auto flat = card(0, 1, {0, 0, 0});
    auto mesh = std::make_shared<TriMesh>(*flat.mesh);
    std::vector<float> values;
    for (const Vec3f& p : mesh->positions) values.push_back(10 * p.x());
    mesh->attributes = {{"heat", "K", values}};
    flat.mesh = mesh;
    flat.paint = {
        render::Paint::By::attribute, Vec3f::Zero(), "heat", {render::ColourMap::viridis, -10, 10}};
    Scene scene;
    scene.surfaces = {flat};
    const Image image = render::draw(scene, camera_ahead(), plain_look());
    for (const int x : {5, 40, 64, 100, 124}) {
        // At the pixel's centre: 64 pixels are 2 m / 2 at 10 m.
        const double value = (x + 0.5 - 64) / 64 * 2;
        if (std::abs(value) > 1) continue;
        const Vec3f c = render::linear_from_srgb(
            render::colour_at(render::ColourMap::viridis, float(0.5 + 0.5 * value)));
        const float least = c.minCoeff();
        const float off = least < 0.08f ? least - 6.25f * least * least : 0.04f;  // the tone map
        const Vec3f expected = render::srgb_from_linear(Vec3f(c.array() - off));
        const auto p = pixel(image, x, 64);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(p[std::size_t(k)], 255 * expected[k], 6) << x << ' ' << k;
        }
    }
    flat.paint.attribute = "cold";
    scene.surfaces = {flat};
    EXPECT_THROW(render::draw(scene, camera_ahead(), plain_look()), std::invalid_argument);
}

TEST(Draw, WhatIsNotFiniteIsLeftOutWithAWarning)
{
    TriMesh mesh = geometry::icosphere(1, 3);
    const std::size_t faces = mesh.triangles().size();
    mesh.positions[0].x() = float(nan);
    mesh.positions[1].y() = std::numeric_limits<float>::infinity();
    mesh.positions[2] *= 1e30f;
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    topology->triangles[faces / 2][1] = 4'000'000'000u;
    topology->normal_triangles[faces / 3][0] = 4'000'000'000u;
    mesh.topology = topology;
    Scene scene;
    scene.surfaces = {surface(std::move(mesh))};
    scene.stage = box_about_origin(1);
    render::Balls balls;
    balls.centres = {Vec3f::Constant(float(nan)), Vec3f(0, 0, 2)};
    balls.colours = {Vec3f(1, 0, 0)};
    scene.balls = {balls};
    scene.lines.push_back({{Vec3f::Zero(), Vec3f::Constant(float(nan))}, {0, 0, 0}, 1});
    for (const auto quality : {render::ShadowQuality::off, render::ShadowQuality::medium}) {
        Look look = plain_look();
        look.shadow = quality;
        std::vector<std::string> warnings;
        const Image image = render::draw(scene, camera_ahead(), look, &warnings);
        EXPECT_EQ(warnings.size(), 2u);
        EXPECT_GT(covered_pixels(image), 2000);  // of 3,200: the rest of the sphere is there
    }
}

TEST(Draw, AMeshWithoutNormalsOrFacesOrAreaIsNoTrouble)
{
    TriMesh bare = geometry::icosphere(1, 3);
    auto topology = std::make_shared<geometry::MeshTopology>(*bare.topology);
    topology->normal_triangles.clear();
    bare.normals.clear();
    bare.topology = topology;
    TriMesh points;
    points.positions = {Vec3f(0, 0, 0), Vec3f(1, 0, 0)};
    TriMesh flat = geometry::icosphere(1, 1);
    for (Vec3f& p : flat.positions) p = Vec3f(0.5f, 0.5f, 0.5f);
    Scene scene;
    scene.surfaces = {surface(bare), surface(points), surface(flat), surface(TriMesh{})};
    const Image image = render::draw(scene, camera_ahead(), plain_look());
    EXPECT_GT(covered_pixels(image), 2900);
}

TEST(Draw, OnePointIsDrawn)
{
    Scene scene;
    scene.balls = {{{Vec3f(0, 0, 0)}, {Vec3f(1, 0, 0)}, 0.2f, 1, true}};
    const Image image = render::draw(scene, camera_ahead(), plain_look());
    // A disc of radius 0.2 m in a picture 4 m high, 128 pixels: 6.4 pixels.
    EXPECT_NEAR(covered_pixels(image), std::numbers::pi * 6.4 * 6.4, 12);
}

// The same scene in millionths and thousand millions of a metre gives the same picture but for
// rounding: at most a few pixels on outlines.
TEST(Draw, SizeDoesNotMatter)
{
    const auto picture = [](double scale) {
        Scene scene;
        scene.surfaces = {surface(geometry::icosphere(scale, 4))};
        scene.ground = -scale;
        Look look = plain_look();
        look.shadow = render::ShadowQuality::medium;
        Camera camera{{0, 2 * scale, 5 * scale}, {0, 0, 0}, {0, 1, 0}, 0.7};
        return render::draw(scene, camera, look);
    };
    const Image one = picture(1);
    for (const double scale : {1e-6, 1e9}) {
        const Image other = picture(scale);
        int differ = 0;
        for (std::size_t i = 0; i < one.rgba.size(); ++i) {
            differ += std::abs(one.rgba[i] - other.rgba[i]) > 2 ? 1 : 0;
        }
        EXPECT_LT(differ, 200) << scale;
    }
}

TEST(Draw, TheGridStaysWhatFliesAbout)
{
    Look look = plain_look(256);
    look.grid = true;
    const Camera camera{{0, 2, 3}, {0, 0, 0}, {0, 1, 0}, 0.6};
    // A box in the picture, and another that flies off behind the camera.
    const auto picture = [&](float away) {
        Scene scene;
        const TriMesh here = geometry::box({0.4, 0.4, 0.4}, {1, 1, 1});
        TriMesh there = here;
        for (Vec3f& p : there.positions) p += Vec3f(0, 1, 3.5f + away);
        scene.surfaces = {surface(here), surface(std::move(there))};
        scene.ground = -0.2;
        return render::draw(scene, camera, look);
    };
    const Image near = picture(0);
    for (const float away : {3.0f, 10.0f, 40.0f}) {
        const Image far = picture(away);
        int lines = 0, others = 0;
        for (int y = 128; y < 256; ++y) {
            for (int x = 1; x < 256; ++x) {
                lines += std::abs(pixel(near, x, y)[1] - pixel(near, x - 1, y)[1]) > 3;
                others += std::abs(pixel(near, x, y)[1] - pixel(far, x, y)[1]) > 3;
            }
        }
        EXPECT_GT(lines, 500);
        EXPECT_LT(others, lines / 10) << away;
    }
}

// A sheet that lies on the floor has the floor's own depth, up to rounding.
TEST(Draw, ASheetThatLiesOnTheFloorHidesIt)
{
    for (const double height : {0.0, 0.37, -12.3}) {
        for (const double above : {0.3, 1.7, 6.0}) {
            Scene scene;
            TriMesh mesh = geometry::grid(1, 0.6, 20, 12);
            for (Vec3f& p : mesh.positions) p.y() = float(height);
            scene.surfaces = {surface(std::move(mesh))};
            scene.surfaces[0].paint.by = render::Paint::By::constant;
            scene.surfaces[0].paint.colour = {1, 0, 0};
            scene.surfaces[0].receives = false;
            const Camera camera{{0, height + above, 2}, {0, height, 0}, {0, 1, 0}, 0.5};
            const auto red = [&] {
                const Image image = render::draw(scene, camera, plain_look());
                int sum = 0;
                for (int y = 0; y < image.height; ++y) {
                    for (int x = 0; x < image.width; ++x) {
                        const auto p = pixel(image, x, y);
                        sum += p[0] > 2 * p[1] ? 1 : 0;
                    }
                }
                return sum;
            };
            const int bare = red();
            ASSERT_GT(bare, 50);
            scene.ground = height;
            EXPECT_GE(red(), bare) << height << ' ' << above;
        }
    }
}

// Where the colours change within the sheet, each sample of a pixel is asked what it shows.
TEST(Draw, AColouredSheetThatLiesOnTheFloorHidesItInAllSamples)
{
    for (const double height : {0.0, 0.37, -12.3}) {
        TriMesh mesh = geometry::grid(1, 0.6, 20, 12);
        geometry::Attribute stripes{"stripes", "1", {}};
        for (Vec3f& p : mesh.positions) {
            stripes.values.push_back(float(stripes.values.size() % 2));
            p.y() = float(height);
        }
        mesh.attributes.push_back(std::move(stripes));
        Scene scene;
        scene.surfaces = {surface(std::move(mesh))};
        scene.surfaces[0].paint = {render::Paint::By::attribute, {}, "stripes", {}};
        scene.surfaces[0].receives = false;
        const Camera camera{{0, height + 1.7, 2}, {0, height, 0}, {0, 1, 0}, 0.5};
        Look look = plain_look();
        look.antialias = render::Antialias::samples4;
        const Image bare = render::draw(scene, camera, look);
        scene.ground = height;
        const Image grounded = render::draw(scene, camera, look);
        // Pixels whose neighbours show the sheet too lie inside of it.
        const auto within = [&](int x, int y) {
            int sum = 0;
            for (int k = 0; k < 9; ++k) sum += covered(bare, x - 1 + k % 3, y - 1 + k / 3);
            return sum == 9;
        };
        int inside = 0, differ = 0;
        for (int y = 1; y + 1 < bare.height; ++y) {
            for (int x = 1; x + 1 < bare.width; ++x) {
                if (!within(x, y)) continue;
                ++inside;
                differ += pixel(bare, x, y) == pixel(grounded, x, y) ? 0 : 1;
            }
        }
        EXPECT_GT(inside, 500);
        EXPECT_EQ(differ, 0) << height;
    }
}

// Ink of a strip `width` pixels wide in each row of the picture, as a share of a pixel: the dark
// part of what the row has, added up.
std::vector<double> ink_of_a_strip(double width, render::Antialias antialias)
{
    const Camera camera = camera_ahead();
    const double pixel_size = 4.0 / 128;
    TriMesh strip = geometry::grid(1, 1, 1, 1);
    for (Vec3f& p : strip.positions) {
        const double along = -2.0 * p.z();  // -1 .. 1, a slant of a pixel in eight
        p = Vec3f(float(p.x() * width * pixel_size + along / 8), float(1.5 * along), 0);
    }
    for (Vec3f& n : strip.normals) n = Vec3f::UnitZ();
    Scene scene;
    scene.surfaces = {surface(std::move(strip))};
    scene.surfaces[0].paint = {render::Paint::By::constant, {0, 0, 0}, {}, {}};
    scene.surfaces[0].receives = false;
    Look look = plain_look(128);
    look.backdrop_top = look.backdrop_horizon = {0.5f, 0.5f, 0.5f};
    look.antialias = antialias;
    const Image image = render::draw(scene, camera, look);
    const double white = pixel(image, 2, 64)[1];
    std::vector<double> ink;
    for (int y = 24; y < 104; ++y) {
        double sum = 0;
        for (int x = 0; x < 128; ++x) sum += 1 - std::min(1.0, pixel(image, x, y)[1] / white);
        ink.push_back(sum);
    }
    return ink;
}

// Samples at four different quarters of a pixel: each row of a strip 0.4 pixels wide meets one of
// them or two. One sample a pixel misses it in six rows of ten.
TEST(Draw, AThinStripStaysWhole)
{
    const auto least = [](const std::vector<double>& ink) {
        return *std::min_element(ink.begin(), ink.end());
    };
    EXPECT_EQ(least(ink_of_a_strip(0.4, render::Antialias::none)), 0);
    EXPECT_GT(least(ink_of_a_strip(0.4, render::Antialias::samples4)), 0.1);
    // Sixteen samples, each at another sixteenth: six or seven of them.
    const auto fine = ink_of_a_strip(0.4, render::Antialias::samples16);
    const double most = *std::max_element(fine.begin(), fine.end());
    EXPECT_GT(least(fine), 0.55 * most);
}

TEST(Draw, TheSameSceneGivesTheSamePixelsInAnyThread)
{
    Scene scene;
    scene.surfaces = {surface(geometry::torus(1, 0.3, 48, 24))};
    scene.ground = -0.3;
    scene.label = "frame 1";
    Look look;
    look.width = 160;
    look.height = 90;
    Camera camera{{0, 2, 5}, {0, 0, 0}, {0, 1, 0}, 0.6};
    const Image first = render::draw(scene, camera, look);
    EXPECT_EQ(render::draw(scene, camera, look).rgba, first.rgba);
    // Another size in between: nothing of it stays behind in the context.
    look.width = 40;
    look.antialias = render::Antialias::samples4;
    render::draw({}, camera, look);
    look.width = 160;
    look.antialias = render::Antialias::fxaa;
    std::array<Image, 2> others;
    std::thread a([&] { others[0] = render::draw(scene, camera, look); });
    std::thread b([&] { others[1] = render::draw(scene, camera, look); });
    a.join();
    b.join();
    EXPECT_EQ(others[0].rgba, first.rgba);
    EXPECT_EQ(others[1].rgba, first.rgba);
}

// Something of everything: an opaque thing and a clear one, lines, balls, a floor with a shadow.
std::vector<std::uint8_t> pixels_of_everything()
{
    Scene scene;
    scene.surfaces = {surface(geometry::torus(1, 0.3, 48, 24)), card(0.5, 0.4, {0.1f, 0.5f, 0.9f})};
    scene.lines = {{{Vec3f(-1, 0, 1), Vec3f(1, 1, -1)}, {0, 0, 0}, 2}};
    scene.balls = {{{Vec3f(0, 0.6f, 0), Vec3f(0.5f, 0.8f, 0)}, {Vec3f(1, 0, 0)}, 0.2f, 1, true}};
    scene.ground = -0.3;
    std::vector<std::uint8_t> all;
    for (const float opacity : {1.0f, 0.4f}) {
        scene.surfaces[1].opacity = opacity;
        for (const auto antialias :
             {render::Antialias::fxaa, render::Antialias::samples4, render::Antialias::samples16}) {
            Look look;
            look.width = 240;
            look.height = 136;
            look.style = render::Style::studio;
            look.soft = antialias == render::Antialias::samples4;
            look.antialias = antialias;
            const Image image = render::draw(scene, {{0, 2, 5}, {0, 0, 0}, {0, 1, 0}, 0.6}, look);
            all.insert(all.end(), image.rgba.begin(), image.rgba.end());
        }
    }
    return all;
}

// Mesa reads how many threads it may use when it starts: each number needs a process of its own,
// this program once more. The variable says where the pixels go.
TEST(Draw, AnyNumberOfMesasThreadsGivesTheSamePixels)
{
    const std::vector<std::uint8_t> pixels = pixels_of_everything();
    if (const char* path = std::getenv("ASPIC_TEST_PIXELS_TO")) {
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(pixels.data()), std::ssize(pixels));
        return;
    }
    const files::Folder folder;
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    for (const char* threads : {"0", "1", "5"}) {
        const auto path = folder.path / threads;
        const std::string command = "ASPIC_TEST_PIXELS_TO='" + path.string() +
                                    "' LP_NUM_THREADS=" + threads + " '" + program +
                                    "' --gtest_filter=Draw.AnyNumberOf* >/dev/null";
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
        std::ifstream in(path, std::ios::binary);
        const std::vector<std::uint8_t> theirs{std::istreambuf_iterator<char>(in), {}};
        EXPECT_TRUE(theirs == pixels) << threads << " threads";
    }
}

TEST(Draw, ImpossibleRequestsAreRefused)
{
    Look look = plain_look();
    look.width = 0;
    EXPECT_THROW(render::draw({}, camera_ahead(), look), std::invalid_argument);
    look.width = 100'000;
    EXPECT_THROW(render::draw({}, camera_ahead(), look), std::invalid_argument);
    Camera camera = camera_ahead();
    camera.target = camera.eye;
    EXPECT_THROW(render::draw({}, camera, plain_look()), std::invalid_argument);
    camera = camera_ahead();
    camera.eye.x() = nan;
    EXPECT_THROW(render::draw({}, camera, plain_look()), std::invalid_argument);
    camera = camera_ahead();
    camera.field_of_view = 0;
    EXPECT_THROW(render::draw({}, camera, plain_look()), std::invalid_argument);
}

}  // namespace
