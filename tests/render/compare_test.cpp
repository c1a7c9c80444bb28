#include "render/compare.hpp"

#include "render/colour.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace {

using render::CompareMode;
using render::Comparison;
using render::Image;
using Pixel = std::array<int, 3>;

Image filled(int width, int height, const Pixel& colour)
{
    Image image{width, height, {}};
    for (int i = 0; i < width * height; ++i) {
        for (const int c : colour) image.rgba.push_back(std::uint8_t(c));
        image.rgba.push_back(255);
    }
    return image;
}

Pixel at(const Image& image, int x, int y)
{
    const auto i = 4 * std::size_t(y * image.width + x);
    return {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]};
}

const Pixel red{200, 0, 0}, blue{0, 0, 180};

// At 60 rows the gap is 2 pixels: 0 to 79 are of the one, 80 and 81 white, 82 to 161 of the other.
TEST(Compare, SideBySideKeepsThePixelsOfBoth)
{
    const Image out = render::compare(filled(80, 60, red), filled(80, 60, blue), {});
    EXPECT_EQ(out.width, 162);
    EXPECT_EQ(out.height, 60);
    for (const int y : {0, 30, 59}) {
        for (int x = 0; x < 162; ++x) {
            const Pixel expected = x < 80 ? red : x < 82 ? Pixel{255, 255, 255} : blue;
            ASSERT_EQ(at(out, x, y), expected) << x << " " << y;
        }
    }
    for (std::size_t i = 3; i < out.rgba.size(); i += 4) ASSERT_EQ(out.rgba[i], 255);
}

TEST(Compare, AWipeShowsAPictureOnEachSideOfItsLine)
{
    const Image a = filled(80, 60, red), b = filled(80, 60, blue);
    const auto wiped = [&](double place) {
        return render::compare(a, b, {CompareMode::wipe, place, 1, "", ""});
    };
    const Image quarter = wiped(0.25);
    EXPECT_EQ(quarter.width, 80);
    for (int x = 0; x < 18; ++x) EXPECT_EQ(at(quarter, x, 30), red) << x;
    EXPECT_EQ(at(quarter, 19, 30), (Pixel{255, 255, 255}));
    EXPECT_EQ(at(quarter, 20, 30), (Pixel{255, 255, 255}));
    for (int x = 22; x < 80; ++x) EXPECT_EQ(at(quarter, x, 30), blue) << x;
    // At an end there is no line.
    EXPECT_EQ(wiped(0).rgba, b.rgba);
    EXPECT_EQ(wiped(1).rgba, a.rgba);
}

// A label lies on its own picture, and goes with it.
TEST(Compare, LabelsAreWipedWithTheirPictures)
{
    const Image a = filled(200, 60, red), b = filled(200, 60, blue);
    const auto wiped = [&](double place, const char* label_a, const char* label_b) {
        return render::compare(a, b, {CompareMode::wipe, place, 1, label_a, label_b});
    };
    EXPECT_EQ(wiped(0, "before", "").rgba, b.rgba);
    EXPECT_EQ(wiped(1, "", "after").rgba, a.rgba);
    EXPECT_NE(wiped(0, "", "after").rgba, b.rgba);
    EXPECT_NE(wiped(1, "before", "").rgba, a.rgba);
    // Each in its half: left of the middle of the one, right of that of the other.
    const Image both = wiped(0.5, "before", "after");
    bool left = false, right = false;
    for (int y = 0; y < 60; ++y) {
        for (int x = 0; x < 90; ++x) left = left || at(both, x, y) != red;
        for (int x = 110; x < 200; ++x) right = right || at(both, x, y) != blue;
    }
    EXPECT_TRUE(left && right);
}

// 51 of 255 levels are 20 %: with gain 4 the scale ends at 25 %, so that they lie at 0.8 of it,
// with gain 10 beyond its end. The channel that differs most counts.
TEST(Compare, DifferencesAreOfOneScale)
{
    const Image a = filled(80, 60, {100, 100, 100});
    Image b = filled(80, 60, {90, 151, 100});
    b.rgba[0] = b.rgba[1] = 100;  // a pixel that is alike
    const auto mapped = [](float t) {
        const auto c = render::colour_at(render::ColourMap::viridis, t);
        return Pixel{int(std::lround(255 * c[0])), int(std::lround(255 * c[1])),
                     int(std::lround(255 * c[2]))};
    };
    for (const double gain : {4.0, 10.0}) {
        const Image out = render::compare(a, b, {CompareMode::difference, 0.5, gain, "", ""});
        EXPECT_EQ(out.width, 80);
        EXPECT_EQ(at(out, 0, 0), mapped(0)) << gain;
        EXPECT_EQ(at(out, 2, 50), mapped(gain == 4 ? 0.8f : 1)) << gain;
        // From b to a it is as far as from a to b.
        EXPECT_EQ(render::compare(b, a, {CompareMode::difference, 0.5, gain, "", ""}).rgba,
                  out.rgba);
    }
}

TEST(Compare, PicturesOfDifferentSizesAreRefusedWithBoth)
{
    for (const auto mode :
         {CompareMode::side_by_side, CompareMode::wipe, CompareMode::difference}) {
        try {
            render::compare(filled(80, 60, red), filled(64, 48, red), {mode, 0.5, 1, "", ""});
            ADD_FAILURE() << "was taken";
        } catch (const std::invalid_argument& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("80 x 60"), std::string::npos) << text;
            EXPECT_NE(text.find("64 x 48"), std::string::npos) << text;
            EXPECT_NE(text.find("the same width and height"), std::string::npos) << text;
        }
    }
    EXPECT_THROW(render::compare({}, {}, {}), std::invalid_argument);
}

TEST(Compare, ASmallPictureWithLongLabelsIsNoTrouble)
{
    for (const auto mode :
         {CompareMode::side_by_side, CompareMode::wipe, CompareMode::difference}) {
        const Image dot = filled(1, 1, red);
        const Comparison how{mode, 0.5, 1, "a label that is too long", "another"};
        EXPECT_EQ(render::compare(dot, dot, how).height, 1);
    }
}

}  // namespace
