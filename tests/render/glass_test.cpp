// Glass: how light the shadows of clear things are, and what they mirror.

#include "geometry/base/srgb.hpp"
#include "geometry/mesh/texture.hpp"
#include "tests/render/pictures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using geometry::Vec3;
using geometry::Vec3f;
using render::Image;

double light_at(const Image& image, int x, int y)
{
    const auto p = tests::pixel(image, x, y);
    return double(geometry::linear_from_srgb(Vec3f::Constant(float(p[1]) / 255))[0]);
}

geometry::TriMesh with_opacity(geometry::TriMesh mesh, float opacity)
{
    auto topology = *mesh.topology;
    topology.materials = {geometry::Material{"pane", {0.6f, 0.6f, 0.6f}, opacity}};
    mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return mesh;
}

// A pane of 2 x 2 m that hovers 1 m above a white floor, lit from 45 degrees on the left, so that
// its shadow lies 1 m to the right; seen from above and aside.
render::Scene pane(float opacity)
{
    render::Scene scene;
    geometry::TriMesh mesh = with_opacity(geometry::grid(2, 2, 1, 1), opacity);
    for (auto& p : mesh.positions) p.y() += 1;
    scene.surfaces.push_back(tests::surface(std::move(mesh)));
    scene.stage = tests::box_about_origin(2);
    scene.ground = 0;
    return scene;
}

render::Look glass_look(bool soft)
{
    render::Look look = tests::plain_look(200);
    look.shadow = render::ShadowQuality::medium;
    look.light_azimuth = -1.5707963;
    look.light_elevation = 0.7853982;
    look.light = {0.6f, 0.6f, 0.6f};
    look.light_size = 0.05;
    look.soft = soft;
    look.occlusion = 0;
    look.floor = {0.5f, 0.5f, 0.5f};
    look.glass = true;
    return look;
}

// The light of the floor in the middle of that part of the shadow which the pane does not cover:
// the mean of 16 x 16 pixels.
double floor_light(const render::Scene& scene, const render::Look& look, double* spread = nullptr)
{
    // From right above: 8 m at 8 m, 200 pixels.
    const render::Camera camera{{0, 8, 0.001}, {0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5)};
    const Image image = render::draw(scene, camera, look);
    // x = 1.6 m: beyond the pane, which seems to reach to 8 / 7, and within the shadow, to 2.
    double sum = 0, low = 1, high = 0;
    for (int y = 92; y < 108; ++y) {
        for (int x = 132; x < 148; ++x) {
            const double light = light_at(image, x, y);
            sum += light;
            low = std::min(low, light), high = std::max(high, light);
        }
    }
    if (spread) *spread = high - low;
    return sum / 256;
}

// The key light comes through as far as the pane is clear. 5 %: a sixteenth is the finest share
// that 4 x 4 texels tell, which makes 3 %, and 8-bit colours.
TEST(Glass, CastsShadowsAsLightAsItIsClear)
{
    for (const bool soft : {false, true}) {
        render::Look look = glass_look(soft);
        const double lit = floor_light(pane(0), look);
        const double dark = floor_light(pane(1), look);
        ASSERT_GT(lit, dark + 0.1);
        for (const float opacity : {0.25f, 0.5f, 0.75f}) {
            double spread = 0;
            const double here = floor_light(pane(opacity), look, &spread);
            EXPECT_NEAR((lit - here) / (lit - dark), double(opacity), 0.05) << soft << opacity;
            if (soft) {
                EXPECT_LT(spread, 0.1 * (lit - dark)) << opacity;  // no stipple
            }
        }
        // Without, all that casts a shadow casts a whole one.
        look.glass = false;
        EXPECT_NEAR(floor_light(pane(0.25f), look), dark, 0.02);
    }
}

// So does a pane whose texture is as clear: below an alpha of 0.5 too, where a shadow without glass
// ends.
TEST(Glass, CastsShadowsAsLightAsItsTextureIsClear)
{
    const auto textured = [](std::uint8_t alpha) {
        render::Scene scene = pane(1);
        geometry::TriMesh mesh = *scene.surfaces[0].mesh;
        auto topology = *mesh.topology;
        topology.uvs = {{0.5f, 0.5f}};
        topology.uv_triangles.assign(topology.triangles.size(), {0, 0, 0});
        topology.materials[0].texture =
            std::make_shared<const geometry::Texture>(geometry::Texture::Source{
                "pane.png", geometry::encode_png({1, 1, {90, 90, 90, alpha}})});
        topology.materials[0].use.alpha = geometry::TextureUse::Alpha::blended;
        mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
        scene.surfaces[0].mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
        return scene;
    };
    render::Look look = glass_look(true);
    const double lit = floor_light(pane(0), look), dark = floor_light(pane(1), look);
    for (const int alpha : {64, 102, 191}) {
        const double here = floor_light(textured(std::uint8_t(alpha)), look);
        EXPECT_NEAR((lit - here) / (lit - dark), alpha / 255.0, 0.05) << alpha;
    }
    look.glass = false;
    EXPECT_NEAR(floor_light(textured(102), look), lit, 0.02);
}

// A clear ball before a dark backdrop with a bright sky: near its rim it mirrors more than in its
// middle, and hides what is behind; a ball without glass is as clear there.
TEST(Glass, MirrorsTheSkyAtItsRim)
{
    render::Scene scene;
    scene.surfaces.push_back(tests::surface(with_opacity(geometry::icosphere(1, 4), 0.1f)));
    scene.surfaces.back().shadow = false;
    render::Look look = tests::plain_look(200);
    look.backdrop_top = {0.9f, 0.9f, 0.9f};
    look.backdrop_horizon = {0.1f, 0.1f, 0.1f};
    look.light_azimuth = 3.1;  // from behind: no glint in the way
    const render::Camera camera{{0, 0, 6}, {0, 0, 0}, {0, 1, 0}, 0.4};
    const auto picture = [&](bool glass) {
        look.glass = glass;
        return render::draw(scene, camera, look);
    };
    const Image with = picture(true), without = picture(false);
    // The ball's radius is 100 * (1 / sqrt(35)) / tan 0.2 = 83.4 pixels. At 78 of them above its
    // middle its surface is seen under asin(78 / 83.4), 69 degrees: a share of 0.04 + 0.96 (1 - cos
    // 69)^5 = 0.14 of the sky is mirrored there, and 0.04 in the middle.
    const double rim = light_at(with, 100, 100 - 78) - light_at(without, 100, 100 - 78);
    const double middle = light_at(with, 100, 100) - light_at(without, 100, 100);
    EXPECT_GT(rim, 0.05);
    EXPECT_LT(std::abs(middle), 0.05);
    EXPECT_GT(rim, middle + 0.05);
}

}  // namespace
