#include "physics/state/gusts.hpp"

#include "physics/bricks/bricks.hpp"
#include "physics/state/state.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace physics {
namespace {

Force gusty(double speed, double size, std::uint32_t seed = 1)
{
    Force out;
    out.kind = Force::Kind::wind;
    out.velocity = Vec3(6, 0, 0);
    out.gusts = {.speed = speed, .size = size, .seed = seed};
    return out;
}

// Places of a lattice whose steps no wave length is a part of.
template <class Visit> void at_many_places(const Visit& visit)
{
    constexpr int many = 24;
    for (int i = 0; i < many; ++i) {
        for (int j = 0; j < many; ++j) {
            for (int k = 0; k < many; ++k) visit(Vec3(1.37 * i, 1.71 * j, 1.93 * k));
        }
    }
}

TEST(Gusts, HaveTheSpeedThatTheyState)
{
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
        const Air air(gusty(2, 3, seed));
        Vec3 mean = Vec3::Zero();
        double squares = 0, count = 0;
        at_many_places([&](const Vec3& p) {
            const Vec3 off = air.at(p) - Vec3(6, 0, 0);
            mean += off, squares += off.squaredNorm(), count += 1;
        });
        EXPECT_LT((mean / count).norm(), 0.05) << seed;
        EXPECT_NEAR(std::sqrt(squares / count), 2, 0.04) << seed;
    }
}

TEST(Gusts, MakeNoAir)
{
    const Air air(gusty(2, 3));
    constexpr double d = 1e-5;  // m
    double divergence = 0, slope = 0;
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 2, 3), Vec3(-4, 0.3, 9)}) {
        for (Eigen::Index k = 0; k < 3; ++k) {
            const Vec3 change = (air.at(p + d * Vec3::Unit(k)) - air.at(p - d * Vec3::Unit(k)));
            divergence += change[k] / (2 * d);
            slope = std::max(slope, change.norm() / (2 * d));
        }
        EXPECT_GT(slope, 1);
        EXPECT_LT(std::abs(divergence), 1e-6 * slope);
    }
}

TEST(Gusts, OfASizeVaryOverIt)
{
    // What is twice as large varies as much over twice the way.
    const Air small(gusty(2, 3)), large(gusty(2, 6));
    at_many_places([&](const Vec3& p) { ASSERT_LT((small.at(p) - large.at(2 * p)).norm(), 1e-9); });
    EXPECT_GT((small.at(Vec3(0, 0, 0)) - Air(gusty(2, 3, 7)).at(Vec3(0, 0, 0))).norm(), 0.1);
}

TEST(Gusts, GoWithTheWindAndChangeOnTheirWay)
{
    Force later = gusty(2, 3);
    let_pass(gusty(2, 3), 0.01, later);
    EXPECT_DOUBLE_EQ(later.gusts.carried.x(), 0.02);  // sizes: 6 m/s for 0.01 s
    EXPECT_DOUBLE_EQ(later.gusts.time, 0.02 / 3);
    later.gusts.time = 0;
    const Vec3 p(0.4, 1, 2), carried = p + Vec3(0.06, 0, 0);
    EXPECT_LT((Air(later).at(carried) - Air(gusty(2, 3)).at(p)).norm(), 1e-12);
    later.gusts.time = 0.01;
    const double a_bit = (Air(later).at(carried) - Air(gusty(2, 3)).at(p)).norm();
    later.gusts.time = 2;
    const double all = (Air(later).at(carried) - Air(gusty(2, 3)).at(p)).norm();
    EXPECT_GT(a_bit, 0.001);
    EXPECT_LT(a_bit, 0.1 * all);
    // Within a frame, from where it starts.
    later.began_as(gusty(2, 3));
    EXPECT_DOUBLE_EQ(later.at(0.25).gusts.time, 0.5);
    EXPECT_DOUBLE_EQ(later.at(0.5).gusts.carried.x(), 0.01);
}

// m/s, root mean square: by how much the air at places changes in a frame of each second, from 60 s
// on, where speed and size change evenly from those of `first` to those of `last` in the second
// one.
std::array<double, 3> changes_in_frames(const Gusts& first, const Gusts& last, const Vec3& wind)
{
    constexpr int fps = 24, start = 60;
    std::array<double, 3> sums{};
    Force now = gusty(first.speed, first.size);
    now.velocity = wind;
    for (int frame = 1; frame <= (start + 3) * fps; ++frame) {
        const Force before = now;
        const double share = std::clamp(double(frame) / fps - (start + 1), 0.0, 1.0);
        now.gusts.speed = first.speed + share * (last.speed - first.speed);
        now.gusts.size = first.size + share * (last.size - first.size);
        let_pass(before, 1.0 / fps, now);
        if (frame <= start * fps) continue;
        double& sum = sums[std::size_t((frame - 1) / fps - start)];
        for (int i = 0; i < 8; ++i) {
            const Vec3 place(0.7 * i, 0.3 * i, 0);
            sum += (Air(now).at(place) - Air(before).at(place)).squaredNorm() / (8 * fps);
        }
    }
    for (double& sum : sums) sum = std::sqrt(sum);
    return sums;
}

// Waves that went by at other rates have gone by: it was three and twice as much.
TEST(Gusts, PassNoFasterWhileTheirSpeedOrSizeChanges)
{
    const auto passes = [](const Gusts& first, const Gusts& last, const Vec3& wind) {
        const auto [before, now, after] = changes_in_frames(first, last, wind);
        EXPECT_LT(now, 1.3 * std::max(before, after));
        EXPECT_GT(now, 0.7 * std::min(before, after));
    };
    const Gusts slow{.speed = 0.9, .size = 2}, fast{.speed = 1.1, .size = 2};
    passes(slow, fast, Vec3::Zero());
    passes(fast, slow, Vec3::Zero());
    const Gusts small{.speed = 1, .size = 4}, large{.speed = 1, .size = 4.4};
    passes(small, large, Vec3(5, 0, 0));
    passes(large, small, Vec3(5, 0, 0));
}

TEST(Gusts, CarryWhatIsLightAsFastAsTheAirIsThere)
{
    const Force wind = gusty(3, 2);
    Loads loads;
    loads.forces.push_back(wind);
    for (const Vec3& place : {Vec3(0, 0, 0), Vec3(3, 1, 0.5), Vec3(-2, 5, 1)}) {
        geometry::Cubes mote = fixtures::box(1, 1, 1, 0.01, {.density = 0.01, .young = 1e5});
        mote.origin += place;
        const BricksBody body = make_bricks(mote, {.rigid = {1}});
        State state = rest_state(body);
        const auto mean = [&](const std::vector<Vec3>& of) {
            Vec3 sum = Vec3::Zero();
            for (const Vec3& v : of) sum += v / double(of.size());
            return sum;
        };
        for (int i = 0; i < 200; ++i) state = advance(body, state, loads, 1e-5, {.substeps = 1});
        const Vec3 air = Air(wind).at(mean(state.x));
        EXPECT_LT((mean(state.v) - air).norm(), 0.1 * air.norm()) << mean(state.v).transpose();
        EXPECT_GT((air - wind.velocity).norm(), 0.5);
    }
}

}  // namespace
}  // namespace physics
