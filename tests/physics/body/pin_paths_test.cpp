// Where pins are within a frame.

#include "physics/body/pin_paths.hpp"

#include "geometry/base/no_index.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <limits>
#include <numbers>

namespace physics {
namespace {

using geometry::Mat3;

constexpr double edge = 0.1;  // m

const std::vector<Vec3> box = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 2, 3}};

Mat3 turn(double degrees)
{
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3(1, 2, 2) / 3)
        .toRotationMatrix();
}

// Turned by 60 degrees about the mean place, which goes from (0.4, 0.8, 1.2) by (1, 0, -2).
std::vector<Vec3> turned(double share)
{
    const Vec3 middle(0.4, 0.8, 1.2);
    std::vector<Vec3> out;
    for (const Vec3& p : box) {
        out.emplace_back(middle + share * Vec3(1, 0, -2) + turn(60 * share) * (p - middle));
    }
    return out;
}

TEST(PinPaths, WhatMovesAsARigidBodyTurnsEvenly)
{
    const std::vector<std::uint32_t> together(box.size(), 7);
    const PinPaths paths(box, turned(1), together, {}, edge);
    constexpr double ahead = 1e-6;
    for (const double share : {0.0, 0.3, 0.5, 1.0}) {
        const auto expected = turned(share), later = turned(share + ahead),
                   earlier = turned(share - ahead);
        for (std::size_t i = 0; i < box.size(); ++i) {
            EXPECT_LT((paths.at(i, share) - expected[i]).norm(), 1e-14) << share;
            const Vec3 velocity = (later[i] - earlier[i]) / (2 * ahead);  // off by ahead^2
            EXPECT_LT((paths.velocity(i, share) - velocity).norm(), 1e-8) << share;
        }
    }
    for (std::size_t i = 0; i < box.size(); ++i) EXPECT_EQ(paths.at(i, 1), turned(1)[i]);
}

// Swung by 90 degrees about a place 10 m beside it, which moves by (0, 0, 2).
TEST(PinPaths, WhatTurnsAboutAPivotGoesAlongAnArc)
{
    const auto swung = [](const Vec3& p, double share) -> Vec3 {
        const Eigen::AngleAxisd by(share * std::numbers::pi / 2, Vec3::UnitY());
        const Vec3 pivot(10, 0, 0);
        return pivot + share * Vec3(0, 0, 2) + by * Vec3(p - pivot);
    };
    std::vector<Vec3> to;
    for (const Vec3& p : box) to.push_back(swung(p, 1));
    const std::vector<std::uint32_t> together(box.size(), 0);
    const PinPaths paths(box, to, together, std::vector<Vec3>(box.size(), Vec3(10, 0, 2)), edge);
    for (std::size_t i = 0; i < box.size(); ++i) {
        const Vec3 arm = to[i] - Vec3(10, 0, 2);
        const Vec3 speed = std::numbers::pi / 2 * Vec3::UnitY().cross(arm) + Vec3(0, 0, 2);
        EXPECT_LT((paths.at(i, 0.5) - swung(box[i], 0.5)).norm(), 1e-12);
        EXPECT_LT((paths.velocity(i, 1) - speed).norm(), 1e-12);
    }
    // Forces keep their sum and their moment.
    const std::vector<Vec3> forces = {{3, 0, 1}, {0, -20, 5}, {7, 1, 0}, {0, 0, -9}, {2, 30, 0}};
    const auto told = paths.at_end(forces, 0.5);
    Vec3 sum = Vec3::Zero(), sum_at_end = Vec3::Zero(), middle = Vec3::Zero(), end = Vec3::Zero();
    for (std::size_t i = 0; i < box.size(); ++i) {
        sum += forces[i], sum_at_end += told[i];
        middle += swung(box[i], 0.5) / double(box.size()), end += to[i] / double(box.size());
    }
    Vec3 moment = Vec3::Zero(), moment_at_end = Vec3::Zero();
    for (std::size_t i = 0; i < box.size(); ++i) {
        moment += (swung(box[i], 0.5) - middle).cross(forces[i]);
        moment_at_end += (to[i] - end).cross(told[i]);
    }
    EXPECT_LT((sum_at_end - sum).norm(), 1e-12);
    EXPECT_LT((moment_at_end - moment).norm(), 1e-11);
}

// A body that rolled by 60 degrees where it stands is held anew by a pin that turns about the
// origin.
TEST(PinPaths, WhatIsPutBackTurnsInItsPlace)
{
    const Vec3 middle(0.4, 0.8, 1.2);
    std::vector<Vec3> from, to;
    for (const Vec3& p : box) {
        from.emplace_back(Vec3(5, 0, 0) + turn(60) * (p - middle));
        to.emplace_back(Vec3(5, 0, 0) + p - middle);
    }
    const std::vector<std::uint32_t> together(box.size(), 0);
    const PinPaths paths(from, to, together, std::vector<Vec3>(box.size(), Vec3(0, 0, 0)), edge);
    for (std::size_t i = 0; i < box.size(); ++i) {
        const Vec3 expected = Vec3(5, 0, 0) + turn(30) * (box[i] - middle);
        EXPECT_LT((paths.at(i, 0.5) - expected).norm(), 1e-12);
    }
}

// Of two pins that turn a part alike, one tells its pivot, and one, which follows a mesh, has none.
TEST(PinPaths, APivotThatSomeOfThePinsTellIsThatOfAll)
{
    const double open = std::numeric_limits<double>::quiet_NaN();
    const Vec3 pivot(10, 0, 0);
    std::vector<Vec3> to;
    for (const Vec3& p : box) to.emplace_back(pivot + turn(60) * (p - pivot));
    const std::vector<std::uint32_t> together(box.size(), 0);
    for (const bool first : {false, true}) {
        std::vector<Vec3> pivots(box.size(), first ? pivot : Vec3::Constant(open));
        for (std::size_t i = 2; i < box.size(); ++i) {
            pivots[i] = first ? Vec3::Constant(open) : pivot;
        }
        const PinPaths paths(box, to, together, pivots, edge);
        for (std::size_t i = 0; i < box.size(); ++i) {
            const Vec3 expected = pivot + turn(30) * (box[i] - pivot);
            EXPECT_LT((paths.at(i, 0.5) - expected).norm(), 1e-12) << first;
        }
    }
}

// Two pulls at the middle of the frame, against each other and along the arms to the mean place,
// and a weight. Where the points are at its end, they have the moment and the sum that they had.
TEST(PinPaths, ForcesTurnWithThePointsAndKeepTheirSum)
{
    const std::vector<std::uint32_t> together(box.size(), 0);
    const PinPaths paths(box, turned(1), together, {}, edge);
    const Vec3 weight(0, -10, 0);
    std::vector<Vec3> forces(box.size(), weight);
    const Vec3 middle = Vec3(0.4, 0.8, 1.2) + 0.5 * Vec3(1, 0, -2);
    for (const std::size_t i : {1u, 4u}) {
        forces[i] += (i == 1 ? 30 : -30) * (turned(0.5)[1] - turned(0.5)[4]);
    }
    Vec3 moment = Vec3::Zero(), moment_at_end = Vec3::Zero(), sum = Vec3::Zero();
    const auto told = paths.at_end(forces, 0.5);
    for (std::size_t i = 0; i < box.size(); ++i) {
        moment += (turned(0.5)[i] - middle).cross(forces[i]);
        moment_at_end += (turned(1)[i] - middle).cross(told[i]);
        sum += told[i];
    }
    const auto count = static_cast<double>(box.size());
    EXPECT_LT(moment.norm(), 1e-12);
    EXPECT_LT((moment_at_end - 0.5 * Vec3(1, 0, -2).cross(count * weight)).norm(), 1e-12);
    EXPECT_LT((sum - count * weight).norm(), 1e-12);
    for (std::size_t i = 0; i < box.size(); ++i) {
        EXPECT_LT((told[i] - weight - turn(30) * (forces[i] - weight)).norm(), 1e-12);
    }
    EXPECT_EQ(paths.at_end(forces, 1), forces);
}

// A weight that hangs over has a moment across the axis, which does not turn with the points.
TEST(PinPaths, ForcesKeepTheirMomentAboutTheMeanPlace)
{
    const std::vector<std::uint32_t> together(box.size(), 0);
    const PinPaths paths(box, turned(1), together, {}, edge);
    const std::vector<Vec3> forces = {{3, 0, 1}, {0, -20, 5}, {7, 1, 0}, {0, 0, -9}, {2, 30, 0}};
    for (const double share : {0.0, 0.5, 0.75}) {
        const Vec3 middle = Vec3(0.4, 0.8, 1.2) + share * Vec3(1, 0, -2);
        const Vec3 middle_at_end = Vec3(0.4, 0.8, 1.2) + Vec3(1, 0, -2);
        Vec3 moment = Vec3::Zero(), moment_at_end = Vec3::Zero();
        Vec3 sum = Vec3::Zero(), sum_at_end = Vec3::Zero();
        const auto told = paths.at_end(forces, share);
        for (std::size_t i = 0; i < box.size(); ++i) {
            moment += (turned(share)[i] - middle).cross(forces[i]);
            moment_at_end += (turned(1)[i] - middle_at_end).cross(told[i]);
            sum += forces[i];
            sum_at_end += told[i];
        }
        EXPECT_GT(moment.norm(), 10);
        EXPECT_LT((moment_at_end - moment).norm(), 1e-12) << share;
        EXPECT_LT((sum_at_end - sum).norm(), 1e-12) << share;
    }
}

// Half of them are of a part that turns, and half of one that stays.
TEST(PinPaths, EachPartTurnsByItself)
{
    std::vector<Vec3> from = box, to = turned(1);
    from.insert(from.end(), box.begin(), box.end());
    to.insert(to.end(), box.begin(), box.end());
    std::vector<std::uint32_t> parts(from.size(), 0);
    std::fill(parts.begin() + std::ptrdiff_t(box.size()), parts.end(), 1);
    const PinPaths paths(from, to, parts, {}, edge);
    for (std::size_t i = 0; i < box.size(); ++i) {
        EXPECT_LT((paths.at(i, 0.5) - turned(0.5)[i]).norm(), 1e-14);
        EXPECT_EQ(paths.at(box.size() + i, 0.5), box[i]);
        EXPECT_EQ(paths.velocity(box.size() + i, 0.5), Vec3(Vec3::Zero()));
    }
}

// Of one part, a row of cubes: the ends turn against each other about the row, and between them
// some are held still.
TEST(PinPaths, PinsThatMoveDifferentlyTurnByThemselves)
{
    const auto pose = [](const Vec3& p, double share) -> Vec3 {
        const double degrees = p.x() < 0.25 ? 40 : p.x() > 0.65 ? -25 : 0;
        const Eigen::AngleAxisd by(share * degrees * std::numbers::pi / 180, Vec3::UnitX());
        const Vec3 middle(p.x(), 0.1, 0.1);
        return middle + by * Vec3(p - middle);
    };
    std::vector<Vec3> from, to;
    for (int z = 0; z <= 2; ++z) {
        for (int y = 0; y <= 2; ++y) {
            for (const int x : {0, 1, 2, 4, 5, 8, 9}) {
                from.emplace_back(edge * x, edge * y, edge * z);
                to.push_back(pose(from.back(), 1));
            }
        }
    }
    const PinPaths paths(from, to, std::vector<std::uint32_t>(from.size(), 0), {}, edge);
    for (std::size_t i = 0; i < from.size(); ++i) {
        EXPECT_LT((paths.at(i, 0.5) - pose(from[i], 0.5)).norm(), 1e-14) << from[i].transpose();
    }
}

TEST(PinPaths, AllElseGoesAlongLines)
{
    struct Case {
        std::vector<Vec3> from, to;
        std::uint32_t part;
    };
    std::vector<Vec3> bent = turned(1);
    bent[2] += Vec3(0, 0.01, 0);
    const std::vector<Vec3> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    std::vector<Vec3> line_turned;
    for (const Vec3& p : line) line_turned.emplace_back(turn(60) * p);
    std::vector<Vec3> away = box;
    for (Vec3& p : away) p += Vec3(1, 2, 3);
    for (const auto& [from, to, part] :
         {Case{box, turned(1), geometry::no_index}, Case{box, bent, 0}, Case{line, line_turned, 0},
          Case{box, away, 0}, Case{{Vec3(1, 0, 0)}, {Vec3(0, 1, 0)}, 0}}) {
        const PinPaths paths(from, to, std::vector<std::uint32_t>(from.size(), part), {}, edge);
        for (std::size_t i = 0; i < from.size(); ++i) {
            EXPECT_EQ(paths.at(i, 0.25), Vec3(from[i] + 0.25 * (to[i] - from[i])));
            EXPECT_EQ(paths.velocity(i, 0.25), Vec3(to[i] - from[i]));
            EXPECT_EQ(paths.at(i, 1), to[i]);
        }
    }
}

}  // namespace
}  // namespace physics
