// Bodies that start where their loads are balanced.

#include "physics/bricks/settle.hpp"

#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using namespace physics;
using geometry::Cubes;
using geometry::Vec3i;

struct Cantilever {
    Cubes cubes;
    BricksBody body;
    Loads loads;
    std::uint32_t tip = 0;

    explicit Cantilever(int length, int thick, double h, double young, double damping = 0)
        : cubes(fixtures::box(length, thick, thick, h,
                              {.young = young, .poisson = 0, .stiffness_damping = damping})),
          body(make_bricks(cubes))
    {
        loads.forces.push_back({});  // gravity
        loads.pins.corner = fixtures::first_layer(cubes);
        for (const auto k : loads.pins.corner) {
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        tip = static_cast<std::uint32_t>(cubes.corner_count() - 1);
    }
    double sag(const State& state) const
    {
        return cubes.corner_position(tip).y() - state.x[tip].y();
    }
};

TEST(Settle, ACantileverStartsSaggedAsItsWeightSays)
{
    // w L^4 / (8 E I) = rho g L^4 12 / (8 E a^2) = 0.0147 L. Shear adds 1.2 w L^2 / (2 G A), 0.8 %
    // of it, and two cubes across bend as the square that they are.
    const Cantilever beam(20, 2, 0.05, 1e8);
    const State state = settle(beam.body, rest_state(beam.body), beam.loads, {});
    EXPECT_TRUE(state.report.converged);
    EXPECT_TRUE(state.report.warnings.empty());
    const double expected = 1000 * 9.81 * 12 / (8 * 1e8 * 0.01);
    EXPECT_NEAR(beam.sag(state), expected, 0.02 * expected);
    EXPECT_EQ(state.time, 0);
    for (const Vec3& v : state.v) EXPECT_EQ(v, Vec3::Zero());
}

TEST(Settle, WhatStartsInEquilibriumStaysForAHundredFrames)
{
    // Bent by a seventh of its length; stepped as every scene is.
    const Cantilever beam(20, 2, 0.05, 1e7, 0.01);
    State state = settle(beam.body, rest_state(beam.body), beam.loads, {});
    const double sag = beam.sag(state);
    EXPECT_TRUE(state.report.converged);
    EXPECT_GT(sag, 0.12);
    for (int i = 0; i < 100; ++i) {
        state = advance(beam.body, std::move(state), beam.loads, 1.0 / 24);
        ASSERT_NEAR(beam.sag(state), sag, 0.01 * sag) << i;
    }
}

TEST(Settle, ABodyThatRestsOnAColliderStays)
{
    // Pinned at one end and on the ground at the other.
    Cantilever beam(20, 2, 0.05, 1e7, 0.01);
    Collider ground;
    ground.pose.translate(Vec3(0, -0.05, 0));
    ground.before = ground.pose;
    beam.loads.colliders.push_back(ground);
    State state = settle(beam.body, rest_state(beam.body), beam.loads, {});
    const double sag = beam.sag(state);
    EXPECT_TRUE(state.report.converged);
    EXPECT_NEAR(sag, 0.05, 0.01);
    for (int i = 0; i < 24; ++i) {
        state = advance(beam.body, std::move(state), beam.loads, 1.0 / 24);
        ASSERT_NEAR(beam.sag(state), sag, 0.01) << i;
    }
}

// Blocks of jelly in the air, one above the other: they come to lie on the ground and on each other
// at once, as far pressed together as their weight says, and stay.
TEST(Settle, WhatHasNoPinsComesToLieOnTheGround)
{
    constexpr double h = 0.1, young = 2e5;
    std::vector<Vec3i> cells;
    for (int i = 0; i < 4 * 4 * 4; ++i) cells.emplace_back(i % 4, 1 + i / 16, i / 4 % 4);
    for (int i = 0; i < 2 * 2 * 2; ++i) cells.emplace_back(1 + i % 2, 6 + i / 4, 1 + i / 2 % 2);
    const Cubes cubes =
        fixtures::cubes_on(cells, h, {.young = young, .poisson = 0, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0.5}});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});  // the ground
    State state = settle(body, rest_state(body), loads, {});
    EXPECT_TRUE(state.report.converged);
    EXPECT_TRUE(state.report.warnings.empty());
    EXPECT_EQ(state.time, 0);
    const auto mean_height = [&](const State& of, int row) {
        double sum = 0;
        int count = 0;
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k].y() == row) sum += of.x[k].y(), ++count;
        }
        return sum / count;
    };
    EXPECT_NEAR(mean_height(state, 1), 0, 0.01 * h);
    // rho g H^2 / (2 E), and what the upper block does: its weight over the width of the lower one.
    const double weight = 1000 * 9.81 / young, load = weight * 0.2 * 0.2 * 0.2;
    const double lower = 0.4 - weight * 0.4 * 0.4 / 2 - load * 0.4 / (0.4 * 0.4);
    EXPECT_NEAR(mean_height(state, 5), lower, 0.002);
    EXPECT_GT(mean_height(state, 6), 0.35);
    const State settled = state;
    for (int i = 0; i < 48; ++i) state = advance(body, std::move(state), loads, 1.0 / 24);
    double moved = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        moved = std::max(moved, (state.x[k] - settled.x[k]).norm());
    }
    EXPECT_LT(moved, 0.005 * h);
}

TEST(Settle, WhatFindsNoPlaceToLieSaysSo)
{
    for (const double h : {0.1, 1.0}) {
        const Cubes cubes = fixtures::box(2, 2, 2, h, {.young = 1e6});
        const BricksBody body = make_bricks(cubes);
        Loads loads;
        loads.forces.push_back({});
        Collider beside;
        beside.kind = Collider::Kind::box;
        beside.pose.translate(Vec3(30 * h, 0, 0));
        beside.before = beside.pose;
        loads.colliders.push_back(beside);
        try {
            settle(body, rest_state(body), loads, {});
            FAIL() << "it came to rest";
        } catch (const std::invalid_argument& e) {
            EXPECT_NE(std::string(e.what()).find("They fall beside the colliders"),
                      std::string::npos)
                << e.what();
        }
    }
}

TEST(Settle, EveryPartNeedsAPin)
{
    const Cubes cubes = fixtures::cubes_on({{0, 0, 0}, {3, 0, 0}}, 0.1);
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    const auto told = [&] {
        try {
            settle(body, rest_state(body), loads, {});
        } catch (const std::invalid_argument& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    EXPECT_NE(told().find("2 of 2 parts"), std::string::npos) << told();
    loads.pins.corner = {0, 1};  // both of the first cube
    for (const auto k : loads.pins.corner) loads.pins.target.push_back(cubes.corner_position(k));
    EXPECT_NE(told().find("1 of 2 parts"), std::string::npos) << told();
    EXPECT_NE(told().find("Pin each part"), std::string::npos);
}

}  // namespace
