#include "graph/document/curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace {

using graph::Curve;
using graph::curve_through;

constexpr Curve::Between all_between[] = {Curve::Between::monotone, Curve::Between::smooth,
                                          Curve::Between::linear, Curve::Between::step};

TEST(Curve, GoesThroughItsKeysAndHoldsBeyond)
{
    for (const auto between : all_between) {
        const Curve c = curve_through({1, 3, 4, 10}, {0, 2, -1, 5}, between);
        EXPECT_EQ(c.at(1), 0);
        EXPECT_EQ(c.at(3), 2);
        EXPECT_EQ(c.at(4), -1);
        EXPECT_EQ(c.at(10), 5);
        EXPECT_EQ(c.at(-100), 0);
        EXPECT_EQ(c.at(100), 5);
        EXPECT_EQ(c.at(-INFINITY), 0);
        EXPECT_EQ(c.at(INFINITY), 5);
        EXPECT_EQ(c.at(NAN), 0);
    }
}

TEST(Curve, NeverLeavesTheRangeOfTheTwoKeysAroundIt)
{
    std::mt19937 random(7);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (int round = 0; round < 200; ++round) {
        std::vector<double> t, y;
        double now = 0;
        for (int i = 0; i < 6; ++i) {
            t.push_back(now += 0.01 + unit() * unit() * 10);
            y.push_back(i > 0 && unit() < 0.2 ? y.back() : unit() * 10 - 5);
        }
        for (const auto between : all_between) {
            const Curve c = curve_through(t, y, between);
            for (std::size_t i = 0; i + 1 < t.size(); ++i) {
                const double low = std::min(y[i], y[i + 1]), high = std::max(y[i], y[i + 1]);
                double before = y[i];
                for (double u = 0; u < 1; u += 0.05) {
                    const double x = c.at(t[i] + u * (t[i + 1] - t[i]));
                    EXPECT_GE(x, low);
                    EXPECT_LE(x, high);
                    // Monotone between two keys, but for rounding of numbers up to 5.
                    EXPECT_GE((x - before) * (y[i + 1] - y[i]), -1e-13);
                    before = x;
                }
            }
        }
    }
}

TEST(Curve, OfAStraightLineIsThatLine)
{
    for (const auto between : {Curve::Between::monotone, Curve::Between::linear}) {
        const Curve c = curve_through({0, 1, 5, 6}, {1, 3, 11, 13}, between);
        for (double t = 0; t <= 6; t += 0.25) EXPECT_NEAR(c.at(t), 1 + 2 * t, 1e-14);
    }
}

TEST(Curve, MonotoneMatchesSteffensSlopes)
{
    // Keys (0,0) (1,1) (3,2): s = 1, 1/2; p = (1*2 + 0.5*1) / 3 = 5/6; y' = 2 min(1, .5, 5/12).
    const Curve c = curve_through({0, 1, 3}, {0, 1, 2});
    EXPECT_NEAR(c.slopes[1], 5.0 / 6, 1e-15);
    // End: p = s0 (1 + h0/(h0+h1)) - s1 h0/(h0+h1) = 4/3 - 1/6 = 7/6, below 2 s0.
    EXPECT_NEAR(c.slopes[0], 7.0 / 6, 1e-15);
    // Its slope is continuous at the middle key.
    EXPECT_NEAR((c.at(1 + 1e-6) - c.at(1)) / 1e-6, 5.0 / 6, 1e-5);
    EXPECT_NEAR((c.at(1) - c.at(1 - 1e-6)) / 1e-6, 5.0 / 6, 1e-5);
}

TEST(Curve, AKeyMovesNothingBeyondTheSecondKeyToEitherSide)
{
    const Curve a = curve_through({0, 1, 2, 3, 4, 5, 6}, {0, 1, 3, 4, 4.5, 7, 8});
    const Curve b = curve_through({0, 1, 2, 3, 4, 5, 6}, {0, 1, 3, 4.2, 4.5, 7, 8});
    for (const double t : {0.0, 0.3, 0.9, 1.0, 5.0, 5.5, 6.0}) EXPECT_EQ(a.at(t), b.at(t));
    EXPECT_NE(a.at(1.5), b.at(1.5));
}

TEST(Curve, CyclesWithoutAKinkWhenItsEndsMeet)
{
    const Curve c =
        curve_through({1, 4, 9}, {0, 2, 0}, Curve::Between::monotone, Curve::Beyond::cycle);
    for (double t = 1; t < 9; t += 0.5) {
        EXPECT_NEAR(c.at(t + 8), c.at(t), 1e-14);
        EXPECT_NEAR(c.at(t - 16), c.at(t), 1e-14);
    }
    EXPECT_EQ(c.slopes.front(), c.slopes.back());
    EXPECT_EQ(c.at(9), 0);
    // A single key cycles as what it is.
    EXPECT_EQ(curve_through({3}, {7}, Curve::Between::linear, Curve::Beyond::cycle).at(50), 7);
}

// Seconds of frames at 30 a second: 0.1 has no exact double, and k * 0.1 and 3 k / 30 differ.
TEST(Curve, CyclesFromTheirFirstKeyAtFramesThatMeetIt)
{
    for (const auto between : all_between) {
        const Curve c = curve_through({0.1, 0.2, 0.4}, {0, 1, 2}, between, Curve::Beyond::cycle);
        for (int k = -1000; k <= 1000; ++k) {
            EXPECT_NEAR(c.at((3 + 9 * k) / 30.0), 0, 1e-8) << k;
            EXPECT_NEAR(c.at((6 + 9 * k) / 30.0), 1, 1e-8) << k;
        }
    }
}

TEST(Curve, StepsAtTheFrameThatMeetsAKey)
{
    std::vector<double> times, values;
    for (int k = 0; k <= 100; ++k) {
        times.push_back(k == 0 ? 0 : times.back() + 0.1);
        values.push_back(k);
    }
    const Curve c = curve_through(times, values, Curve::Between::step);
    for (int k = 0; k <= 100; ++k) EXPECT_EQ(c.at(3 * k / 30.0), k);
    EXPECT_EQ(c.at(0.0999), 0);
}

TEST(Curve, AFarKeyMovesNoOther)
{
    for (const auto beyond : {Curve::Beyond::hold, Curve::Beyond::cycle}) {
        for (const double far : {1e10, 1e300}) {
            const Curve c =
                curve_through({0, 1, 2, far}, {0, 1, 2, 3}, Curve::Between::step, beyond);
            EXPECT_EQ(c.at(0), 0);
            EXPECT_EQ(c.at(0.99), 0);
            EXPECT_EQ(c.at(1), 1);
            EXPECT_EQ(c.at(1.5), 1);
            const Curve before =
                curve_through({-far, 0, 1, 2}, {3, 0, 1, 2}, Curve::Between::step, beyond);
            EXPECT_EQ(before.at(0.99), 0);
        }
    }
}

TEST(Curve, RefusesKeysThatAreNoCurve)
{
    EXPECT_THROW(curve_through({}, {}), std::invalid_argument);
    EXPECT_THROW(curve_through({1}, {1, 2}), std::invalid_argument);
    EXPECT_THROW(curve_through({1, 1}, {1, 2}), std::invalid_argument);
    EXPECT_THROW(curve_through({2, 1}, {1, 2}), std::invalid_argument);
    EXPECT_THROW(curve_through({NAN, 1}, {1, 2}), std::invalid_argument);
    EXPECT_THROW(curve_through({0, 1}, {1, INFINITY}), std::invalid_argument);
}

}  // namespace
