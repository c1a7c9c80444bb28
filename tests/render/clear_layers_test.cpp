// Clear things that cut through each other: sorted in each sample, and not by whole triangles.

#include "pictures.hpp"
#include "render/make_draw_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace tests;
using geometry::TriMesh;
using geometry::Vec3f;
using render::Look;
using render::Scene;
using render::Surface;

// Looks along -z from 10 m at the origin; the picture is 4 m high at z = 0.
const render::Camera ahead{{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.2)};

// A square of 1.4 m about the z axis at `z`, which comes nearer by `slope` times x. Unlit.
Surface pane(double z, double slope, const Vec3f& colour, float opacity, int cells = 1)
{
    TriMesh mesh = geometry::grid(1.4, 1.4, cells, cells);
    for (Vec3f& p : mesh.positions) p = Vec3f(p.x(), -p.z(), float(z + slope * p.x()));
    for (Vec3f& n : mesh.normals) n = Vec3f::UnitZ();
    Surface out = surface(std::move(mesh));
    out.paint.by = render::Paint::By::constant;
    out.paint.colour = colour;
    out.receives = false;
    out.opacity = opacity;
    return out;
}

// As shaders/shade.glsl tones light of no more than 0.76.
Vec3f shown(const Vec3f& light)
{
    const float least = light.minCoeff();
    const float offset = least < 0.08f ? least - 6.25f * least * least : 0.04f;
    return 255 * render::srgb_from_linear(light.array() - offset);
}

Vec3f over(const Surface& s, const Vec3f& behind)
{
    return s.opacity * s.paint.colour + (1 - s.opacity) * behind;
}

const Vec3f backdrop{0, 0, 0.5f};

void expect_pixel(const render::Image& image, int x, int y, const Vec3f& light)
{
    const auto p = pixel(image, x, y);
    const Vec3f expected = shown(light);
    // Half a level of 8 bits in colour and opacity, and one of dither.
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(p[std::size_t(k)], expected[k], 3.0) << x << ' ' << k;
}

// Two panes that cross along the y axis: on the left one is nearer, on the right the other.
TEST(ClearLayers, PanesThatCrossAreSortedInEachPixel)
{
    const Surface red = pane(0, -0.5, {0.7f, 0, 0}, 0.6f), green = pane(0, 0.5, {0, 0.7f, 0}, 0.5f);
    using render::Antialias;
    for (const auto antialias : {Antialias::none, Antialias::samples4, Antialias::samples16}) {
        for (const bool swapped : {false, true}) {
            Scene scene;
            scene.surfaces = swapped ? std::vector{green, red} : std::vector{red, green};
            Look look = plain_look();
            look.antialias = antialias;
            const auto image = render::draw(scene, ahead, look);
            // On both sides of the diagonal that parts a pane into triangles.
            for (const int y : {48, 80}) {
                expect_pixel(image, 58, y, over(red, over(green, backdrop)));
                expect_pixel(image, 70, y, over(green, over(red, backdrop)));
            }
        }
    }
}

// Light that a compositor gets has them in the same order.
TEST(ClearLayers, LinearLightIsSortedToo)
{
    const Surface red = pane(0, -0.5, {0.7f, 0, 0}, 0.6f), green = pane(0, 0.5, {0, 0.7f, 0}, 0.5f);
    Scene scene;
    scene.surfaces = {red, green};
    Look look = plain_look();
    look.linear = render::Linear::whole;
    const auto image = render::draw(scene, ahead, look);
    ASSERT_EQ(image.light.size(), image.rgba.size());
    const auto at = [&](std::size_t x, std::size_t y) { return image.light[4 * (128 * y + x)]; };
    EXPECT_EQ(at(58, 48), at(58, 80));
    EXPECT_EQ(at(70, 48), at(70, 80));
    EXPECT_NE(at(58, 48), at(70, 48));
}

// Seven panes behind each other, of which no more than four are peeled: the others lie behind them.
TEST(ClearLayers, WhatLiesBehindThePeeledLayersIsThereToo)
{
    Scene scene;
    Vec3f expected = backdrop;
    for (int k = 0; k < 7; ++k) {
        const Vec3f colour(k % 2 ? 0.7f : 0.1f, 0.1f * float(k), k % 3 ? 0.1f : 0.6f);
        scene.surfaces.push_back(pane(0.1 * k, 0.2, colour, 0.4f));
        expected = over(scene.surfaces.back(), expected);
    }
    std::reverse(scene.surfaces.begin(), scene.surfaces.end());
    const auto image = render::draw(scene, ahead, plain_look());
    expect_pixel(image, 50, 64, expected);
    expect_pixel(image, 78, 64, expected);
}

// A ghost is seen around the body and not on it, whatever clear thing cuts through it; what is
// opaque hides what lies behind it.
TEST(ClearLayers, GhostsSpareTheBody)
{
    Surface body = pane(0, 0, {0.5f, 0.1f, 0.1f}, 1),
            ghost = pane(0.5, 0, {0.1f, 0.6f, 0.1f}, 0.5f);
    for (auto* const s : {&body, &ghost}) {
        auto mesh = std::make_shared<TriMesh>(*s->mesh);
        if (s == &body) {
            for (Vec3f& p : mesh->positions) p.x() *= 0.5f;
        }
        s->mesh = mesh;
    }
    body.kind = Surface::Kind::body;
    ghost.kind = Surface::Kind::ghost;
    const Surface cut = pane(0.5, 0.3, {0.1f, 0.1f, 0.6f}, 0.5f);
    const Surface hidden = pane(-0.5, 0.3, {0.6f, 0.6f, 0.6f}, 0.5f);
    Scene scene;
    scene.surfaces = {body, ghost, cut, hidden};
    const auto image = render::draw(scene, ahead, plain_look());
    expect_pixel(image, 64, 64, over(cut, body.paint.colour));  // the body: |x| < 0.35
    expect_pixel(image, 46, 64, over(ghost, over(cut, over(hidden, backdrop))));
    expect_pixel(image, 82, 64, over(cut, over(ghost, over(hidden, backdrop))));
}

// Of panes in one plane none is lost, and the later one in the scene lies over the other: flat and
// tilted, of the same triangles and of others, whose depths differ by rounding, among others.
TEST(ClearLayers, PanesInOnePlaneLieInTheOrderOfTheScene)
{
    using render::Antialias;
    for (const double slope : {0.0, 0.7}) {
        for (const int cells : {1, 7}) {
            const Surface red = pane(0, slope, {0.7f, 0, 0}, 0.6f),
                          green = pane(0, slope, {0, 0.7f, 0}, 0.5f, cells),
                          behind = pane(-1, 0, {0.6f, 0.6f, 0.6f}, 0.5f, 2);
            for (const auto antialias : {Antialias::none, Antialias::samples16}) {
                Look look = plain_look();
                look.antialias = antialias;
                Scene scene;
                scene.surfaces = {red, green, behind};
                const auto one = render::draw(scene, ahead, look);
                scene.surfaces = {green, red, behind};
                const auto other = render::draw(scene, ahead, look);
                const Vec3f beyond = over(behind, backdrop);
                for (int y = 47; y <= 81; ++y) {
                    for (int x = 47; x <= 81; ++x) {
                        expect_pixel(one, x, y, over(green, over(red, beyond)));
                        expect_pixel(other, x, y, over(red, over(green, beyond)));
                    }
                }
            }
        }
    }
}

// As a shape at rest lies on a body that has not moved yet.
TEST(ClearLayers, AGhostOnAClearBodyIsSeen)
{
    Surface body = pane(0, 0, {0.5f, 0.1f, 0.1f}, 0.6f),
            ghost = pane(0, 0, {0.1f, 0.6f, 0.1f}, 0.5f);
    body.kind = Surface::Kind::body;
    ghost.kind = Surface::Kind::ghost;
    Scene scene;
    scene.surfaces = {body, ghost};
    expect_pixel(render::draw(scene, ahead, plain_look()), 60, 70,
                 over(ghost, over(body, backdrop)));
}

// Layers are peeled only where two clear things may cut through each other. Boxes that stand on
// each other do not.
TEST(ClearLayers, ThingsApartAreSortedByTriangles)
{
    const auto overlap = [](double apart, float opacity) {
        Scene scene;
        for (const double y : {0.0, apart}) {
            TriMesh box = geometry::box({1, 1, 1}, {1, 1, 1});
            for (Vec3f& p : box.positions) p.y() += float(y);
            scene.surfaces.push_back(surface(std::move(box)));
            scene.surfaces.back().opacity = opacity;
        }
        return render::make_draw_list(scene, ahead, plain_look()).layered > 0;
    };
    EXPECT_TRUE(overlap(0.9, 0.5f));
    EXPECT_FALSE(overlap(1, 0.5f));
    EXPECT_FALSE(overlap(1.5, 0.5f));
    EXPECT_FALSE(overlap(0.9, 1));
}

}  // namespace
