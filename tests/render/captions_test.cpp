#include "render/captions.hpp"

#include "render/text.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace {

using geometry::Vec3;
using render::Image;

Image black_picture(int width, int height)
{
    return {width, height, std::vector<std::uint8_t>(std::size_t(4 * width * height), 0)};
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
    render::draw_label(one, "HHH");
    render::draw_label(three, "HHH\nHHHHH\nH");
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
    render::draw_label(image, std::string(50, 'H'));
    const auto e = lit_extent(image);
    EXPECT_GT(e[1], 350);
    EXPECT_LT(e[1], 395);
    EXPECT_LT(e[3] - e[2], render::letter_height(400));
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
    Image high = black_picture(300, 540);
    render::draw_label(high, lines(20));
    EXPECT_NEAR(lit_extent(high)[2], 0.5 * 540 / 39.1, 3);

    Image low = black_picture(300, 100), lower = low;
    render::draw_label(low, lines(10));
    render::draw_label(lower, lines(11));
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
        render::draw_notes(image, camera, std::span(&note, 1));
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
    render::draw_notes(legend, camera, std::span(&note, 1), 0.45);
    EXPECT_LT(lit_extent(legend)[1], 480);
    // Whose tip is not seen says nothing.
    EXPECT_EQ(drawn({0, 9, 0}, {0, 5, 0})[0], -1);
    EXPECT_EQ(drawn({0, 0, 0}, {0, 0, 20})[0], -1);
}

}  // namespace
