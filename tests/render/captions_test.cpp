#include "render/captions.hpp"

#include "render/legend.hpp"
#include "render/text.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace {

using geometry::Vec3;
using render::Image;

Image black_picture(int width, int height)
{
    return {width, height, std::vector<std::uint8_t>(std::size_t(4 * width * height), 0)};
}

void draw_label(Image& image, const std::string& label)
{
    render::draw_texts(image, render::place_label(label, image.width, image.height));
}

// Of pixels that are lit: columns left and right, rows top and bottom. All -1: there are none.
std::array<int, 4> lit_extent(const Image& image)
{
    std::array<int, 4> e{-1, -1, -1, -1};
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            if (image.rgba[std::size_t(4 * (y * image.width + x))] < 128) continue;
            e = {e[0] < 0 ? x : std::min(e[0], x), std::max(e[1], x), e[2] < 0 ? y : e[2], y};
        }
    }
    return e;
}

// UTF-8, of two bytes.
std::string two_bytes(char32_t code)
{
    return {static_cast<char>(0xc0 | (code >> 6)), static_cast<char>(0x80 | (code & 0x3f))};
}

TEST(Captions, LettersOfLatinAndGreekAreDrawnAndOthersAreOneBoxEach)
{
    for (char32_t code = 0xa0; code < 0x180; ++code) {
        EXPECT_EQ(render::without_glyphs(two_bytes(code)), "") << two_bytes(code);
    }
    for (char32_t code = 0x384; code < 0x3cf; ++code) {
        const bool none = code == 0x38b || code == 0x38d || code == 0x3a2;
        EXPECT_EQ(render::without_glyphs(two_bytes(code)).empty(), !none) << two_bytes(code);
    }
    EXPECT_EQ(render::without_glyphs("Größe 漢字 漢\n\xff"), "漢字\xff");
    const auto width = [](const char* text) { return render::text_width(text, 10); };
    EXPECT_EQ(width("äöü"), width("aou"));
    EXPECT_EQ(width("漢"), width("\xff"));
    EXPECT_EQ(width("\xe6\xbc"), width("\xff\xff")) << "each byte that begins no letter";
    EXPECT_EQ(width("\xc0\x80"), width("\xff\xff")) << "longer than need be";
}

TEST(Captions, MarksStandAboveTheirLetters)
{
    const auto top = [](const char* text) {
        Image image = black_picture(60, 60);
        render::draw_text(image, text, {20, 40}, {16, {1, 1, 1}, {0, 0, 0}, 0});
        return lit_extent(image)[2];
    };
    // Pixels, two a glyph unit: an accent is four units above a small letter, three above a
    // capital.
    EXPECT_NEAR(top("e") - top("\u00e9"), 6, 1.01);
    EXPECT_NEAR(top("E") - top("\u00c9"), 6, 1.01);
    EXPECT_EQ(top("c"), top("\u00e7"));
}

TEST(Captions, ALineIsCutBetweenLetters)
{
    const std::string cut = render::cut_to("äääääääääää", 10, 40);
    ASSERT_GT(cut.size(), 5u);
    EXPECT_EQ(render::without_glyphs(cut), "") << cut;
    EXPECT_EQ(cut.substr(cut.size() - 3), "...");
}

TEST(Captions, QuantitiesHaveThreeDigitsAndTheUsualPrefix)
{
    EXPECT_EQ(render::quantity_text(120, "N"), "120 N");
    EXPECT_EQ(render::quantity_text(160000, "N"), "160 kN");
    EXPECT_EQ(render::quantity_text(-3.21e6, "Pa"), "-3.21 MPa");
    EXPECT_EQ(render::quantity_text(0.0042, "N"), "4.2 mN");
    EXPECT_EQ(render::quantity_text(0.522, "N"), "0.522 N");
    EXPECT_EQ(render::quantity_text(0, "N"), "0 N");
    EXPECT_EQ(render::quantity_text(999.7, "N"), "1 kN");
    EXPECT_EQ(render::quantity_text(999.4, "N"), "999 N");
    EXPECT_EQ(render::quantity_text(0.0208, "m"), "0.0208 m");
    EXPECT_EQ(render::quantity_text(9.81, "m/s^2"), "9.81 m/s^2");
    EXPECT_EQ(render::quantity_text(12, ""), "12");
    EXPECT_EQ(render::quantity_text(1500, "m"), "1500 m");
    EXPECT_EQ(render::quantity_text(-7850, "kg/m^3"), "-7850 kg/m^3");
    EXPECT_EQ(render::quantity_text(12345, ""), "12345");
    EXPECT_EQ(render::quantity_text(0.0123, ""), "0.0123");
    EXPECT_EQ(render::quantity_text(99.97, ""), "100");
    EXPECT_EQ(render::quantity_text(2.5e6, ""), "2.5e+06");
    EXPECT_EQ(render::quantity_text(std::numeric_limits<double>::infinity(), "N"), "inf N");
}

// At 540 rows a letter has 16 pixels, a line 1.9 of them, and the last stands 1.6 above the edge.
TEST(Captions, ALabelStacksItsLinesAboveTheLowerLeftCorner)
{
    Image one = black_picture(960, 540), three = one;
    draw_label(one, "HHH");
    draw_label(three, "HHH\nHHHHH\nH");
    const auto a = lit_extent(one), b = lit_extent(three);
    EXPECT_NEAR(a[0], 1.6 * 16, 2);
    EXPECT_NEAR(a[3], 540 - 1.6 * 16, 2);
    EXPECT_EQ(b[0], a[0]);
    EXPECT_EQ(b[3], a[3]);
    EXPECT_NEAR(a[2] - b[2], 2 * 1.9 * 16, 2);
    EXPECT_GT(b[1], a[1]);
}

TEST(Captions, ALongLabelIsDrawnSmaller)
{
    Image image = black_picture(400, 400);
    draw_label(image, std::string(50, 'H'));
    const auto e = lit_extent(image);
    EXPECT_GT(e[1], 350);
    EXPECT_LT(e[1], 395);
    EXPECT_LT(e[3] - e[2], render::letter_height(400, 400));
}

// Twenty lines of 16 pixels need 16 * (1.1 + 1.9 * 20) = 626 rows. In 540 they are smaller; in 100,
// where letters of 7 pixels leave room for 6, the last says how many are left out.
TEST(Captions, ManyLinesAreDrawnSmallerAndThoseWithoutRoomAreCounted)
{
    const auto lines = [](int count) {
        std::string text = "HHH";
        for (int i = 1; i < count; ++i) text += "\nHHH";
        return text;
    };
    Image high = black_picture(900, 540);
    draw_label(high, lines(20));
    EXPECT_NEAR(lit_extent(high)[2], 0.5 * 540 / 39.1, 3);

    Image low = black_picture(300, 100), lower = low;
    draw_label(low, lines(10));
    draw_label(lower, lines(11));
    EXPECT_NEAR(lit_extent(low)[2], 100 - 7 * (1.6 + 1.9 * 5 + 1), 2);
    EXPECT_NE(low.rgba, lower.rgba);
}

// A camera at (0, 0, 10) that sees 2 * 10 * tan(45 / 2) = 8.28 m of height at the origin.
render::Camera straight_camera()
{
    render::Camera camera;
    camera.eye = {0, 0, 10};
    camera.field_of_view = std::numbers::pi / 4;
    return camera;
}

TEST(Captions, PlacesInThePictureAreThoseOfAPinhole)
{
    const render::Camera camera = straight_camera();
    const double height = 20 * std::tan(std::numbers::pi / 8);
    const auto middle = render::place_in_picture(camera, {0, 0, 0}, 2);
    ASSERT_TRUE(middle);
    EXPECT_LT((*middle - Vec3(0.5, 0.5, 1 / height)).norm(), 1e-12);
    const auto corner = render::place_in_picture(camera, {height, 0.5 * height, 0}, 2);
    ASSERT_TRUE(corner);
    EXPECT_LT((*corner - Vec3(1, 0, 1 / height)).norm(), 1e-12);
    // Half as far away it is twice as large.
    EXPECT_NEAR(render::place_in_picture(camera, {0, 0, 5}, 2)->z(), 2 / height, 1e-12);
    EXPECT_FALSE(render::place_in_picture(camera, {0, 0, 10}, 2));
    EXPECT_FALSE(render::place_in_picture(camera, {0, 0, 11}, 2));
}

// An arrow that points down at the middle has its number on the right of the tip, as far as its
// head is wide and most of a letter; one that points to the right has it above.
TEST(Captions, NotesStandBesideTheTipsOfTheirArrows)
{
    const render::Camera camera = straight_camera();
    const double metre = 540 / (20 * std::tan(std::numbers::pi / 8));  // pixels
    const auto drawn = [&](const Vec3& from, const Vec3& tip) {
        Image image = black_picture(960, 540);
        const render::Note note{from, tip, 0.5, "120 N"};
        render::draw_texts(image, render::place_notes(camera, std::span(&note, 1), 960, 540));
        return lit_extent(image);
    };
    const auto down = drawn({0, 2, 0}, {0, 0, 0});
    EXPECT_NEAR(down[0], 480 + 0.5 * metre + 0.8 * 16, 4);
    EXPECT_NEAR((down[2] + down[3]) / 2.0, 270, 3);
    const auto right = drawn({-2, 0, 0}, {0, 0, 0});
    EXPECT_NEAR((right[0] + right[1]) / 2.0, 480, 4);
    EXPECT_NEAR(right[3], 270 - 0.5 * metre - 0.8 * 16, 3);
    // At the right edge there is no room: on the left.
    EXPECT_LT(drawn({6, 2, 0}, {6, 0, 0})[1], int(480 + 5.5 * metre));
    // Nor is there where a legend stands.
    Image legend = black_picture(960, 540);
    const render::Note note{{0, 2, 0}, {0, 0, 0}, 0.5, "120 N"};
    render::draw_texts(legend, render::place_notes(camera, std::span(&note, 1), 960, 540, 0.45));
    EXPECT_LT(lit_extent(legend)[1], 480);
    // Whose tip is not seen says nothing.
    EXPECT_EQ(drawn({0, 9, 0}, {0, 5, 0})[0], -1);
    EXPECT_EQ(drawn({0, 0, 0}, {0, 0, 20})[0], -1);
}

// A scene with all that is written into pictures: a scale, lines of a label, numbers of forces.
render::Scene told_scene(const std::string& title, const std::string& label, int notes)
{
    render::Scene scene;
    scene.legend = {title, "MPa", {render::ColourMap::viridis, -1.2e6f, 3.4e6f}, "2 to 98 %"};
    scene.label = label;
    for (int i = 0; i < notes; ++i) {
        const Vec3 tip(0.4 * i - 2, 0.05 * i - 2.5, 0);
        scene.notes.push_back({tip + Vec3(0, 1, 0), tip, 0.1, "160 kN"});
    }
    return scene;
}

// Pixels that letters or the scale brighten or colour, of one part at a time.
std::vector<bool> drawn(render::Scene scene, int part, int width, int height)
{
    Image image = black_picture(width, height);
    if (part == 0) render::draw_legend(image, *scene.legend);
    std::vector<render::Area> taken = render::areas_of(*scene.legend, width, height);
    const auto label = render::place_label(scene.label, width, height, taken);
    if (part == 1) render::draw_texts(image, label);
    for (const auto& line : label) taken.push_back(render::area_of(line));
    const double right = render::width_of(*scene.legend, width, height);
    const auto notes =
        render::place_notes(straight_camera(), scene.notes, width, height, right, taken);
    if (part >= 2 && std::size_t(part - 2) < notes.size()) {
        render::draw_texts(image, std::span(&notes[std::size_t(part - 2)], 1));
    }
    std::vector<bool> out;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        out.push_back(std::max({image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]}) > 60);
    }
    return out;
}

TEST(Captions, NothingLiesOnAnythingElseInAPictureOfAnySize)
{
    const std::array<std::array<int, 2>, 6> sizes{
        {{160, 90}, {90, 160}, {240, 135}, {320, 180}, {480, 270}, {960, 540}}};
    for (const auto& [width, height] : sizes) {
        for (const char* title : {"stress", "largest von Mises stress of the last frame"}) {
            for (const char* label :
                 {"a bridge in a storm\nframe 60   2.46 s   slow motion 12.5x\ntip   0.0208 m",
                  "1\n2\n3\n4\n5 of many lines that are rather long as well\n6\n7\n8\n9"}) {
                const render::Scene scene = told_scene(title, label, 6);
                std::vector<int> by(std::size_t(width * height), -1);
                for (int part = 0; part < 8; ++part) {
                    const auto lit = drawn(scene, part, width, height);
                    EXPECT_TRUE(part > 1 || std::count(lit.begin(), lit.end(), true) > 20);
                    int twice = 0;
                    for (std::size_t i = 0; i < by.size(); ++i) {
                        if (lit[i] && by[i] >= 0) ++twice;
                        if (lit[i]) by[i] = part;
                    }
                    EXPECT_EQ(twice, 0) << part << " at " << width << " x " << height << title;
                }
            }
        }
    }
}

// At 160 x 90 a line beside the note of the scale has 160 - 11 pixels less what is on the right.
TEST(Captions, AWideLineBesideTheScaleIsCutAndSaysSo)
{
    const render::Scene scene = told_scene("stress", "", 0);
    const auto taken = render::areas_of(*scene.legend, 160, 90);
    const std::string text = "the bridge of the second storm";
    const auto cut = render::place_label(text, 160, 90, taken);
    ASSERT_EQ(cut.size(), 1u);
    EXPECT_TRUE(cut[0].text.ends_with("...")) << cut[0].text;
    EXPECT_EQ(cut[0].height, render::least_letter);
    EXPECT_EQ(render::place_label(text, 960, 540, taken)[0].text, text);
    EXPECT_EQ(render::cut_to("abc", 7, 1), "");
}

}  // namespace
