#include "render/smooth_edges.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

namespace {

using render::Image;

// A picture whose brightness and grey are value(x, y).
template <class Value> Image grey(int width, int height, const Value& value)
{
    Image image{width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto v = std::uint8_t(value(x, y));
            image.rgba.insert(image.rgba.end(), {v, v, v, v});
        }
    }
    return image;
}

int at(const Image& image, int x, int y)
{
    return image.rgba[std::size_t(4 * (y * image.width + x))];
}

TEST(SmoothEdges, ALeaningEdgeComesNearTheShareThatItCovers)
{
    // Below y = 20 + x / 6 all is 200, above 40: a pixel's grey should be its covered share.
    const auto line = [](double x) { return 20 + x / 6; };
    const auto covered = [&](int x, int y) {
        return std::clamp(y + 1 - line(x + 0.5), 0.0, 1.0);  // but for the ends of each stair
    };
    const Image stairs =
        grey(96, 64, [&](int x, int y) { return y + 0.5 > line(x + 0.5) ? 200 : 40; });
    Image smooth = stairs;
    render::smooth_edges(smooth);
    double error_before = 0, error_after = 0;
    for (int y = 0; y < 64; ++y) {
        for (int x = 16; x < 80; ++x) {
            const double right = 40 + 160 * covered(x, y);
            error_before += std::abs(at(stairs, x, y) - right);
            error_after += std::abs(at(smooth, x, y) - right);
        }
    }
    EXPECT_LT(error_after, 0.4 * error_before);
}

TEST(SmoothEdges, WhatHasNoEdgeStaysAsItIs)
{
    const Image even = grey(33, 17, [](int x, int y) { return 60 + x + 2 * y; });
    Image after = even;
    render::smooth_edges(after);
    EXPECT_EQ(after.rgba, even.rgba);
}

TEST(SmoothEdges, AStraightEdgeAlongPixelsStaysSharp)
{
    Image image = grey(40, 40, [](int x, int) { return x < 20 ? 30 : 220; });
    render::smooth_edges(image);
    // An edge without end has no stair: at most a twentieth is mixed in, for standing out.
    EXPECT_NEAR(at(image, 19, 20), 30, 190 / 20.0);
    EXPECT_NEAR(at(image, 20, 20), 220, 190 / 20.0);
    EXPECT_EQ(at(image, 18, 20), 30);
}

TEST(SmoothEdges, TurnedPicturesComeOutTurned)
{
    const auto disc = [](int x, int y) { return std::hypot(x - 30.2, y - 31.7) < 20 ? 210 : 50; };
    Image a = grey(64, 64, disc), b = grey(64, 64, [&](int x, int y) { return disc(y, x); });
    render::smooth_edges(a);
    render::smooth_edges(b);
    int worst = 0, different = 0;
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            worst = std::max(worst, std::abs(at(a, x, y) - at(b, y, x)));
            different += at(a, x, y) != at(b, y, x);
        }
    }
    // Rows win where rows and columns are equal: only on diagonals.
    EXPECT_LT(different, 24) << worst;
}

TEST(SmoothEdges, AnySizeAndAnyNumberOfThreads)
{
    for (const auto& [w, h] : {std::pair{0, 0}, {1, 1}, {1, 9}, {9, 1}, {2, 2}, {3, 50}}) {
        Image image = grey(w, h, [](int x, int y) { return (x * 97 + y * 61) % 256; });
        render::smooth_edges(image);
        EXPECT_EQ(image.rgba.size(), std::size_t(4 * w * h));
    }
    std::vector<std::vector<std::uint8_t>> all;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        Image image = grey(200, 150, [](int x, int y) { return (x * x + 7 * y * x) % 251; });
        render::smooth_edges(image);
        all.push_back(image.rgba);
    }
    EXPECT_EQ(all[0], all[1]);
    EXPECT_EQ(all[0], all[2]);
}

}  // namespace
