// How deep bodies are in what they touch: contact becomes firmer where something rests or is driven
// in, see plane_touch.hpp.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/body/plane_touch.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace physics {
namespace {

using geometry::Vec3i;

constexpr double cube_edge = 0.1;

// One corner `depth` below the ground, with no other ones to it.
PlaneTouch touch_at(double depth)
{
    PlaneTouch touch;
    touch.count = 1;
    touch.weight[0] = 1;
    touch.offset = -depth;
    touch.stiffness = 1000;
    touch.size = cube_edge;
    return touch;
}

TEST(FirmContact, GrowsByTheTimeThatAPointIsTooDeepUpToALimit)
{
    const std::array<double, 4> x{};
    std::vector<PlaneTouch> touches{touch_at(0.004)};
    StepEnd end{x.data(), x.data(), 0.01};
    end.deep = 0.01;  // cubes
    for (int step = 1; step <= 100; ++step) {
        const auto grips = grips_of(touches, end);
        ASSERT_EQ(grips.size(), 1u);
        const double expected = std::min(20.0, std::exp(0.01 * step / 0.2));
        EXPECT_NEAR(double(grips[0].firmness), expected, 1e-5 * expected);
        touches = {touch_at(0.004)};
        take_grips(touches, grips);
        EXPECT_NEAR(touches[0].stiffness, 1000 * expected, 1e-2 * expected);
    }
    // Deep enough, it stays as it is; apart, it is forgotten.
    touches[0].offset = -0.0009;
    EXPECT_EQ(grips_of(touches, end)[0].firmness, 20);
    touches[0].offset = 0.0009;
    end.near = 0.001;
    EXPECT_EQ(grips_of(touches, end)[0].firmness, 1);
}

TEST(FirmContact, RisesInAStepByAsMuchAsAPressedPointIsTooDeep)
{
    const std::array<double, 4> begin{0, 0.01, 0, 0}, before{0, 0.003, 0, 0}, after{0, -0.01, 0, 0};
    PlaneTouch apart = touch_at(0), bouncing = touch_at(0.004);
    bouncing.rebound = 0.01;
    std::vector<PlaneTouch> touches{touch_at(0.004), apart, bouncing};
    firm_up(touches, {before.data(), after.data(), 0.05, begin.data()});
    EXPECT_NEAR(touches[0].firmness, 0.014 / 0.005, 1e-9);
    EXPECT_NEAR(touches[0].stiffness, 1000 * 0.014 / 0.005, 1e-6);
    EXPECT_EQ(touches[1].firmness, 1);  // not pressed yet: it has not been pushed back either
    EXPECT_EQ(touches[2].firmness, 1);
    firm_up(touches, {before.data(), after.data(), 0.001, begin.data()});
    EXPECT_NEAR(touches[0].firmness, 20, 1e-9);
    EXPECT_NEAR(touches[0].stiffness, 20'000, 1e-6);
}

// k/2 (d - b)^2 + k/2 s^2 at the depth d with which the step began.
double stored(const PlaneTouch& touch, const double* x)
{
    const double pressed = touch.depth(x);
    return 0.5 * touch.stiffness * (pressed * pressed + touch.stretch.squaredNorm());
}

TEST(FirmContact, MakesNoEnergyWhereItRises)
{
    const std::array<double, 4> begin{}, after{0, -0.01, 0, 0};
    PlaneTouch loaded = touch_at(0.004), behind = touch_at(0.004);
    loaded.began = 0.004, loaded.stretch = {0.001, 0, 0};  // behind: the plane is one found now
    std::vector<PlaneTouch> touches{loaded, behind};
    const double energy = stored(loaded, begin.data());
    for (const double deep : {0.05, 0.01}) {
        ASSERT_TRUE(firm_up(touches, {after.data(), after.data(), deep, begin.data()}));
        EXPECT_NEAR(stored(touches[0], begin.data()), energy, 1e-12 * energy);
        EXPECT_EQ(touches[1].slack, 0);
    }
    EXPECT_NEAR(touches[0].firmness, 20, 1e-12);
    // b' = d0 (1 - 1 / sqrt(20)); it is kept, and goes in 0.1 s.
    const double slack = 0.004 * (1 - 1 / std::sqrt(20.0));
    EXPECT_NEAR(touches[0].slack, slack, 1e-12);
    StepEnd end{begin.data(), begin.data(), 0.05};
    const auto grips = grips_of(touches, end);
    EXPECT_NEAR(double(grips[0].slack), slack, 1e-9);
    take_grips(touches, grips, {.dt = 0.05});
    EXPECT_NEAR(touches[0].slack, slack * std::exp(-0.5), 1e-9);
    touches[0].offset = 0.0001, end.near = 0.001;
    EXPECT_EQ(grips_of(touches, end)[0].slack, 0);  // apart, it is forgotten
}

// Slack s goes at sqrt(g s), which brakes what comes out by g / 2: it leaves s = 0 after
// 2 sqrt(s / g), in steps of any length. Where little is left, it goes in 0.1 s.
TEST(FirmContact, LetsOutWhatIsDeepByHalfOfGravity)
{
    const auto after = [](double slack, double seconds, int steps, bool solid) {
        Grip grip;
        grip.depth = 0.3F, grip.slack = static_cast<float>(slack);
        std::vector<PlaneTouch> touches{touch_at(0.3)};
        for (int i = 0; i < steps; ++i) {
            take_grips(touches, {grip}, {.dt = seconds / steps, .solid = solid});
            grip.slack = static_cast<float>(touches[0].slack);
        }
        return double(grip.slack);
    };
    const auto left = [](double slack, double seconds) {
        const double root = std::sqrt(slack) - 0.5 * seconds * std::sqrt(9.81);
        return root * root;
    };
    for (const int steps : {1, 2, 16}) {
        EXPECT_NEAR(after(0.08, 0.1, steps, true), left(0.08, 0.1), 1e-7);
        EXPECT_NEAR(after(0.25, 0.05, steps, false), left(0.25, 0.05), 1e-7);
        EXPECT_NEAR(after(0.08, 0.1, steps, false), 0.08 * std::exp(-1.0), 1e-7);
        EXPECT_NEAR(after(0.004, 0.1, steps, true), 0.004 * std::exp(-1.0), 1e-7);
    }
    // Down to 0.05 cubes as above, and from there on as what starts with less.
    const double little = 0.05 * cube_edge;
    const double until = 2 * (std::sqrt(0.08) - std::sqrt(little)) / std::sqrt(9.81);
    for (const int steps : {1, 2, 16}) {
        EXPECT_NEAR(after(0.08, 0.3, steps, true), little * std::exp((until - 0.3) / 0.1), 1e-7);
    }
}

TEST(FirmContact, StaysWhereAPlaneIsFoundAnewAndRisesNoFurther)
{
    const std::array<double, 4> x{};
    PlaneTouch firm = touch_at(0.004);
    firm.firmness = 20, firm.stiffness = 20'000;
    for (const double depth : {0.004, 0.01}) {  // the plane that is known, and another one
        std::vector<PlaneTouch> touches{firm};
        renew(touches, {touch_at(depth)}, x.data(), 0.001);
        ASSERT_EQ(touches.size(), 1u);
        EXPECT_EQ(touches[0].firmness, 20);
        EXPECT_EQ(touches[0].stiffness, 20'000);
        EXPECT_EQ(touches[0].offset, -depth);
        PlaneTouch fast = touch_at(depth);
        fast.stiffness = 3000;
        renew(touches, {fast}, x.data(), 0.001);
        EXPECT_EQ(touches[0].stiffness, 60'000);
    }
}

TEST(FirmContact, KeepsItsPushAndItsFrictionInStepsOfAnotherLength)
{
    const std::array<double, 4> x{};
    const auto after = [&](const Grip& grip, double at_rest) {
        std::vector<PlaneTouch> touches{touch_at(0.004)};
        touches[0].stiffness = touches[0].at_rest = at_rest;
        take_grips(touches, {grip});
        return touches[0];
    };
    Grip grip;
    grip.depth = 0.004F, grip.stretch = {0.001F, 0, 0}, grip.firmness = 2, grip.at_rest = 1000;
    const PlaneTouch as_long = after(grip, 1000), shorter = after(grip, 16'000);
    EXPECT_EQ(as_long.slack, 0);
    EXPECT_NEAR(shorter.stiffness * shorter.depth(x.data()), 2000 * 0.004, 1e-4);
    EXPECT_NEAR(shorter.stiffness * shorter.stretch.x(), 2000 * 0.001, 1e-4);
    // And back again; without slack to give, the push is less.
    grip.slack = static_cast<float>(shorter.slack), grip.at_rest = 16'000;
    grip.stretch = shorter.stretch.cast<float>();
    const PlaneTouch longer = after(grip, 1000);
    EXPECT_NEAR(longer.slack, 0, 1e-9);
    EXPECT_NEAR(longer.stretch.x(), 0.001, 1e-9);
    EXPECT_EQ(after(grip, 500).slack, 0);
    // What is not known of a grip changes nothing.
    grip.at_rest = 0;
    EXPECT_EQ(after(grip, 1e9).slack, double(grip.slack));
}

State stepped(const BricksBody& body, State state, const Loads& loads, int frames, int substeps)
{
    for (int i = 0; i < frames; ++i) {
        state = advance(body, std::move(state), loads, 1.0 / 24, {.substeps = substeps});
    }
    return state;
}

// A table of 50 kg on four legs of one cube each, soft enough to be 2 % of a cube deep at first.
TEST(FirmContact, WhatRestsIsAHundredthOfACubeDeepAtMostAndStands)
{
    std::vector<Vec3i> cells;
    for (int k = 0; k < 50; ++k) cells.emplace_back(k % 5, 2 + k / 25, k / 5 % 5);
    for (int k = 0; k < 4; ++k) cells.emplace_back(4 * (k % 2), 0, 4 * (k / 2));
    const auto cubes =
        fixtures::cubes_on(cells, cube_edge, {.young = 8e4, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0.5}});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (cubes.corner[k].y() >= 2) state.x[k].y() -= cube_edge;
    }
    for (const int substeps : {1, 4}) {
        State here = stepped(body, state, loads, 2, substeps);
        EXPECT_GT(deepest_of(here.grips), 0.01 * cube_edge);
        here = stepped(body, std::move(here), loads, 46, substeps);
        EXPECT_GT(deepest_of(here.grips), 0.001 * cube_edge);
        EXPECT_LT(deepest_of(here.grips), 0.0055 * cube_edge);
        EXPECT_LT(deepest_of(here.holds), 0.0055 * cube_edge);
        const State later = stepped(body, here, loads, 1, substeps);
        double moved = 0;
        for (std::size_t k = 0; k < here.x.size(); ++k) {
            moved = std::max(moved, (later.x[k] - here.x[k]).norm());
        }
        EXPECT_LT(moved, 1e-4);
    }
}

double fastest(const State& state)
{
    double out = 0;
    for (const Vec3& v : state.v) out = std::max(out, v.norm());
    return out;
}

// What rests half a percent of a cube deep would be thrown out at that over the step, 5 m/s.
TEST(FirmContact, WhatRestsStaysAtRestInShorterSteps)
{
    const auto cubes = fixtures::box(5, 2, 5, cube_edge, {.young = 8e4, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.forces[0].acceleration = {2, -9.6, 0};  // a slope of 11.8 degrees
    loads.colliders.push_back({});
    loads.colliders[0].friction = 0.5;
    State state = stepped(body, rest_state(body), loads, 48, 1);
    ASSERT_GT(deepest_of(state.holds), 0.001 * cube_edge);
    ASSERT_LT(fastest(state), 0.01);
    for (int i = 0; i < 20; ++i) {
        state = advance(body, std::move(state), loads, 1e-4, {});
        EXPECT_LT(fastest(state), 0.02);
    }
}

// A block of 27 kg that falls on its edge onto a plate at 12 m/s.
TEST(FirmContact, WhatIsDrivenInIsATenthOfACubeDeepAtMost)
{
    std::vector<Vec3i> cells;
    for (int k = 0; k < 50; ++k) cells.emplace_back(k % 5, k / 25, k / 5 % 5);
    for (int k = 0; k < 27; ++k) cells.emplace_back(1 + k % 3, 4 + k / 9, 1 + k / 3 % 3);
    const auto cubes =
        fixtures::cubes_on(cells, cube_edge, {.young = 1.5e5, .stiffness_damping = 0.004});
    const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0.5}});
    Loads loads;
    loads.colliders.push_back({});
    State state = rest_state(body);
    const Eigen::AngleAxisd turn(0.7, Vec3::UnitZ());
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (cubes.corner[k].y() < 4) continue;
        const Vec3 middle(0.25, 0.55, 0.25);
        state.x[k] = turn * (state.x[k] - middle) + middle;
        state.v[k].y() = -12;
    }
    double deepest = 0;
    for (int frame = 0; frame < 8; ++frame) {
        state = stepped(body, std::move(state), loads, 1, 4);
        deepest = std::max(deepest, deepest_of(state.grips));
    }
    ASSERT_TRUE(fixtures::finite(state));
    EXPECT_GT(deepest, 0.01 * cube_edge);
    EXPECT_LT(deepest, 0.1 * cube_edge);
}

// Its points stand for no area to speak of. They held nothing, and it fell for ever.
TEST(FirmContact, ASpeckInACubeRestsOnTheGround)
{
    const geometry::Cubes cubes = fixtures::box(1, 1, 1, cube_edge);
    geometry::TriMesh speck = geometry::box(Vec3::Constant(1e-6 * cube_edge), Vec3i::Ones());
    for (auto& p : speck.positions) p += geometry::Vec3f::Constant(0.5f * float(cube_edge));
    const BricksBody body = make_bricks(cubes, {}, &speck);
    Loads loads;
    loads.forces.resize(1);  // gravity
    loads.colliders.resize(1);
    State state = rest_state(body);
    for (int i = 0; i < 24; ++i) state = advance(body, state, loads, 1.0 / 24);
    Vec3 middle = Vec3::Zero();
    for (const Vec3& x : state.x) middle += x / 8;
    EXPECT_NEAR(middle.y(), 0, 0.01 * cube_edge);
}

}  // namespace
}  // namespace physics
