#include "render/legend.hpp"

#include "render/captions.hpp"
#include "render/text.hpp"

#include <gtest/gtest.h>

namespace {

using render::Image;

constexpr float no_value = std::numeric_limits<float>::quiet_NaN();

Image black(int width, int height)
{
    return {width, height, std::vector<std::uint8_t>(std::size_t(width * height * 4), 0)};
}

int lit(const Image& image)
{
    int sum = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) sum += image.rgba[i] > 128 ? 1 : 0;
    return sum;
}

TEST(Legend, TicksAreRoundAndInside)
{
    EXPECT_EQ(render::ticks(0, 1, 5),
              (std::vector<double>{0, 0.2, 0.4, 2 * 0.30000000000000004, 0.8, 1}));
    EXPECT_EQ(render::ticks(-30, 30, 5), (std::vector<double>{-20, 0, 20}));
    const auto t = render::ticks(3.2e6, 9.7e6, 4);
    EXPECT_EQ(t, (std::vector<double>{4e6, 6e6, 8e6}));
    EXPECT_GE(render::ticks(0.1, 0.9, 1).size(), 1u);
    EXPECT_TRUE(render::ticks(1, 1, 5).empty());
    EXPECT_TRUE(render::ticks(0, double(no_value), 5).empty());
    EXPECT_TRUE(render::ticks(0, std::numeric_limits<double>::infinity(), 5).empty());
    EXPECT_TRUE(render::ticks(1, 1 + 1e-15, 5).empty());
}

TEST(Legend, TickTextsTellNeighboursApart)
{
    EXPECT_EQ(render::tick_text(0, 0.1), "0");
    EXPECT_EQ(render::tick_text(0.4, 0.2), "0.4");
    EXPECT_EQ(render::tick_text(0.05, 0.01), "0.05");
    EXPECT_EQ(render::tick_text(-20, 20), "-20");
    EXPECT_EQ(render::tick_text(4e6, 2e6), "4e+06");
    EXPECT_EQ(render::tick_text(1.2e6, 2e5), "1.2e+06");
    EXPECT_EQ(render::tick_text(0.0004, 0.0002), "4e-04");
    EXPECT_EQ(render::tick_text(2.5, 2.5), "2.5");
    EXPECT_EQ(render::tick_text(5, 2.5), "5.0");
    EXPECT_EQ(render::tick_text(75, 25), "75");
    EXPECT_EQ(render::tick_text(-0.25, 0.25), "-0.25");
    EXPECT_EQ(render::tick_text(7.5e6, 2.5e6), "7.5e+06");
}

TEST(Legend, TickTextsOfAScaleHaveOneForm)
{
    using Texts = std::vector<std::string>;
    EXPECT_EQ(render::tick_texts({0, 0.0005, 0.001, 0.0015, 0.002}),
              (Texts{"0", "0.0005", "0.0010", "0.0015", "0.0020"}));
    EXPECT_EQ(render::tick_texts({5e4, 1e5, 1.5e5, 2e5}),
              (Texts{"5.0e+04", "1.0e+05", "1.5e+05", "2.0e+05"}));
    EXPECT_EQ(render::tick_texts({-2e5, -1e5, 0, 1e5}), (Texts{"-2e+05", "-1e+05", "0", "1e+05"}));
    EXPECT_EQ(render::tick_texts({2e-4, 4e-4}), (Texts{"2e-04", "4e-04"}));
    EXPECT_EQ(render::tick_texts({5}), (Texts{"5"}));
}

TEST(Legend, RangesAreRoundAndHoldAllThatIsFinite)
{
    using Range = std::array<float, 2>;
    EXPECT_EQ(render::round_range({0.1f, 3.7f}), (Range{0, 5}));
    EXPECT_EQ(render::round_range({-0.013f, 0.002f}), (Range{-0.02f, 0.002f}));
    EXPECT_EQ(render::round_range({-0.013f, 0.002f}, true), (Range{-0.02f, 0.02f}));
    EXPECT_EQ(render::round_range({-3.7f, -0.1f}), (Range{-5, 0}));
    EXPECT_EQ(render::round_range({1.0f, no_value, std::numeric_limits<float>::infinity()}),
              (Range{0, 1}));
    EXPECT_EQ(render::round_range({}), (Range{0, 1}));
    EXPECT_EQ(render::round_range({0, no_value}), (Range{0, 1}));
    EXPECT_TRUE(std::isfinite(render::round_range({3.3e38f})[1]));
}

// 10 K at 300 K: a quarter of them is 2.5, rounded up to 5. Where the least is up to 0.3 of the
// greatest, as stress and displacement are, the range starts at 0; so it does where all are alike.
TEST(Legend, RangesFarFrom0DoNotHoldIt)
{
    using Range = std::array<float, 2>;
    EXPECT_EQ(render::round_range({295, 305, 301}), (Range{295, 305}));
    EXPECT_EQ(render::round_range({296.2f, 304}), (Range{296, 304}));
    EXPECT_EQ(render::round_range({-305, -295}), (Range{-305, -295}));
    EXPECT_EQ(render::round_range({295, 305}, true), (Range{295, 305}));
    EXPECT_EQ(render::round_range({1, 3.4f}), (Range{0, 5}));
    EXPECT_EQ(render::round_range({300, 300}), (Range{0, 500}));
    EXPECT_EQ(render::round_range({300, 300.0001f}), (Range{0, 500}));
    EXPECT_EQ(render::round_range({-300, -300}), (Range{-500, 0}));
}

TEST(Legend, DustBeyond0DoesNotWidenARange)
{
    using Range = std::array<float, 2>;
    EXPECT_EQ(render::round_range({-1e-7f, 2}), (Range{0, 2}));
    EXPECT_EQ(render::round_range({-1e-7f, 2}, true), (Range{0, 2}));
    EXPECT_EQ(render::round_range({-1000, 0.3f}), (Range{-1000, 0}));
    EXPECT_EQ(render::round_range({-3, 1000}), (Range{-5, 1000}));
    EXPECT_EQ(render::round_range({0, 0.2f}), (Range{0, 0.2f}));
}

// Of 0 to 999 and two wild values, 2 % at each end are 20: what is left runs from 19 to 980.
TEST(Legend, APercentileLeavesOutTheExtremes)
{
    std::vector<float> values{-1e9f, 1e12f, no_value, std::numeric_limits<float>::infinity()};
    for (int i = 0; i < 1000; ++i) values.push_back(float(i * 7919 % 1000));
    using Range = std::array<float, 2>;
    const auto clipped = render::percentile_range(values, 0.02);
    EXPECT_EQ(clipped.ends, (Range{19, 980}));
    EXPECT_TRUE(clipped.clips);
    EXPECT_EQ(render::percentile_range({5, 6, 7, 8, 9}, 0).ends, (Range{5, 9}));
    EXPECT_FALSE(render::percentile_range({5, 6, 7, 8, 9}, 0).clips);
    EXPECT_EQ(render::percentile_range({5, 6, 7, 8, 9}, 0.25).ends, (Range{6, 8}));
    // Its ends are not rounded.
    EXPECT_EQ(render::percentile_range({-30, -20, 40}, 0).ends, (Range{-30, 40}));
    // Without a length there is nothing to clip.
    EXPECT_EQ(render::percentile_range({3, 3, 3}, 0.02).ends, render::round_range({3}));
    EXPECT_EQ(render::percentile_range({no_value}, 0.02).ends, (Range{0, 1}));
    EXPECT_EQ(render::percentile_range({}, 0.02).ends, (Range{0, 1}));
    EXPECT_FALSE(render::percentile_range({3, 3, 3}, 0.02).clips);
}

// Of 1000 values ten differ, fewer than 2 %: all are held.
TEST(Legend, APercentileHoldsTheFewThatDiffer)
{
    std::vector<float> values(1000, 4.0f);
    for (std::size_t i = 0; i < 10; ++i) values[i] = 5 + float(i);
    using Range = std::array<float, 2>;
    const auto held = render::percentile_range(values, 0.02);
    EXPECT_EQ(held.ends, (Range{4, 14}));
    EXPECT_FALSE(held.clips);
}

TEST(Legend, APercentileOfImmenseValuesHasALengthThatFloatsHold)
{
    constexpr float most = std::numeric_limits<float>::max();
    const auto range = render::percentile_range({-most, 0, most}, 0.02);
    EXPECT_TRUE(std::isfinite(range.ends[1] - range.ends[0]));
}

// A tile of a sheet of four columns has 390 of 960 columns: letters of 6 pixels are read there.
TEST(Legend, LettersGrowWithThePictureAndAreReadOnAContactSheet)
{
    EXPECT_GE(render::letter_height(960, 540) * 390 / 960, 6);
    EXPECT_EQ(render::letter_height(1920, 1080), 2 * render::letter_height(960, 540));
    EXPECT_GE(render::letter_height(1, 1), 8);
    EXPECT_EQ(render::letter_height(400, 800), 10);  // a fortieth of the width of a narrow one
}

// Below the scale: 2.4 letters of 16 pixels.
TEST(Legend, SaysWhatItLeavesOut)
{
    Image image = black(960, 540);
    const auto lit_below = [&] {
        int sum = 0;
        for (int y = 135 + 243 + 16; y < 135 + 243 + 48; ++y) {
            for (int x = 0; x < 960; ++x) {
                sum += image.rgba[std::size_t(4 * (y * 960 + x))] > 128 ? 1 : 0;
            }
        }
        return sum;
    };
    render::draw_legend(image, {"stress", "Pa", {}});
    EXPECT_EQ(lit_below(), 0);
    render::draw_legend(image, {"stress", "Pa", {}, "2 to 98 %"});
    EXPECT_GT(lit_below(), 100);
}

// The scale takes 45 % of the height from 25 % on, and is 1.4 letters wide: at 540 rows a letter
// has 16 pixels, and 7 of them are free on the right. Its lowest row has the map's first colour,
// its highest the last.
TEST(Legend, ShowsItsScaleBesideItsNumbers)
{
    Image image = black(960, 540);
    render::draw_legend(image, {"stress", "Pa", {render::ColourMap::viridis, 0, 1}});
    const auto at = [&](int x, int y) { return &image.rgba[std::size_t(4 * (y * 960 + x))]; };
    const int x = 960 - 112 - 11, top = 135, bottom = 135 + 243 - 1;
    EXPECT_NEAR(at(x, bottom)[0], 0.267 * 255, 2);
    EXPECT_NEAR(at(x, bottom)[2], 0.329 * 255, 2);
    EXPECT_NEAR(at(x, top)[0], 0.993 * 255, 2);
    EXPECT_NEAR(at(x, top)[2], 0.144 * 255, 2);
    // A tick stands right of the scale at every fifth of it.
    for (const double t : {0.0, 0.2, 0.4, 0.6, 0.8}) {
        EXPECT_EQ(at(960 - 112 + 2, int(135 + (1 - t) * 243))[0], 255) << t;
    }
}

TEST(Legend, ASmallPictureIsNoTrouble)
{
    for (const int size : {1, 2, 7, 30}) {
        Image image = black(size, size);
        render::draw_legend(image, {"a long title", "m", {}});
        render::draw_texts(image, render::place_label("and a long label", size, size));
    }
    EXPECT_EQ(render::width_of({"a long title", "m", {}}, 30, 30), 0);
}

TEST(Legend, LiesWithinTheWidthThatItSays)
{
    for (const char* title : {"a", "a title that is rather long"}) {
        Image image = black(640, 480);
        const render::Legend legend{title, "m", {}};
        render::draw_legend(image, legend);
        const double width = render::width_of(legend, 640, 480);
        EXPECT_GT(width, 0.1);
        EXPECT_LT(width, 0.45);
        for (int y = 0; y < 480; ++y) {
            for (int x = 0; x < int((1 - width) * 640); ++x) {
                const auto* const p = &image.rgba[4 * std::size_t(640 * y + x)];
                ASSERT_EQ(p[0] + p[1] + p[2], 0) << x << " " << y;
            }
        }
    }
}

TEST(Text, IsAsWideAsItSaysAndGrowsWithItsHeight)
{
    for (const float height : {8.0f, 24.0f}) {
        Image image = black(400, 60);
        render::TextStyle style;
        style.height = height;
        style.halo_opacity = 0;
        render::draw_text(image, "HxH", {20, 45}, style);
        int left = 400, right = 0, top = 60, bottom = 0;
        for (int y = 0; y < 60; ++y) {
            for (int x = 0; x < 400; ++x) {
                if (image.rgba[std::size_t(4 * (y * 400 + x))] < 100) continue;
                left = std::min(left, x), right = std::max(right, x);
                top = std::min(top, y), bottom = std::max(bottom, y);
            }
        }
        // A stroke reaches half its width beyond its line: a pixel or 7.5 % of the height.
        const float stroke = std::max(1.1f, 0.15f * height);
        EXPECT_NEAR(right - left + 1, render::text_width("HxH", height) + stroke, 1.5);
        EXPECT_NEAR(bottom - top + 1, height + stroke, 1.5);
        EXPECT_NEAR(left, 20 - stroke / 2, 1);
    }
}

TEST(Text, EveryPrintableCharacterButTheSpaceShows)
{
    for (char c = 32; c < 127; ++c) {
        Image image = black(40, 40);
        render::TextStyle style;
        style.height = 16;
        style.halo_opacity = 0;
        render::draw_text(image, std::string(1, c), {10, 28}, style);
        if (c == ' ') {
            EXPECT_EQ(lit(image), 0);
        } else {
            EXPECT_GT(lit(image), 2) << c;
        }
    }
}

TEST(Text, StaysInsideThePicture)
{
    Image image = black(20, 20);
    render::draw_text(image, "far \x01\xff out", {-30, 5}, {});
    render::draw_text(image, "below", {5, 1000}, {});
    render::draw_text(image, "", {5, 5}, {});
}

}  // namespace
