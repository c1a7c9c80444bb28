// Pictures as linear light, and as EXR files.

#include "pictures.hpp"
#include "render/exr.hpp"
#include "tests/render/decode_exr.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace {

using namespace tests;
using geometry::Vec3f;
using render::Image;
using render::Linear;
using render::Look;

constexpr float half_step = 1.f / 1024;  // the last digit of a half float: OpenGL may cut it off

// Its square roots are multiples of 1 / 255, in which the first pass keeps colours.
const Vec3f known(0.16f, 0.04f, 0.64f);

// The picture is 2 m high at z = 0.
const render::Camera ahead{{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.1)};

// A square 1 m wide in the plane z = 0, in one unlit colour.
render::Surface card()
{
    geometry::TriMesh mesh = geometry::grid(1, 1, 1, 1);
    for (Vec3f& p : mesh.positions) p = Vec3f(p.x(), -p.z(), 0);
    for (Vec3f& n : mesh.normals) n = Vec3f::UnitZ();
    render::Surface out = surface(std::move(mesh));
    out.paint.by = render::Paint::By::constant;
    out.paint.colour = known;
    out.receives = false;
    return out;
}

// A bright ball and a pane of glass on a floor.
render::Scene still()
{
    render::Scene scene;
    scene.surfaces = {surface(geometry::icosphere(0.5, 4)),
                      surface(geometry::box({0.2, 1, 1}, {1, 1, 1}))};
    scene.surfaces[0].paint.by = render::Paint::By::constant;
    scene.surfaces[0].paint.colour = {0.95f, 0.9f, 0.2f};
    scene.surfaces[1].opacity = 0.4f;
    scene.ground = -0.5;
    return scene;
}

std::array<float, 4> light_at(const Image& image, int x, int y)
{
    std::array<float, 4> light{};
    const std::size_t at = std::size_t(y) * std::size_t(image.width) + std::size_t(x);
    for (std::size_t c = 0; c < 4; ++c) light[c] = render::of_half(image.light[4 * at + c]);
    return light;
}

// Khronos PBR Neutral, as in shade.glsl.
Vec3f tone_mapped(Vec3f colour)
{
    const float least = colour.minCoeff(), start = 0.76f;
    colour.array() -= least < 0.08f ? least - 6.25f * least * least : 0.04f;
    const float peak = colour.maxCoeff();
    if (peak < start) return colour;
    const float room = 1 - start, top = 1 - room * room / (peak + room - start);
    colour *= top / peak;
    const float fades = 1 - 1 / (0.15f * (peak - top) + 1);
    return colour + fades * (Vec3f::Constant(top) - colour);
}

TEST(LinearLight, IsTheKnownColourBesideItsAlphaAndDepth)
{
    render::Scene scene;
    scene.surfaces = {card()};
    Look look = plain_look(64);
    look.linear = Linear::cut_out;
    const Image image = render::draw(scene, ahead, look);
    const Image read = tests::decode_exr(render::encode_exr(image));
    EXPECT_EQ(read.light, image.light);
    EXPECT_EQ(read.depth, image.depth);
    ASSERT_EQ(read.width, 64);
    const auto inside = light_at(read, 32, 32), beside = light_at(read, 4, 32);
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(inside[c], known[Eigen::Index(c)], half_step * known[Eigen::Index(c)]) << c;
    }
    EXPECT_EQ(inside[3], 1);
    EXPECT_EQ(beside, (std::array<float, 4>{0, 0, 0, 0}));
    // 24 bits of depth, of which the near plane's place takes some.
    EXPECT_NEAR(read.depth[32 * 64 + 32], 10, 1e-4);
    EXPECT_EQ(read.depth[32 * 64 + 4], render::nothing_there);
}

// The card ends at 0.5 m, 16 of 32 pixels from the middle; seen from half a pixel beside it, its
// edge halves a column of pixels, and with it their samples.
TEST(LinearLight, IsMultipliedByTheShareThatIsCovered)
{
    for (const auto antialias : {render::Antialias::samples4, render::Antialias::samples16}) {
        render::Scene scene;
        scene.surfaces = {card()};
        Look look = plain_look(64);
        look.antialias = antialias;
        look.linear = Linear::cut_out;
        render::Camera moved = ahead;
        moved.eye.x() = moved.target.x() = 0.5 / 32;  // half a pixel: edges halve theirs
        const Image image = render::draw(scene, moved, look);
        const auto edge = light_at(image, 15, 32);
        EXPECT_EQ(edge[3], 0.5f);
        for (std::size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(edge[c], 0.5f * known[Eigen::Index(c)], half_step * known[Eigen::Index(c)]);
        }
    }
}

// Where a pixel has one sample, the colour for the eye is that of its light. A level for its
// rounding and dither, and one for the fit of the curve and the half floats.
TEST(LinearLight, AgreesWithThePictureForTheEye)
{
    Look look = plain_look(96);
    look.style = render::Style::studio;
    look.soft = true;
    look.shadow = render::ShadowQuality::low;
    const Image plain = render::draw(still(), ahead, look);
    look.linear = Linear::whole;
    const Image image = render::draw(still(), ahead, look);
    EXPECT_EQ(image.rgba, plain.rgba);
    EXPECT_TRUE(plain.light.empty());
    int worst = 0;
    for (int y = 0; y < 96; ++y) {
        for (int x = 0; x < 96; ++x) {
            const auto light = light_at(image, x, y);
            EXPECT_EQ(light[3], 1);
            const Vec3f seen = tone_mapped({light[0], light[1], light[2]});
            const auto shown = pixel(image, x, y);
            for (int c = 0; c < 3; ++c) {
                const float level = 255 * render::srgb_from_linear(std::clamp(seen[c], 0.f, 1.f));
                worst = std::max(worst, std::abs(int(std::lround(level)) - shown[std::size_t(c)]));
            }
        }
    }
    EXPECT_LE(worst, 2);
}

// What is cut out, laid over the backdrop, is the whole: floor that fades, glass, edges and all.
TEST(LinearLight, CutOutAndLaidOverTheBackdropIsTheWhole)
{
    for (const bool glass : {false, true}) {
        render::Scene scene = still();
        if (!glass) scene.surfaces.pop_back();
        Look look = plain_look(96);
        look.antialias = render::Antialias::samples4;
        look.linear = Linear::whole;
        const Image whole = render::draw(scene, ahead, look);
        look.linear = Linear::cut_out;
        const Image cut = render::draw(scene, ahead, look);
        for (std::size_t i = 0; i < cut.depth.size(); ++i) {
            const bool there = cut.light[4 * i + 3] != 0;
            EXPECT_EQ(cut.depth[i], there ? whole.depth[i] : render::nothing_there) << i;
        }
        const Vec3f behind = look.backdrop_top;
        float worst = 0;
        for (int y = 0; y < 96; ++y) {
            for (int x = 0; x < 96; ++x) {
                const auto a = light_at(cut, x, y), b = light_at(whole, x, y);
                for (std::size_t c = 0; c < 3; ++c) {
                    const float laid = a[c] + (1 - a[3]) * behind[Eigen::Index(c)];
                    worst = std::max(worst, std::abs(laid - b[c]) / std::max(b[c], 0.05f));
                }
            }
        }
        EXPECT_LE(worst, 2 * half_step);
    }
}

// The floor fades into the horizon: from there on up, the picture has neither light nor depth of
// it.
TEST(LinearLight, HasNoDepthWhereTheFloorHasFadedAway)
{
    render::Scene scene;
    scene.surfaces = {card()};
    scene.ground = -0.5;
    Look look = plain_look(64);
    look.linear = Linear::cut_out;
    const render::Camera camera{{0, 1, 10}, {0, 1, 0}, {0, 1, 0}, 1};
    for (const auto antialias : {render::Antialias::none, render::Antialias::samples4}) {
        look.antialias = antialias;
        const Image image = render::draw(scene, camera, look);
        int faded = 0;
        for (int y = 32; y < 64; ++y) {
            const float alpha = light_at(image, 4, y)[3],
                        depth = image.depth[std::size_t(64 * y + 4)];
            EXPECT_EQ(alpha > 0, depth < render::nothing_there) << y;
            faded += alpha == 0 ? 1 : 0;
        }
        EXPECT_GT(faded, 1);
        EXPECT_LT(faded, 20);
    }
}

TEST(Exr, HalvesAreTheNearest)
{
    const std::vector<float> values{0, 1, -2, 65504, 1e9f, 2049, 2051};
    EXPECT_EQ(render::halves(values),
              (std::vector<std::uint16_t>{0, 0x3c00, 0xc000, 0x7bff, 0x7bff, 0x6800, 0x6802}));
    EXPECT_EQ(render::of_half(0x3555), 1365.f / 4096);
}

TEST(Exr, RefusesWhatHasNoLightAndWhatIsDamaged)
{
    Image image{2, 1, std::vector<std::uint8_t>(8, 255)};
    EXPECT_THROW(render::encode_exr(image), std::invalid_argument);
    image.light.assign(7, 0);
    EXPECT_THROW(render::encode_exr(image), std::invalid_argument);
    image.light.assign(8, 0x3c00);
    const std::string bytes = render::encode_exr(image);
    EXPECT_EQ(tests::decode_exr(bytes).light, image.light);
    EXPECT_THROW(tests::decode_exr(bytes.substr(0, bytes.size() - 3)), std::exception);
    EXPECT_THROW(tests::decode_exr("no EXR"), std::exception);
}

}  // namespace
