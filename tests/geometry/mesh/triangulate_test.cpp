#include "geometry/mesh/triangulate.hpp"

#include "geometry/base/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

namespace {

using namespace geometry;

std::vector<Triangle> cut(const std::vector<Vec3f>& polygon)
{
    std::vector<std::uint32_t> corner(polygon.size());
    std::iota(corner.begin(), corner.end(), 0u);
    std::vector<Triangle> out;
    triangulate(corner, polygon, out);
    return out;
}

// Sum of areas, each counted positive: equal to the polygon's own area only when no two triangles
// overlap.
double area(const std::vector<Vec3f>& p, const std::vector<Triangle>& triangles)
{
    double sum = 0;
    for (const auto& [a, b, c] : triangles) {
        sum += 0.5 * double((p[b] - p[a]).cross(p[c] - p[a]).norm());
    }
    return sum;
}

TEST(Triangulate, AnLIsCutInsideItsOutline)
{
    const std::vector<Vec3f> l{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
    EXPECT_EQ(cut(l).size(), 4u);
    EXPECT_NEAR(area(l, cut(l)), 3, 1e-6);
}

TEST(Triangulate, AnArrowheadQuadIsCutAtItsNotch)
{
    // The notch at corner 1 and, turned round, at every other corner.
    std::vector<Vec3f> arrow{{0, 0, 0}, {1, 0.25f, 0}, {2, 0, 0}, {1, 2, 0}};
    for (int turned = 0; turned < 4; ++turned) {
        EXPECT_NEAR(area(arrow, cut(arrow)), 1.75, 1e-6);
        std::rotate(arrow.begin(), arrow.begin() + 1, arrow.end());
    }
}

TEST(Triangulate, AConvexQuadIsCutAlongItsShorterDiagonal)
{
    const std::vector<Vec3f> quad{{0, 0, 0}, {1, 0.8f, 0}, {2, 0, 0}, {1, -0.8f, 0}};
    const auto triangles = cut(quad);
    for (const auto& t : triangles) {
        EXPECT_EQ(std::count(t.begin(), t.end(), 1u) + std::count(t.begin(), t.end(), 3u), 2);
    }
}

TEST(Triangulate, RandomStarsInRandomPlanesKeepTheirArea)
{
    const Random random(5);
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
        // A star-shaped polygon: radii at growing angles. Its area is a sum of triangles about the
        // centre, r_i r_j sin(step) / 2.
        const std::size_t n = 5 + random.bits(1000 * trial) % 40;
        const double step = 2 * std::numbers::pi / double(n);
        const Eigen::Quaterniond turn =
            Eigen::Quaterniond(random.unit(1000 * trial + 1) - 0.5, random.unit(1000 * trial + 2),
                               random.unit(1000 * trial + 3), random.unit(1000 * trial + 4))
                .normalized();
        std::vector<Vec3f> polygon;
        std::vector<double> radius;
        for (std::size_t i = 0; i < n; ++i) {
            radius.push_back(0.1 + random.unit(1000 * trial + 10 + i));
            const double a = step * double(i);
            polygon.push_back(
                (turn * Vec3(radius[i] * std::cos(a), radius[i] * std::sin(a), 0)).cast<float>());
        }
        double expected = 0;
        for (std::size_t i = 0; i < n; ++i) {
            expected += 0.5 * radius[i] * radius[(i + 1) % n] * std::sin(step);
        }
        const auto triangles = cut(polygon);
        EXPECT_EQ(triangles.size(), n - 2);
        EXPECT_NEAR(area(polygon, triangles), expected, 1e-5) << trial;
    }
}

TEST(Triangulate, WindingStays)
{
    const std::vector<Vec3f> l{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
    std::vector<Vec3f> back(l.rbegin(), l.rend());
    for (const auto& [a, b, c] : cut(l)) EXPECT_GT((l[b] - l[a]).cross(l[c] - l[a]).z(), 0);
    for (const auto& [a, b, c] : cut(back)) {
        EXPECT_LT((back[b] - back[a]).cross(back[c] - back[a]).z(), 0);
    }
}

TEST(Triangulate, WhatCannotBeCutBecomesAFan)
{
    const float bad = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}).size(), 3u);
    EXPECT_EQ(cut({{0, 0, 0}, {bad, 0, 0}, {1, 1, 0}, {0, 1, 0}}).size(), 2u);
    EXPECT_EQ(cut({{1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}}).size(), 2u);
    // A pentagram crosses itself.
    std::vector<Vec3f> star;
    for (int i = 0; i < 5; ++i) {
        star.emplace_back(float(std::cos(i * 2.513274)), float(std::sin(i * 2.513274)), 0.f);
    }
    EXPECT_EQ(cut(star).size(), 3u);
    EXPECT_TRUE(cut({{0, 0, 0}, {1, 0, 0}}).empty());
    std::vector<Triangle> out;
    triangulate(std::array<std::uint32_t, 4>{0, 1, 2, 99}, std::vector<Vec3f>(3, Vec3f::Zero()),
                out);
    EXPECT_EQ(out.size(), 2u);
}

TEST(Triangulate, ACircleOfManyCornersTakesLinearTime)
{
    std::vector<Vec3f> circle;
    for (int i = 0; i < 100'000; ++i) {
        const double a = 2 * std::numbers::pi * i / 100'000;
        circle.emplace_back(float(1000 * std::cos(a)), float(1000 * std::sin(a)), 0.f);
    }
    EXPECT_EQ(cut(circle).size(), 99'998u);
}

}  // namespace
