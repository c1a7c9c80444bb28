#include "physics/lattice_contact.hpp"

#include "geometry/plane.hpp"
#include "geometry/random.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <set>

using namespace physics;
using geometry::Random;

namespace {

// Particles of twelve bodies at random in a box of 1 m, all of them on the side.
struct Crowd {
    CornerBody body;
    State state;
    std::vector<double> inverse_mass;
    std::vector<std::uint32_t> side, piece;

    explicit Crowd(std::size_t n, double speed)
    {
        const Random random(11);
        for (std::uint32_t i = 0; i < n; ++i) {
            const auto unit = [&](std::uint64_t k) { return random.unit(8 * i + k) - 0.5; };
            state.x.emplace_back(unit(0), unit(1), unit(2));
            state.v.emplace_back(speed * unit(3), speed * unit(4), speed * unit(5));
            body.mass.push_back(1 + random.unit(8 * i + 6));
            inverse_mass.push_back(i % 17 == 0 ? 0 : 1 / body.mass[i]);  // some are pinned
            side.push_back(i);
            piece.push_back(i % 12);
        }
    }
    ContactScene scene() const { return {body, state, inverse_mass, 0.01}; }
};

std::set<std::pair<std::uint32_t, std::uint32_t>> named(const std::vector<PairPush>& pushes)
{
    std::set<std::pair<std::uint32_t, std::uint32_t>> out;
    for (const PairPush& p : pushes) {
        EXPECT_TRUE(out.insert(std::minmax(p.a, p.b)).second) << "found twice";
    }
    return out;
}

}  // namespace

TEST(LatticeContact, FindsThePairsThatASearchOfAllFinds)
{
    const Crowd crowd(900, 2);
    for (const double distance : {0.02, 0.08, 0.3}) {
        const PairPushes found =
            find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, distance, 0.3);
        std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
        const auto next = [&](std::uint32_t i) {
            return Vec3(crowd.state.x[i] + 0.01 * crowd.state.v[i]);
        };
        for (std::uint32_t i = 0; i < 900; ++i) {
            for (std::uint32_t j = i + 1; j < 900; ++j) {
                const bool both_pinned = i % 17 == 0 && j % 17 == 0;
                if (crowd.piece[i] == crowd.piece[j] || both_pinned) continue;
                if ((next(i) - next(j)).norm() < distance) expected.insert({i, j});
            }
        }
        EXPECT_FALSE(expected.empty());
        EXPECT_EQ(named(found.push), expected) << distance;
    }
}

TEST(LatticeContact, GroupsOfOneColourShareNoBody)
{
    const Crowd crowd(900, 2);
    const PairPushes found = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 0.1, 0.3);
    ASSERT_EQ(found.group_at.back(), found.push.size());
    ASSERT_EQ(found.colour_at.back() + 1, found.group_at.size());
    EXPECT_FALSE(found.last_alone);
    for (std::size_t c = 0; c + 1 < found.colour_at.size(); ++c) {
        std::set<std::uint32_t> bodies;
        for (auto g = found.colour_at[c]; g < found.colour_at[c + 1]; ++g) {
            std::set<std::uint32_t> mine;
            for (auto k = found.group_at[g]; k < found.group_at[g + 1]; ++k) {
                mine.insert(crowd.piece[found.push[k].a]);
                mine.insert(crowd.piece[found.push[k].b]);
            }
            EXPECT_EQ(mine.size(), 2u);
            for (const auto b : mine) EXPECT_TRUE(bodies.insert(b).second) << "colour " << c;
        }
    }
}

TEST(LatticeContact, ABodyThatTouchesAHundredOthersIsSolvedAlone)
{
    // One particle in the middle of a hundred others, each a body: more groups share it than there
    // are colours.
    Crowd crowd(101, 0);
    for (std::uint32_t i = 0; i < 101; ++i) {
        crowd.piece[i] = i;
        crowd.state.x[i] *= i == 0 ? 0 : 1e-3;
    }
    const PairPushes found = find_pair_pushes(crowd.scene(), {0, 1, 2, 3, 4, 5}, crowd.piece, 1, 0);
    EXPECT_EQ(found.push.size(), 15u);
    const PairPushes all = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 1, 0);
    EXPECT_TRUE(all.last_alone);
    EXPECT_LE(all.colour_at.size(), 65u);
}

TEST(LatticeContact, PushesKeepMomentumAndThreadsTheSameBytes)
{
    Crowd crowd(900, 2);
    for (std::size_t i = 0; i < 900; ++i) crowd.inverse_mass[i] = 1 / crowd.body.mass[i];
    const auto solve = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        Pushes pushes;
        pushes.pairs = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 0.08, 0.3);
        std::vector<Vec3> v = crowd.state.v;
        std::vector<BallState> balls;
        solve_pushes(crowd.scene(), pushes, 8, v, balls);
        return v;
    };
    const std::vector<Vec3> v = solve(1);
    EXPECT_EQ(solve(2), v);
    EXPECT_EQ(solve(8), v);
    Vec3 before = Vec3::Zero(), after = before, moved = before;
    for (std::size_t i = 0; i < 900; ++i) {
        before += crowd.body.mass[i] * crowd.state.v[i];
        after += crowd.body.mass[i] * v[i];
        moved += crowd.body.mass[i] * (v[i] - crowd.state.v[i]).cwiseAbs();
    }
    EXPECT_GT(moved.norm(), 1);
    EXPECT_LT((after - before).norm(), 1e-12 * moved.norm());  // rounding of some 20,000 pushes
}

TEST(LatticeContact, APairIsStoppedAtItsDistanceAndDraggedAsCoulombSays)
{
    // Two particles of 2 and 3 kg, 0.2 m apart, whose gap of 0.1 m would close by 0.12 m in a step
    // of 0.01 s: an impulse of their reduced mass, 1.2 kg, times 2 m/s lets it just close. To stop
    // their slip of 1 m/s takes 1.2 N s; friction gives no more than its coefficient times 2.4.
    const auto solve = [](double apart, const Vec3& v, double friction) {
        Crowd crowd(2, 0);
        crowd.body.mass = {2, 3};
        crowd.inverse_mass = {1.0 / 2, 1.0 / 3};
        crowd.state.x = {Vec3(-0.01 * v[0], apart, 0), Vec3(0, 0, 0)};
        crowd.state.v = {v, Vec3(0, 0, 0)};
        Pushes pushes;
        pushes.pairs = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 0.1, friction);
        std::vector<Vec3> out = crowd.state.v;
        std::vector<BallState> balls;
        solve_pushes(crowd.scene(), pushes, 8, out, balls);
        return out;
    };
    const auto slides = solve(0.2, Vec3(1, -12, 0), 0.3);
    EXPECT_LT((slides[0] - Vec3(1 - 0.72 / 2, -12 + 2.4 / 2, 0)).norm(), 1e-5);
    EXPECT_LT((slides[1] - Vec3(0.72 / 3, -2.4 / 3, 0)).norm(), 1e-5);
    const auto sticks = solve(0.2, Vec3(1, -12, 0), 0.6);
    EXPECT_LT((sticks[0] - Vec3(1 - 1.2 / 2, -12 + 2.4 / 2, 0)).norm(), 1e-5);
    // Half inside, they come out by a fifth of it in a step, 1 m/s; and nothing holds what leaves.
    const auto comes_out = solve(0.05, Vec3(0, 0, 0), 0.3);
    EXPECT_LT((comes_out[0] - comes_out[1] - Vec3(0, 1, 0)).norm(), 1e-5);
    const auto leaves = solve(0.05, Vec3(0, 4, 0), 0.3);
    EXPECT_EQ(leaves[0], Vec3(0, 4, 0));
    EXPECT_EQ(leaves[1], Vec3(0, 0, 0));
}

TEST(LatticeContact, OnePushMakesABallRoll)
{
    // A ball of 2 kg comes down at 1 m/s and slides at 7 m/s. Its surface gives way to an impulse
    // across the normal by 1/m + r^2 / (2/5 m r^2) = 3.5 / m, so 7 m/s / (3.5 / 2 kg) = 4 N s end
    // the slip at once: it goes on at 7 - 4/2 = 5 m/s and turns at 5 m/s / 0.5 m. The normal's 2 N
    // s times a friction of 3 allow it.
    Crowd crowd(1, 0);
    crowd.state.balls = {{.x = Vec3(0, 0.5, 0), .v = Vec3(7, -1, 0)}};
    const std::vector<Ball> balls = {{.radius = 0.5, .mass = 2}};
    Collider ground;
    ground.friction = 3;
    const ContactScene scene{crowd.body, crowd.state, crowd.inverse_mass, 0.01, balls};
    Pushes pushes;
    pushes.balls = find_ball_pushes(scene, {pose_collider(ground, 1, 0.01, 0.1)});
    std::vector<BallState> out = crowd.state.balls;
    solve_pushes(scene, pushes, 1, crowd.state.v, out);
    EXPECT_LT((out[0].v - Vec3(5, 0, 0)).norm(), 1e-12);
    EXPECT_LT((out[0].spin - Vec3(0, 0, -10)).norm(), 1e-12);
}

TEST(LatticeContact, EveryCornerOfASkinTouchesOnce)
{
    // Sheets without a surface of their own, and a solid, deep in the ground and in a huge ball:
    // the points of their skin are their outer corners.
    for (const int axis : {0, 1, 2, 3}) {
        auto cells = geometry::rectangle_cells(70, 5);
        std::erase(cells, std::array{30, 2});
        const geometry::Cubes cubes =
            axis < 3 ? geometry::plane_cubes(cells, {axis, 0.1, {0, 0, 0}}, 0.02)
                     : fixtures::box(9, 7, 8, 0.1);
        const CornerBody body = make_corner_body(cubes, {}, nullptr);
        State state;
        state.x = geometry::corner_positions(cubes);
        state.v.assign(state.x.size(), Vec3::Zero());
        state.balls.push_back({});
        const std::vector<double> inverse_mass(state.x.size(), 1);
        const std::vector<Ball> balls(1, Ball{.radius = 100});
        const ContactScene scene{body, state, inverse_mass, 0.01, balls};
        Collider ground;
        ground.pose.translate(Vec3(0, 50, 0));
        std::vector<int> on_ground(state.x.size(), 0), on_ball = on_ground;
        const auto count = [](const auto& push, std::vector<int>& times) {
            for (std::size_t a = 0; a < 8; ++a) {
                if (push.weight[a] == 1) ++times[push.corners[a]];
            }
        };
        for (const auto& p : find_skin_pushes(scene, {pose_collider(ground, 1, 0.04, 0.1)})) {
            count(p, on_ground);
        }
        for (const auto& p : find_ball_pushes(scene, {})) count(p, on_ball);
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            const auto& at = cubes.corner[k];
            const bool inside = axis == 3 && at[0] % 9 != 0 && at[1] % 7 != 0 && at[2] % 8 != 0;
            ASSERT_EQ(on_ground[k], inside ? 0 : 1) << axis << ' ' << k;
            ASSERT_EQ(on_ball[k], inside ? 0 : 1) << axis << ' ' << k;
        }
    }
}

TEST(LatticeContact, NothingNearIsNothing)
{
    const Crowd crowd(20, 0);
    const PairPushes found = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 1e-9, 0.3);
    EXPECT_TRUE(found.push.empty());
    Pushes pushes;
    pushes.pairs = found;
    std::vector<Vec3> v = crowd.state.v;
    std::vector<BallState> balls;
    solve_pushes(crowd.scene(), pushes, 8, v, balls);
    EXPECT_EQ(v, crowd.state.v);
}
