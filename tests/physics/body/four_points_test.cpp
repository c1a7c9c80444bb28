// How four points stand to each other, and when they meet.

#include "geometry/base/random.hpp"
#include "physics/body/four_points.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace physics;
using geometry::Random;

namespace {

FourPoints by_chance(std::uint64_t seed)
{
    const Random random(seed);
    FourPoints out;
    for (std::uint64_t i = 0; i < 4; ++i) {
        for (std::uint64_t a = 0; a < 3; ++a) out[i][Eigen::Index(a)] = random.unit(3 * i + a);
    }
    return out;
}

double volume(const FourPoints& a, const FourPoints& b, double t)
{
    FourPoints x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = a[i] + t * (b[i] - a[i]);
    return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]);
}

}  // namespace

TEST(FourPoints, StandAsFarApartAsTheirNearestPlaces)
{
    // The point (0.2, 0.3) of a triangle, 0.5 above it.
    const auto over = stand_of(Four::point, {Vec3(0.2, 0.3, 0.5), {0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    ASSERT_TRUE(over);
    EXPECT_NEAR(over->distance, 0.5, 1e-15);
    EXPECT_NEAR(over->weight[1], -0.5, 1e-6);
    EXPECT_NEAR(over->weight[2], -0.2, 1e-6);
    EXPECT_FALSE(stand_of(Four::point, {Vec3(0.7, 0.7, 0.5), {0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    // Edges that cross at a quarter of the one and the half of the other, 0.1 apart.
    const auto cross = stand_of(Four::edges, {Vec3(0, 0, 0), {4, 0, 0}, {1, -1, 0.1}, {1, 1, 0.1}});
    ASSERT_TRUE(cross);
    EXPECT_NEAR(std::abs(cross->distance), 0.1, 1e-15);
    EXPECT_NEAR(cross->weight[1], 0.25, 1e-6);
    EXPECT_NEAR(cross->weight[3], -0.5, 1e-6);
    EXPECT_FALSE(stand_of(Four::edges, {Vec3(0, 0, 0), {4, 0, 0}, {1, 0.1, 0}, {2, 0.1, 0}}));
}

TEST(FourPoints, TheirWeightsSumUpToNothingAndToTheDistance)
{
    int found = 0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const FourPoints x = by_chance(seed);
        for (const Four kind : {Four::point, Four::edges}) {
            const auto stand = stand_of(kind, x);
            if (!stand) continue;
            ++found;
            Vec3 way = Vec3::Zero();
            double sum = 0;
            for (std::size_t i = 0; i < 4; ++i) {
                way += stand->weight[i] * x[i], sum += double(float(stand->weight[i]));
            }
            EXPECT_EQ(sum, 0);  // exactly, as single precision keeps them
            EXPECT_NEAR(way.dot(stand->normal), stand->distance, 1e-5);
            EXPECT_LT((way - stand->distance * stand->normal).norm(), 1e-5);
        }
    }
    EXPECT_GT(found, 100);
}

TEST(FourPoints, LieInAPlaneWhenTheirVolumeChangesItsSign)
{
    // Every change of sign of the volume over 2,000 moments, and no more.
    int found = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const FourPoints a = by_chance(2 * seed), b = by_chance(2 * seed + 1);
        const PlaneTimes times = plane_times(a, b);
        std::size_t next = 0;
        constexpr int moments = 2000;
        for (int i = 0; i < moments; ++i) {
            const double from = double(i) / moments, to = double(i + 1) / moments;
            if ((volume(a, b, from) > 0) == (volume(a, b, to) > 0)) continue;
            ASSERT_LT(next, times.count) << seed;
            EXPECT_NEAR(times.at[next++], (from + to) / 2, 1e-3);
            ++found;
        }
        EXPECT_EQ(next, times.count) << seed;
    }
    EXPECT_GT(found, 100);
}

TEST(FourPoints, MeetWhereAFastPointGoesThroughATriangle)
{
    // It goes through at (0.2, 0.3) after a quarter of its way, and past the triangle it meets
    // nothing.
    const FourPoints a{Vec3(0.2, 0.3, 1), {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    FourPoints b = a;
    b[0].z() = -3;
    const auto through = meeting_of(Four::point, a, b);
    ASSERT_TRUE(through);
    EXPECT_NEAR(through->distance, 0, 1e-12);
    EXPECT_NEAR(through->weight[2], -0.2, 1e-6);
    FourPoints beside = a, past = b;
    beside[0].x() += 1, past[0].x() += 1;
    EXPECT_FALSE(meeting_of(Four::point, beside, past));
}
