// Textures in pictures, and the smaller levels that are seen from afar.

#include "geometry/base/srgb.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/texture.hpp"
#include "pictures.hpp"
#include "render/surface_layout.hpp"
#include "render/texture_levels.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace {

using namespace tests;
using geometry::Picture;
using geometry::Texture;
using geometry::TextureUse;
using geometry::TriMesh;
using geometry::Vec3f;
using render::Image;
using render::Scene;
using Rgba = std::array<std::uint8_t, 4>;

constexpr Rgba red{200, 40, 30, 255}, green{40, 160, 60, 255}, blue{30, 60, 190, 255},
    white{230, 230, 230, 255}, nothing{255, 0, 255, 0};

// `across` by the rest of `colours`, each a square of `texels`.
std::shared_ptr<const Texture> squares(int across, const std::vector<Rgba>& colours, int texels)
{
    Picture picture{across * texels, int(colours.size()) / across * texels, {}};
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const Rgba& c = colours[std::size_t(y / texels * across + x / texels)];
            picture.rgba.insert(picture.rgba.end(), c.begin(), c.end());
        }
    }
    return std::make_shared<const Texture>(
        Texture::Source{"squares.png", geometry::encode_png(picture)});
}

// A square of 2 m in the plane z that faces the camera, unlit, with the texture's lower left corner
// at its own; texture coordinates run from 0 to `repeats`.
render::Surface card(std::shared_ptr<const Texture> texture, float repeats = 1, float z = 0,
                     TextureUse use = {}, const Vec3f& colour = Vec3f(1, 1, 1))
{
    TriMesh mesh = geometry::grid(2, 2, 1, 1);
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    for (Vec3f& p : mesh.positions) p = Vec3f(p.x(), -p.z(), z);
    for (Vec3f& n : mesh.normals) n = Vec3f::UnitZ();
    topology->uvs.clear();
    for (const Vec3f& p : mesh.positions) {
        topology->uvs.emplace_back(repeats * (p.x() + 1) / 2, repeats * (p.y() + 1) / 2);
    }
    topology->uv_triangles = topology->triangles;
    topology->materials = {{"paper", colour}};
    topology->materials[0].texture = std::move(texture);
    topology->materials[0].use = use;
    mesh.topology = std::move(topology);
    render::Surface out = surface(std::move(mesh));
    out.receives = false;
    return out;
}

// The picture is 2 m high at z = 0: one pixel of 128 is 1 / 64 m.
render::Camera camera_ahead()
{
    return {{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.1)};
}

Image drawn(std::vector<render::Surface> surfaces, const render::Look& look = plain_look())
{
    Scene scene;
    scene.surfaces = std::move(surfaces);
    return render::draw(scene, camera_ahead(), look);
}

// What a plain card of the display colour `c` looks like.
std::array<int, 3> plain(const Rgba& c)
{
    const Vec3f linear =
        geometry::linear_from_srgb(Vec3f(Vec3f(float(c[0]), float(c[1]), float(c[2])) / 255));
    return pixel(drawn({card(nullptr, 1, 0, {}, linear)}), 64, 64);
}

void expect_near(const std::array<int, 3>& a, const std::array<int, 3>& b, int tolerance)
{
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance) << "component " << k;
}

// The square roots of colours are kept in 8 bits: a step is up to two of a display's.
TEST(TexturesDrawn, ShowTheirOwnColoursWhereTheirCoordinatesSay)
{
    const Image image = drawn({card(squares(2, {red, green, blue, white}, 8))});
    expect_near(pixel(image, 32, 32), plain(red), 2);  // the upper left
    expect_near(pixel(image, 96, 32), plain(green), 2);
    expect_near(pixel(image, 32, 96), plain(blue), 2);
    expect_near(pixel(image, 96, 96), plain(white), 2);
}

TEST(TexturesDrawn, AreMultipliedWithTheMaterialsColour)
{
    const Vec3f half(0.5f, 0.25f, 1);
    const Image image = drawn({card(squares(1, {white}, 4), 1, 0, {}, half)});
    const float w = geometry::linear_from_srgb(230.f / 255);
    expect_near(pixel(image, 64, 64), pixel(drawn({card(nullptr, 1, 0, {}, w * half)}), 64, 64), 2);
}

TEST(TexturesDrawn, RepeatClampAndMirror)
{
    using Wrap = TextureUse::Wrap;
    const auto picture = squares(2, {red, green, red, green}, 8);
    const auto colours = [&](Wrap wrap) {
        TextureUse use;
        use.u = wrap;
        const Image image = drawn({card(picture, 2, 0, use)});
        return std::array{pixel(image, 16, 64), pixel(image, 48, 64), pixel(image, 80, 64),
                          pixel(image, 112, 64)};
    };
    const auto r = colours(Wrap::repeat), c = colours(Wrap::clamp), m = colours(Wrap::mirror);
    const auto expect = [&](const auto& seen, const std::array<Rgba, 4>& wanted) {
        for (std::size_t i = 0; i < 4; ++i) expect_near(seen[i], plain(wanted[i]), 2);
    };
    expect(r, {red, green, red, green});
    expect(c, {red, green, green, green});
    expect(m, {red, green, green, red});
}

TEST(TexturesDrawn, CutOutWhatIsNotThereAndBlendWhatIsHalfThere)
{
    TextureUse cut, blend;
    cut.alpha = TextureUse::Alpha::cutout;
    blend.alpha = TextureUse::Alpha::blended;
    const auto holes = squares(2, {red, nothing, nothing, red}, 8);
    const Image through = drawn({card(holes, 1, 0, cut)});
    expect_near(pixel(through, 32, 32), plain(red), 2);
    EXPECT_FALSE(covered(through, 96, 32)) << "a hole shows what is behind";
    EXPECT_TRUE(covered(drawn({card(holes)}), 96, 32)) << "alpha is ignored unless it is used";

    // Half of red over white: the mean of their light.
    Rgba half = red;
    half[3] = 128;
    const Image veil =
        drawn({card(squares(1, {half}, 8), 1, 0.1f, blend), card(squares(1, {white}, 4))});
    Vec3f mean = Vec3f::Zero();
    for (Eigen::Index k = 0; k < 3; ++k) {
        const auto at = std::size_t(k);
        mean[k] = 0.502f * geometry::linear_from_srgb(float(red[at]) / 255) +
                  0.498f * geometry::linear_from_srgb(float(white[at]) / 255);
    }
    expect_near(pixel(veil, 64, 64), pixel(drawn({card(nullptr, 1, 0, {}, mean)}), 64, 64), 3);
}

TEST(TexturesDrawn, HolesLetLightThrough)
{
    // A card lies over the floor; its left half is not there, and its shadow has none.
    TextureUse cut;
    cut.alpha = TextureUse::Alpha::cutout;
    const auto floor_at = [&](const TextureUse& use, int x) {
        render::Surface paper = card(squares(2, {nothing, red}, 8), 1, 0, use);
        auto mesh = std::make_shared<TriMesh>(*paper.mesh);
        for (Vec3f& p : mesh->positions) p = Vec3f(p.x(), 0.5f, p.y());
        for (Vec3f& n : mesh->normals) n = Vec3f::UnitY();
        paper.mesh = mesh;
        Scene scene;
        scene.surfaces = {paper};
        scene.ground = 0;
        render::Look look = plain_look();
        look.shadow = render::ShadowQuality::medium;
        look.light_elevation = 1.5;
        // From low ahead: row 68 shows the floor under the middle of the paper.
        const Image image = render::draw(scene, {{0, 0.25, 6}, {0, 0.1, 0}, {0, 1, 0}, 0.5}, look);
        return pixel(image, x, 68)[1];
    };
    EXPECT_LT(floor_at({}, 44), floor_at(cut, 44) - 40) << "the left half";
    EXPECT_NEAR(floor_at({}, 84), floor_at(cut, 84), 1) << "the right half";
}

TEST(TexturesDrawn, FromAfarAreTheMeanOfTheirLight)
{
    // 512 squares to a side of 128 pixels: black and white in equal parts are light of one half.
    const auto fine =
        squares(2, {{0, 0, 0, 255}, {255, 255, 255, 255}, {255, 255, 255, 255}, {0, 0, 0, 255}}, 1);
    const Image image = drawn({card(fine, 256)});
    const Vec3f half(0.5f, 0.5f, 0.5f);
    const auto wanted = pixel(drawn({card(nullptr, 1, 0, {}, half)}), 64, 64);
    for (const int at : {10, 40, 64, 101}) expect_near(pixel(image, at, at), wanted, 2);
}

TEST(TexturesDrawn, LeaveWhatHasNoneAsItIs)
{
    // A plain ball beside a textured card: the same bytes as beside a plain one.
    const auto ball = [] {
        TriMesh mesh = geometry::icosphere(0.4, 3);
        for (Vec3f& p : mesh.positions) p += Vec3f(0, 0, 1);
        return surface(std::move(mesh));
    };
    const Image a = drawn({ball(), card(squares(1, {red}, 4))}), b = drawn({ball(), card(nullptr)});
    for (int y = 55; y < 73; ++y) {
        for (int x = 55; x < 73; ++x) ASSERT_EQ(pixel(a, x, y), pixel(b, x, y)) << x << ' ' << y;
    }
}

// A plane with a normal map of one direction, lit from a side, looks as the same plane whose
// normals have that direction. One step of 14 bits of the first pass, and of a display's colour.
TEST(NormalMapsDrawn, ShadeAsATiltedPlaneDoes)
{
    const Rgba texel{172, 108, 238, 255};  // leans by 0.35 along u, and by 0.15 against v
    const Vec3f m = Vec3f(Vec3f(texel[0], texel[1], texel[2]) / 127.5f - Vec3f::Ones());
    render::Look look = plain_look();
    look.light_elevation = 0.5;
    const auto shaded = [&](const render::Surface& s, double from) {
        Scene scene;
        scene.surfaces = {s};
        look.light_azimuth = from > 0 ? 1.2 : 1.2 + std::numbers::pi;  // on the camera's side
        render::Camera camera = camera_ahead();
        camera.eye.z() = from;
        return pixel(render::draw(scene, camera, look), 64, 64);
    };
    // Coordinates that are turned, and mirrored; both sides; a strength.
    for (const auto& [turn, mirror, from, bump] : {std::array{0.0, 1.0, 10.0, 1.0},
                                                   {2.1, 1.0, 10.0, 1.0},
                                                   {0.7, -1.0, 10.0, 0.5},
                                                   {0.4, 1.0, -10.0, 1.0}}) {
        const Vec3f u(float(std::cos(turn)), float(std::sin(turn)), 0);
        const Vec3f v = float(mirror) * Vec3f(-u.y(), u.x(), 0);
        render::Surface mapped = card(nullptr), tilted = card(nullptr), plain = card(nullptr);
        TriMesh mesh = *mapped.mesh;
        auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
        topology->uvs.clear();
        for (const Vec3f& p : mesh.positions) topology->uvs.emplace_back(p.dot(u), p.dot(v));
        topology->materials[0].normal_map = squares(1, {texel}, 4);
        topology->materials[0].bump = float(bump);
        mesh.topology = topology;
        mapped.mesh = std::make_shared<const TriMesh>(mesh);
        TriMesh other = *tilted.mesh;
        const Vec3f n = float(bump) * (m.x() * u + m.y() * v) + m.z() * Vec3f::UnitZ();
        for (Vec3f& each : other.normals) each = n.normalized();
        tilted.mesh = std::make_shared<const TriMesh>(other);
        mapped.receives = tilted.receives = plain.receives = true;
        const auto a = shaded(mapped, from), b = shaded(tilted, from), flat = shaded(plain, from);
        expect_near(a, b, 1);
        EXPECT_GT(std::abs(a[0] - flat[0]), 10) << "the map matters";
    }
}

TEST(NormalMapsDrawn, SmallerLevelsAreTheMeanOfTheNumbers)
{
    const std::vector<std::uint8_t> rgba{0, 200, 255, 255, 255, 100, 255, 255};
    const auto levels = render::texture_levels(2, 1, rgba, 16, true);
    ASSERT_EQ(levels.size(), 2u);
    EXPECT_EQ(levels[1].rgba, (std::vector<std::uint8_t>{128, 150, 255, 255}));
}

TEST(TexturesDrawn, AreTheSameInThisProcessAndWhenTheyAreKept)
{
    render::Look look = plain_look();
    look.antialias = render::Antialias::samples4;
    const auto once = [&] {
        return drawn({card(squares(2, {red, green, blue, white}, 8)),
                      card(squares(1, {blue}, 4), 1, -1)},
                     look)
            .rgba;
    };
    const auto first = once(), kept = once();
    drawn({card(squares(1, {white}, 4))});  // the others are forgotten
    const auto sent_again = once();
    setenv("ASPIC_DRAW", "none", 1);
    const auto here = once();
    unsetenv("ASPIC_DRAW");
    EXPECT_TRUE(first == kept);
    EXPECT_TRUE(first == sent_again);
    EXPECT_TRUE(first == here);
}

TEST(TextureLevels, HalveToOneTexelAndKeepTheMeanOfTheLight)
{
    Picture picture{7, 5, {}};
    std::array<double, 3> mean{};
    for (std::size_t i = 0; i < 35; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            picture.rgba.push_back(std::uint8_t(40 + (i * 37 + k * 71) % 200));
            mean[k] += double(geometry::linear_from_srgb(float(picture.rgba.back()) / 255)) / 35;
        }
        picture.rgba.push_back(255);
    }
    const auto levels = render::texture_levels(7, 5, picture.rgba, 16);
    ASSERT_EQ(levels.size(), 3u);
    EXPECT_EQ(levels[1].width, 3);
    EXPECT_EQ(levels[1].height, 2);
    EXPECT_EQ(levels[2].width, 1);
    for (std::size_t k = 0; k < 3; ++k) {
        // A byte is rounded once a level, by half a step.
        const float wanted = 255 * geometry::srgb_from_linear(float(mean[k]));
        EXPECT_NEAR(levels[2].rgba[k], wanted, 1.01);
    }
    EXPECT_EQ(levels[2].rgba[3], 255);
    EXPECT_EQ(render::texture_levels(7, 5, picture.rgba, 4).front().width, 3);
}

TEST(TextureLevels, WhatIsNotThereTintsNothing)
{
    // Green beside transparent magenta.
    std::vector<std::uint8_t> rgba;
    for (int i = 0; i < 16; ++i) {
        const Rgba& c = i % 4 == 0 ? green : nothing;
        rgba.insert(rgba.end(), c.begin(), c.end());
    }
    const auto levels = render::texture_levels(4, 4, rgba, 16);
    const auto& last = levels.back().rgba;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(last[k], green[k], 1);
    EXPECT_NEAR(last[3], 255 / 4.0, 1);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(levels[0].rgba[4 + k], green[k], 1) << "rims";
}

TEST(SurfaceLayout, SplitsVerticesAtSeamsForDrawingAlone)
{
    // Every corner has its own coordinates: a texture makes as many drawn vertices, none without.
    TriMesh mesh = geometry::box({1, 1, 1}, {1, 1, 1});
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    topology->uvs.assign(36, {0, 0});
    topology->uv_triangles.clear();
    for (std::uint32_t f = 0; f < 12; ++f)
        topology->uv_triangles.push_back({3 * f, 3 * f + 1, 3 * f + 2});
    topology->materials = {{"paper"}};
    mesh.topology = std::make_shared<const geometry::MeshTopology>(*topology);
    EXPECT_EQ(render::surface_layout(mesh).position.size(), 24u);
    EXPECT_TRUE(render::surface_layout(mesh).uv.empty());
    topology->materials[0].texture = squares(1, {red}, 1);
    mesh.topology = topology;
    EXPECT_EQ(render::surface_layout(mesh).position.size(), 36u);
    EXPECT_EQ(mesh.positions.size(), 8u);
}

}  // namespace
