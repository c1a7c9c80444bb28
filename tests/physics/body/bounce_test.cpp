#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <tuple>

namespace physics {
namespace {

constexpr double block_edge = 0.1;

Vec3 mean(const std::vector<Vec3>& of)
{
    Vec3 sum = Vec3::Zero();
    for (const Vec3& v : of) sum += v;
    return sum / static_cast<double>(of.size());
}

Collider floor_of(double bounce)
{
    Collider out;
    out.bounce = bounce;
    return out;
}

// A stiff block of 3 cubes each way.
geometry::Cubes block(double young = 1e9)
{
    return fixtures::box(3, 3, 3, block_edge, {.young = young, .stiffness_damping = 1e-4});
}

// Thrown at a floor from `height` (m) at `speed` (m/s), no gravity: how fast it comes off.
struct Thrown {
    double height = 0.5, speed = 5, bounce = 0.5;
    StepOptions step = {};
    bool guided = false;  // all corners keep their x and z
};
State after(const auto& body, const Thrown& how)
{
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        state.x[k].y() += how.height;
        state.v[k] = Vec3(0, -how.speed, 0);
    }
    Loads loads;
    loads.colliders.push_back(floor_of(how.bounce));
    for (std::uint32_t k = 0; how.guided && k < state.x.size(); ++k) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(state.x[k]);
        loads.pins.axes.push_back(0b101);
    }
    for (int frame = 0; frame < 12; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, how.step);
    }
    EXPECT_TRUE(fixtures::finite(state));
    return state;
}

TEST(Bounce, ABlockLeavesWithItsShareOfTheSpeedThatItCameWith)
{
    const auto cubes = block();
    const auto check = [](const auto& body, const Thrown& how) {
        const State state = after(body, how);
        EXPECT_NEAR(mean(state.v).y(), how.bounce * how.speed, 0.03 * how.speed)
            << how.bounce << " at " << how.speed << " m/s from " << how.height;
        // And is where it then is: half a second less the way down.
        const double way = how.bounce * how.speed * (0.5 - how.height / how.speed);
        EXPECT_NEAR(mean(state.x).y() - 1.5 * block_edge, way, 0.03 * way + 0.01);
    };
    for (const double bounce : {0.5, 0.9, 1.0}) {
        for (const double speed : {2.0, 5.0, 40.0}) {
            for (const double height : {0.3, 0.41, 0.55}) {
                check(make_bricks(cubes), {height, speed, bounce, {}});
            }
        }
    }
    check(make_springs(cubes), {.bounce = 0.9});
    for (const auto integrator : {Integrator::sdirk2, Integrator::implicit_midpoint}) {
        check(make_bricks(cubes), {.bounce = 0.9, .step = {.integrator = integrator}});
    }
    check(make_bricks(cubes), {.bounce = 0.9, .step = {.substeps = 4}});
    check(make_bricks(block(1e6)), {.bounce = 1, .guided = true});
}

// A floor that rises at 2 m/s under a block that hangs still, half a metre above it.
TEST(Bounce, WhatMovesGivesItsOwnSpeedAndTheShare)
{
    for (const double bounce : {0.0, 0.5, 1.0}) {
        const BricksBody body = make_bricks(block());
        State state = rest_state(body);
        for (Vec3& x : state.x) x.y() += 0.5;
        Loads loads;
        loads.colliders.push_back(floor_of(bounce));
        for (int frame = 0; frame < 9; ++frame) {
            const auto height = [&](int at) {
                return geometry::Transform(Eigen::Translation3d(0, at * 2 / 24.0, 0));
            };
            loads.colliders[0].before = height(frame);
            loads.colliders[0].pose = height(frame + 1);
            state = advance(body, state, loads, 1.0 / 24);
        }
        EXPECT_NEAR(mean(state.v).y(), 2 * (1 + bounce), 0.03 * 2) << bounce;
    }
}

TEST(Bounce, WithoutItABlockStays)
{
    for (const auto integrator :
         {Integrator::implicit_euler, Integrator::sdirk2, Integrator::implicit_midpoint}) {
        for (const double height : {0.3, 0.37, 0.41, 0.45, 0.5, 0.55}) {
            const State state =
                after(make_bricks(block()), {height, 5, 0, {.integrator = integrator}});
            EXPECT_NEAR(mean(state.v).y(), 0, 0.01) << int(integrator) << " " << height;
            EXPECT_NEAR(mean(state.x).y(), 1.5 * block_edge, 0.01);
        }
    }
}

// Dropped from 1 m: heights fall by e^2 a bounce, until it lies still.
TEST(Bounce, ADroppedBlockRisesToTheSquareOfItAndComesToRest)
{
    constexpr double e = 0.7;
    const BricksBody body = make_bricks(block());
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back(floor_of(e));
    State state = rest_state(body);
    for (Vec3& x : state.x) x.y() += 1;
    std::vector<double> tops{1};
    double before = 1, rising = 0;
    for (int frame = 0; frame < 144; ++frame) {
        state = advance(body, state, loads, 1.0 / 24,
                        {.integrator = Integrator::sdirk2, .substeps = 4});
        const double now = mean(state.x).y() - 1.5 * block_edge;
        if (rising > 0 && now < before) tops.push_back(before);
        rising = now - before;
        before = now;
    }
    ASSERT_GT(tops.size(), 3u);
    EXPECT_NEAR(tops[1], e * e, 0.05 * e * e);
    EXPECT_NEAR(tops[2], std::pow(e, 4), 0.12 * std::pow(e, 4));
    EXPECT_NEAR(before, 0, 1e-3);
    for (const Vec3& v : state.v) EXPECT_LT(v.norm(), 5e-3);
}

enum class Dropped { rigid, elastic, by_midpoint };

class BounceInLongSteps : public testing::TestWithParam<std::tuple<Dropped, double>> {};

// At 24 steps a second, whenever in a step the floor is hit: gravity shifts that.
TEST_P(BounceInLongSteps, RisesToTheSquareOfItsShare)
{
    const auto [how, g] = GetParam();
    constexpr double e = 0.8;
    const geometry::Cubes cubes = block(1e8);
    const BricksBody body =
        make_bricks(BodyModels(cubes, nullptr),
                    {.rigid = std::vector<std::uint8_t>(1, how == Dropped::rigid ? 1 : 0)});
    Loads loads;
    loads.forces.push_back({.acceleration = {0, -g, 0}});
    loads.colliders.push_back(floor_of(e));
    State state = rest_state(body);
    for (Vec3& x : state.x) x.y() += 1;
    const StepOptions step{.integrator = how == Dropped::by_midpoint ? Integrator::implicit_midpoint
                                                                     : Integrator::implicit_euler};
    std::vector<double> tops;
    double before = 1, rising = 0;
    for (int frame = 0; frame < 60; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, step);
        const double now = mean(state.x).y() - 1.5 * block_edge;
        if (rising > 0 && now < before) tops.push_back(before);
        rising = now - before;
        before = now;
    }
    ASSERT_GE(tops.size(), 2u);
    EXPECT_NEAR(tops[0], std::pow(e, 2), 0.02 * std::pow(e, 2));
    EXPECT_NEAR(tops[1], std::pow(e, 4), 0.03 * std::pow(e, 4));
}
INSTANTIATE_TEST_SUITE_P(Drops, BounceInLongSteps,
                         testing::Combine(testing::Values(Dropped::rigid, Dropped::elastic,
                                                          Dropped::by_midpoint),
                                          testing::Values(9.0, 9.4, 9.6, 9.81, 10.0)));

// Two equal blocks, one thrown at the other.
// What is squashed is followed where the error leaves it more speed than its share, and no longer
// taken for rigid however small the error is.
TEST(Bounce, ChosenStepsFollowASoftBlockWhereTheyLeaveItMore)
{
    const auto leaves = [](double young, double bounce, StepOptions step) {
        return mean(after(make_bricks(block(young)), {.bounce = bounce, .step = step}).v).y() / 5;
    };
    for (const double young : {1e5, 3e5, 1e6, 3e6, 1e7, 1e9}) {
        for (const double bounce : {0.3, 0.6, 0.9}) {
            for (const double error : {0.1, 0.01}) {
                const double speed = leaves(young, bounce, {.substeps = 0, .error = error});
                EXPECT_GT(speed, 0.97 * bounce) << young << " " << bounce << " " << error;
                EXPECT_LT(speed, 1) << young << " " << bounce << " " << error;
            }
        }
    }
    const double fine = leaves(1e5, 0.3, {.substeps = 64});
    EXPECT_GT(fine, 0.7);
    EXPECT_NEAR(leaves(1e5, 0.3, {.substeps = 0, .error = 0.01}), fine, 0.1 * fine);
    EXPECT_GT(leaves(3e4, 0.3, {.substeps = 0}), 0.4) << "in the default steps too";
}

// Half-way down it was taken for rigid, and left with 0.65 of its share.
TEST(Bounce, WhatIsFollowedSinceItHitIsFollowedOn)
{
    constexpr double e = 0.6, high = 0.6;
    const BricksBody body = make_bricks(fixtures::box(2, 2, 2, block_edge, {.young = 2e4}));
    State state = rest_state(body);
    for (Vec3& x : state.x) x.y() += high;
    Loads loads;
    loads.colliders.push_back(floor_of(e));
    loads.forces.push_back({});
    double top = 0, before = high, rising = 0;
    for (int frame = 0; frame < 36; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, {.substeps = 0, .error = 0.02});
        const double now = mean(state.x).y() - block_edge;
        if (rising > 0) top = std::max(top, now);
        rising = std::max(rising, now - before);
        before = now;
    }
    EXPECT_GT(std::sqrt(top / high), 0.97 * e);
}

// So soft that its weight makes it faster yet where the first frame on the floor ends.
TEST(Bounce, ChosenStepsFollowWhatTheFloorHardlySlows)
{
    const auto falls = [](double bounce, double high, int substeps) {
        const BricksBody body = make_bricks(block(300));
        State state = rest_state(body);
        for (Vec3& x : state.x) x.y() += high;
        Loads loads;
        loads.colliders.push_back(floor_of(bounce));
        loads.forces.push_back({});
        std::vector<double> height;
        for (int frame = 0; frame < 6; ++frame) {
            state = advance(body, state, loads, 1.0 / 24, {.substeps = substeps});
            height.push_back(mean(state.x).y());
        }
        return height;
    };
    for (const double high : {0.01, 0.03, 0.06}) {
        const auto chosen = falls(0.6, high, 0), fine = falls(0.6, high, 64);
        for (std::size_t i = 0; i < fine.size(); ++i) {
            EXPECT_NEAR(chosen[i], fine[i], 0.2 * block_edge) << high << " " << i;
        }
    }
}

TEST(Bounce, PartsExchangeMomentumByNewtonsLaw)
{
    constexpr double e = 0.8;
    std::vector<geometry::Vec3i> cells;
    for (int x = 0; x < 3; ++x) {
        for (int y = 0; y < 3; ++y) {
            for (int z = 0; z < 3; ++z) {
                cells.emplace_back(x, y, z);
                cells.emplace_back(x, y + 6, z);
            }
        }
    }
    const auto cubes =
        fixtures::cubes_on(cells, block_edge, {.young = 1e9, .stiffness_damping = 1e-4});
    const BricksBody body = make_bricks(cubes, {.contact = {.bounce = e}});
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.v.size(); ++k) {
        if (cubes.corner[k].y() > 4) state.v[k].y() = -4;
    }
    for (int frame = 0; frame < 8; ++frame) state = advance(body, state, {}, 1.0 / 24);
    double low = 0, high = 0;
    for (std::size_t k = 0; k < state.v.size(); ++k) {
        (cubes.corner[k].y() > 4 ? high : low) += state.v[k].y() / 64;
    }
    EXPECT_NEAR(low, -4 * (1 + e) / 2, 0.03 * 4);
    EXPECT_NEAR(high, -4 * (1 - e) / 2, 0.03 * 4);
    EXPECT_NEAR(low + high, -4, 1e-3);
}

// Of blocks of 3 cubes each way, one on every place of the lattice.
geometry::Cubes blocks_at(const std::vector<geometry::Vec3i>& places)
{
    std::vector<geometry::Vec3i> cells;
    for (const auto& at : places) {
        for (int i = 0; i < 27; ++i) {
            cells.emplace_back(at + geometry::Vec3i(i % 3, i / 3 % 3, i / 9));
        }
    }
    return fixtures::cubes_on(cells, block_edge, {.young = 1e9, .stiffness_damping = 1e-4});
}

// One block lies on the floor and is pushed into it. The other one gets close to it in this step.
TEST(Bounce, WhatDoesNotReachTheFloorInAStepDoesNotBounceInIt)
{
    const auto cubes = blocks_at({{0, 0, 0}, {9, 3, 0}});
    const BricksBody body = make_bricks(cubes);
    constexpr double speed = 2.95 * block_edge * 24;
    for (const auto integrator :
         {Integrator::implicit_euler, Integrator::sdirk2, Integrator::implicit_midpoint}) {
        State state = rest_state(body);
        for (Vec3& v : state.v) v.y() = -speed;
        Loads loads;
        loads.colliders.push_back(floor_of(0.9));
        state = advance(body, state, loads, 1.0 / 24, {.integrator = integrator});
        for (std::size_t k = 0; k < state.v.size(); ++k) {
            if (cubes.corner[k].x() < 6) continue;
            EXPECT_NEAR(state.v[k].y(), -speed, 1e-3) << int(integrator);
        }
    }
}

// Three blocks that spin at up to 17 rad/s hit each other without friction, by all integrators in
// turn: what turns by half a radian within a step is pushed by planes that do not turn with it.
TEST(Bounce, SpinningBlocksThatMeetGainNoEnergy)
{
    const auto cubes = blocks_at({{0, 0, 0}, {0, 5, 0}, {4, 0, 1}});
    const geometry::Random random(3);
    for (const double bounce : {0.0, 1.0}) {
        const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0, .bounce = bounce}});
        for (std::uint64_t seed = 0; seed < 6; ++seed) {
            const auto any = [&](std::uint64_t which, double most) {
                const std::uint64_t at = 12 * seed + 3 * which;
                const auto one = [&](std::uint64_t i) { return 2 * random.unit(at + i) - 1; };
                return Vec3(most * one(0), most * one(1), most * one(2));
            };
            const std::array<Vec3, 3> spin{any(0, 10), any(1, 10), any(2, 10)};
            const std::array<Vec3, 3> middle{Vec3(.15, .15, .15), Vec3(.15, .65, .15),
                                             Vec3(.55, .15, .25)};
            const std::array<Vec3, 3> speed{Vec3(0, 0, 0), Vec3(1, -4, 0.5), Vec3(-2, 0, 0)};
            const Vec3 all = any(3, 3);
            State state = rest_state(body);
            for (std::size_t k = 0; k < state.x.size(); ++k) {
                const std::size_t b = cubes.corner[k].y() > 4 ? 1 : cubes.corner[k].x() > 3 ? 2 : 0;
                state.v[k] = all + speed[b] + spin[b].cross(state.x[k] - middle[b]);
            }
            const auto before = fixtures::brick_motion(cubes, state);
            const StepOptions step{.integrator = Integrator(seed % 3), .substeps = 1};
            for (int frame = 0; frame < 8; ++frame) {
                state = advance(body, state, {}, 1.0 / 24, step);
            }
            const auto after = fixtures::brick_motion(cubes, state);
            EXPECT_LT(after.energy, 1.1 * before.energy) << "seed " << seed << " by " << bounce;
            EXPECT_LT((after.linear - before.linear).norm(), 1e-2 * before.linear.norm()) << seed;
        }
    }
}

// A block hits a bar, which turns and hits it again in the last thousandths of a step. The plane
// between them did not turn with the bar: at that hit, they overlap by 0.05 mm. That must not be
// pushed apart within the rest of the step.
TEST(Bounce, RigidPartsThatMeetLateInAStepGainNoEnergy)
{
    std::vector<geometry::Vec3i> cells;
    for (int i = 0; i < 64; ++i) cells.emplace_back(i % 4, i / 4 % 4 + 8, i / 16);
    for (int i = 0; i < 96; ++i) cells.emplace_back(i % 2 + 8, i / 2 % 12, i / 24);
    const auto cubes = fixtures::cubes_on(cells, 0.05, {.young = 1e7});
    const BricksBody body =
        make_bricks(cubes, {.contact = {.friction = 0, .bounce = 0.5}, .rigid = {1}});
    for (int i = 0; i < 16; ++i) {  // the time of the second hit in its step
        State state = rest_state(body);
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            if (cubes.corner[k].x() > 5) continue;
            state.v[k].x() = 1;
            state.x[k].x() -= 0.0094 + 0.00005 * i;
        }
        double last = fixtures::brick_motion(cubes, state).energy;
        for (int frame = 0; frame < 25; ++frame) {
            state = advance(body, state, {}, 1.0 / 24, {.substeps = 4});
            const double now = fixtures::brick_motion(cubes, state).energy;
            EXPECT_LT(now, 1.001 * last) << "start " << i << ", frame " << frame;
            last = now;
        }
    }
}

// Thrown along a floor with no friction while it spins about a level axis across its way.
TEST(Bounce, ASpinningBlockGainsNoEnergy)
{
    const auto cubes = block();
    const BricksBody body = make_bricks(cubes);
    for (const double sideways : {-10.0, 0.0, 10.0}) {
        for (const double rate : {-15.0, 15.0}) {
            for (const double height : {0.3, 0.35, 0.4}) {
                State state = rest_state(body);
                const Vec3 middle = Vec3::Constant(1.5 * block_edge), spin(0, 0, rate);
                for (std::size_t k = 0; k < state.x.size(); ++k) {
                    state.v[k] = Vec3(sideways, -3, 0) + spin.cross(state.x[k] - middle);
                    state.x[k].y() += height;
                }
                Loads loads;
                loads.colliders.push_back(floor_of(1));
                loads.colliders.back().friction = 0;
                const auto energy = [&] {  // beside what it moves on with
                    State seen = state;
                    for (Vec3& v : seen.v) v.x() -= sideways;
                    return fixtures::brick_motion(cubes, seen).energy;
                };
                const double before = energy();
                for (int frame = 0; frame < 12; ++frame) {
                    state = advance(body, state, loads, 1.0 / 24, {.substeps = 4});
                }
                EXPECT_LT(energy(), 1.05 * before) << sideways << " " << rate << " " << height;
            }
        }
    }
}

}  // namespace
}  // namespace physics
