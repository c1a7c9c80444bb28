#include "geometry/mesh/mesh.hpp"
#include "physics/lattice/lattice_contact.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/lattice/lattice.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/every_target.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <set>

using namespace physics;
using geometry::Cubes;
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

std::set<std::pair<std::uint32_t, std::uint32_t>> named(const PairPushes& pushes)
{
    std::set<std::pair<std::uint32_t, std::uint32_t>> out;
    for (const PairsAbreast& row : pushes.row) {
        for (std::uint32_t k = 0; k < row.count; ++k) {
            EXPECT_TRUE(out.insert(std::minmax(row.a[k], row.b[k])).second) << "found twice";
        }
    }
    return out;
}

PairPushes find_pair_pushes(const ContactScene& scene, const std::vector<std::uint32_t>& side,
                            const std::vector<std::uint32_t>& piece, double distance,
                            double friction)
{
    PairPushes out;
    physics::find_pair_pushes(scene, side, piece, distance, friction, out);
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
        EXPECT_EQ(named(found), expected) << distance;
    }
}

TEST(LatticeContact, BunchesOfOneColourShareNoBodyNorDoPairsAbreast)
{
    const Crowd crowd(900, 2);
    const PairPushes found = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 0.1, 0.3);
    ASSERT_EQ(found.bunch_at.back(), found.row.size());
    ASSERT_EQ(found.colour_at.back() + 1, found.bunch_at.size());
    EXPECT_FALSE(found.last_alone);
    std::size_t fullest = 0;
    for (std::size_t c = 0; c < found.colours(); ++c) {
        std::set<std::uint32_t> bodies;
        for (auto bunch = found.colour_at[c]; bunch < found.colour_at[c + 1]; ++bunch) {
            std::set<std::uint32_t> mine[PairsAbreast::most];  // of the pairs one after another
            for (auto r = found.bunch_at[bunch]; r < found.bunch_at[bunch + 1]; ++r) {
                const PairsAbreast& row = found.row[r];
                EXPECT_GT(row.count, 0u);
                for (std::uint32_t k = 0; k < row.count; ++k) {
                    mine[k].insert({crowd.piece[row.a[k]], crowd.piece[row.b[k]]});
                }
                fullest = std::max<std::size_t>(fullest, row.count);
            }
            for (const auto& some : mine) {
                EXPECT_TRUE(some.empty() || some.size() == 2);
                for (const auto b : some) EXPECT_TRUE(bodies.insert(b).second) << "colour " << c;
            }
        }
    }
    EXPECT_GT(fullest, 4u);
}

TEST(LatticeContact, ABodyWithAHundredNeighboursIsSolvedAlone)
{
    // One particle in the middle of a hundred others, each a body: more groups share it than there
    // are colours.
    Crowd crowd(101, 0);
    for (std::uint32_t i = 0; i < 101; ++i) {
        crowd.piece[i] = i;
        crowd.state.x[i] *= i == 0 ? 0 : 1e-3;
    }
    const PairPushes found = find_pair_pushes(crowd.scene(), {0, 1, 2, 3, 4, 5}, crowd.piece, 1, 0);
    EXPECT_EQ(named(found).size(), 15u);
    const PairPushes all = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 1, 0);
    EXPECT_TRUE(all.last_alone);
    EXPECT_LE(all.colour_at.size(), 65u);
    for (auto r = all.bunch_at[all.colour_at[all.colours() - 1]]; r < all.row.size(); ++r) {
        EXPECT_EQ(all.row[r].count, 1u);
    }
    // Threads would meet in a body of the last colour.
    const auto solve = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        Pushes pushes;
        pushes.pairs = all;
        std::vector<Vec3> v = crowd.state.v;
        std::vector<BallState> balls;
        solve_pushes(crowd.scene(), pushes, 8, v, balls);
        return v;
    };
    const std::vector<Vec3> one = solve(1);
    for (int k = 0; k < 10; ++k) ASSERT_EQ(solve(8), one);
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

TEST(LatticeContact, PairsAbreastEqualPairsInTurnOnAnyProcessor)
{
    const Crowd crowd(900, 2);
    const auto scene = crowd.scene();
    for (const float friction : {0.0f, 0.3f, 5.0f}) {
        PairPushes found = find_pair_pushes(scene, crowd.side, crowd.piece, 0.1, friction);
        // In double, from the same normals and masses.
        std::vector<Vec3> v = crowd.state.v;
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<double, Vec3>> sofar;
        double most = 0;
        for (int round = 0; round < 3; ++round) {
            for (const PairsAbreast& row : found.row) {
                for (std::uint32_t k = 0; k < row.count; ++k) {
                    const std::uint32_t a = row.a[k], b = row.b[k];
                    auto& [impulse, drag] =
                        sofar.try_emplace({a, b}, 0.0, Vec3::Zero()).first->second;
                    const Vec3 n(row.normal[0][k], row.normal[1][k], row.normal[2][k]);
                    const Vec3 u = v[a] - v[b];
                    const double m = row.mass[k], along = u.dot(n);
                    const double now = std::max(0.0, impulse - m * (along + row.bias[k]));
                    Vec3 slip = drag - m * (u - along * n);
                    if (slip.norm() > friction * now) slip *= friction * now / slip.norm();
                    const Vec3 change = (now - impulse) * n + slip - drag;
                    v[a] += scene.inverse_mass[a] * change;
                    v[b] -= scene.inverse_mass[b] * change;
                    impulse = now;
                    drag = slip;
                    most = std::max(most, change.norm());
                }
            }
        }
        EXPECT_GT(most, 0.5);
        std::vector<Vec3> first;
        on_every_target([&](const char* target) {
            PairPushes pairs = found;
            std::vector<Vec3> out = crowd.state.v;
            for (int round = 0; round < 3; ++round) {
                solve_rows(pairs.row, pairs.friction, scene.inverse_mass, out);
            }
            for (std::size_t i = 0; i < out.size(); ++i) {
                ASSERT_LT((out[i] - v[i]).norm(), 2e-4) << target << " " << friction << " " << i;
            }
            if (first.empty()) first = out;
            EXPECT_EQ(out, first) << target;
        });
    }
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
    // At one place nothing says which way is out: up and down will do.
    const auto parted = solve(0, Vec3(0, 0, 0), 0.3);
    EXPECT_LT((parted[0] - parted[1] - Vec3(0, 2, 0)).norm(), 1e-5);
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
        const Cubes cubes = axis < 3 ? geometry::plane_cubes(cells, {axis, 0.1, {0, 0, 0}}, 0.02)
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

TEST(LatticeContact, AMovingFloorCarriesWhatLiesOnIt)
{
    // A floor rises at 2 m/s and goes aside at 7 m/s. What touches it is lifted with it at once; a
    // friction of 3 allows 6 m/s of drag a unit of mass: a ball's surface, which gives way 3.5
    // times as easily as the ball, gets all its 7 m/s, so 2 m/s of it are the ball's; the corner of
    // a cube, the other seven of which stay as they are, gets 6.
    const Cubes cubes = fixtures::box(1, 1, 1, 0.1);
    const double dt = 0.01;
    for (const double inside : {0.0, 0.005}) {
        Crowd crowd(8, 0);
        crowd.body = make_corner_body(cubes, {}, nullptr);
        crowd.inverse_mass.assign(8, 8.0);
        // On its tip, which is deepest.
        crowd.state.x = geometry::corner_positions(cubes);
        const auto tip = Eigen::Quaterniond::FromTwoVectors(Vec3::Ones(), Vec3::UnitY());
        for (Vec3& x : crowd.state.x) x = tip * x - Vec3(0, inside, 0);
        crowd.state.v.assign(8, Vec3::Zero());
        crowd.state.balls = {{.x = Vec3(5, 0.5 - inside, 0)}};
        const std::vector<Ball> balls = {{.radius = 0.5, .mass = 2}};
        Collider floor;
        floor.friction = 3;
        floor.pose.pretranslate(dt * Vec3(7, 2, 0));
        const std::vector<PosedCollider> posed = {pose_collider(floor, 1, dt, 0.1)};
        const ContactScene scene{crowd.body, crowd.state, crowd.inverse_mass, dt, balls};
        Pushes pushes;
        pushes.skin = find_skin_pushes(scene, posed);
        pushes.balls = find_ball_pushes(scene, posed);
        ASSERT_EQ(pushes.skin.size(), 1u);
        ASSERT_EQ(pushes.balls.size(), 1u);
        std::vector<BallState> out = crowd.state.balls;
        solve_pushes(scene, pushes, 1, crowd.state.v, out);
        // What was inside comes out by a fifth of it besides.
        const double up = 2 + 0.2 * inside / dt, most = std::min(7.0, 3 * up);
        EXPECT_LT((crowd.state.v[0] - Vec3(most, up, 0)).norm(), 1e-6) << inside;
        EXPECT_EQ(crowd.state.v[7], Vec3::Zero());
        EXPECT_LT((out[0].v - Vec3(2, up, 0)).norm(), 1e-12) << inside;
        EXPECT_LT((out[0].spin - Vec3(0, 0, 10)).norm(), 1e-12) << inside;
    }
}

TEST(LatticeContact, ABallIsStoppedByACornerOfTheSkin)
{
    // A ball of 2 kg meets the tip of a cube, 1/8 kg, which moves itself: the gap closes by as much
    // as there is of it. Across, the two give way to an impulse by 8 + 3.5 / 2 1/kg, which takes
    // away the slip where friction allows it.
    const Cubes cubes = fixtures::box(1, 1, 1, 0.1);
    const double dt = 0.01, gap = 0.01;
    for (const double friction : {10.0, 0.2}) {
        Crowd crowd(8, 0);
        crowd.body = make_corner_body(cubes, {}, nullptr);
        crowd.inverse_mass.assign(8, 8.0);
        crowd.state.x = geometry::corner_positions(cubes);
        const auto tip = Eigen::Quaterniond::FromTwoVectors(-Vec3::Ones(), Vec3::UnitY());
        for (Vec3& x : crowd.state.x) x = tip * x;  // corner 0 on top, at the origin
        crowd.state.v.assign(8, Vec3(0, 1, 0));
        const Vec3 speed(3, -4, 0);
        // Straight above the tip at the end of the step, if nothing stopped it.
        crowd.state.balls = {{.x = Vec3(-3 * dt, 0.5 + gap, 0), .v = speed}};
        const std::vector<Ball> balls = {{.radius = 0.5, .mass = 2, .friction = friction}};
        const ContactScene scene{crowd.body, crowd.state, crowd.inverse_mass, dt, balls};
        Pushes pushes;
        pushes.balls = find_ball_pushes(scene, {});
        ASSERT_EQ(pushes.balls.size(), 1u);
        std::vector<BallState> out = crowd.state.balls;
        solve_pushes(scene, pushes, 1, crowd.state.v, out);
        const double along = (5 - gap / dt) / (8 + 0.5);
        const double across = std::min(3 / (8 + 3.5 / 2), friction * along);
        EXPECT_LT((crowd.state.v[0] - Vec3(8 * across, 1 - 8 * along, 0)).norm(), 1e-12);
        EXPECT_EQ(crowd.state.v[7], Vec3(0, 1, 0));
        EXPECT_LT((out[0].v - Vec3(3 - across / 2, -4 + along / 2, 0)).norm(), 1e-12);
        // r J / (2/5 m r^2)
        EXPECT_LT((out[0].spin - Vec3(0, 0, -across / (0.4 * 2 * 0.5))).norm(), 1e-12);
    }
}

TEST(LatticeContact, TwoBallsShareAPushByTheirMassesAndSizes)
{
    // 2 kg of radius 0.5 m come down on 3 kg of 0.3 m. To stop 4 m/s takes 4 / (1/2 + 1/3) N s; to
    // stop the slip, of 1 m/s and what the lower one's spin of 5 rad/s adds, that over 3.5 times
    // the masses' inverse.
    Crowd crowd(1, 0);
    const double dt = 0.01;
    crowd.state.balls = {{.x = Vec3(0, -0.3, 0), .spin = Vec3(0, 0, 5)},
                         {.x = Vec3(-dt, 0.5, 0), .v = Vec3(1, -4, 0)}};
    const std::vector<Ball> balls = {{.radius = 0.3, .mass = 3, .friction = 4},
                                     {.radius = 0.5, .mass = 2, .friction = 1}};
    const ContactScene scene{crowd.body, crowd.state, crowd.inverse_mass, dt, balls};
    Pushes pushes;
    pushes.balls = find_ball_pushes(scene, {});
    ASSERT_EQ(pushes.balls.size(), 1u);
    std::vector<BallState> out = crowd.state.balls;
    solve_pushes(scene, pushes, 1, crowd.state.v, out);
    const double along = 4 / (1.0 / 2 + 1.0 / 3);
    const double across = (1 + 5 * 0.3) / (3.5 / 2 + 3.5 / 3);
    ASSERT_LT(across, 2 * along);
    EXPECT_LT((out[0].v - Vec3(across / 3, -along / 3, 0)).norm(), 1e-12);
    EXPECT_LT((out[1].v - Vec3(1 - across / 2, -4 + along / 2, 0)).norm(), 1e-12);
    EXPECT_LT((out[0].spin - Vec3(0, 0, 5 - across / (0.4 * 3 * 0.3))).norm(), 1e-12);
    EXPECT_LT((out[1].spin - Vec3(0, 0, -across / (0.4 * 2 * 0.5))).norm(), 1e-12);
}

TEST(LatticeContact, FindsThePointsOfASkinThatASearchOfAllFinds)
{
    // A ball-shaped surface in cubes that only just hold it, crumpled: what is culled a cube at a
    // time is never what touches.
    const Random random(12);
    const geometry::TriMesh surface = geometry::icosphere(0.25, 3);
    const Cubes cubes =
        geometry::voxelize_surface(surface, {{}, {{}}, {}}, 0,
                                   geometry::fit_grid(geometry::triangle_bounds(surface), 0.1), {});
    Crowd crowd(cubes.corner_count(), 1);
    crowd.body = make_corner_body(cubes, {}, &surface);
    crowd.inverse_mass.assign(cubes.corner_count(), 1.0);
    crowd.state.x = geometry::corner_positions(cubes);
    for (std::size_t i = 0; i < cubes.corner_count(); ++i) {
        for (std::size_t d = 0; d < 3; ++d) {
            crowd.state.x[i][Eigen::Index(d)] += 0.06 * (random.unit(3 * i + d) - 0.5);
        }
    }
    const ContactSurface& skin = crowd.body.skin;
    std::vector<Vec3> next;
    for (std::size_t c = 0; c < skin.corners.size(); ++c) {
        for (auto i = skin.on(c).point; i < skin.on(c).points_end; ++i) {
            Vec3& p = next.emplace_back(Vec3::Zero());
            for (std::size_t a = 0; a < 8; ++a) {
                const auto k = skin.corners[c][a];
                p += double(skin.point[i][a]) * (crowd.state.x[k] + 0.01 * crowd.state.v[k]);
            }
        }
    }
    std::size_t all = 0;
    for (std::uint64_t k = 0; k < 40; ++k) {
        Vec3 way(random.unit(900 + 3 * k) - 0.5, random.unit(901 + 3 * k) - 0.5,
                 random.unit(902 + 3 * k) - 0.5);
        way.normalize();
        const double radius = 0.4 + 0.2 * random.unit(2000 + k),  // smaller ones touch faces
            deep = 0.03 * random.unit(3000 + k);
        const std::vector<Ball> balls = {{.radius = radius, .mass = 1}};
        crowd.state.balls = {{.x = (0.25 + radius - deep) * way}};
        const ContactScene scene{crowd.body, crowd.state, crowd.inverse_mass, 0.01, balls};
        Collider other;
        other.kind = Collider::Kind::sphere;
        other.radius = radius;
        other.pose.translation() = other.before.translation() = crowd.state.balls[0].x;
        std::size_t expected = 0;
        for (const Vec3& p : next) expected += (p - crowd.state.balls[0].x).norm() < radius;
        EXPECT_EQ(find_ball_pushes(scene, {}).size(), expected) << k;
        EXPECT_EQ(find_skin_pushes(scene, {pose_collider(other, 1, 0.01, 0.1)}).size(), expected)
            << k;
        all += expected;
    }
    EXPECT_GT(all, 200u);
}

TEST(LatticeContact, PointsOfATornCubeGoWithTheirPart)
{
    // A block and a sheet in two halves, each moved its own way, with all links between them
    // broken: every point is where its half takes it, and moves none of the other's corners.
    for (const bool flat : {false, true}) {
        const Cubes cubes =
            flat ? geometry::plane_cubes(geometry::rectangle_cells(5, 4), {1, 0.1, {0, 0, 0}}, 0.02)
                 : fixtures::box(5, 4, 4, 0.1);
        const Lattice lattice = corner_lattice(cubes);
        const std::vector<Vec3> rest = geometry::corner_positions(cubes);
        const auto beyond = [&](const Vec3& p) { return p[0] > rest[0][0] + 0.25; };
        std::vector<std::uint32_t> broken;
        for (std::uint32_t i = 0; i < lattice.count(); ++i) {
            const std::uint32_t j = lattice.next[i][0];
            if (j != none && beyond(rest[i]) != beyond(rest[j])) broken.push_back(3 * i);
        }
        const auto moved = [&](const Vec3& p, bool other) {
            const Eigen::AngleAxisd turn(other ? 2.0 : -0.7,
                                         Vec3(1, 2, other ? 3 : -1).normalized());
            return Vec3(turn * p + (other ? Vec3(5, 1, 0) : Vec3(0, -1, 2)));
        };
        auto surface = geometry::box(Vec3(0.45, 0.03, 0.33), {3, 1, 1});
        for (Vec3f& p : surface.positions) p += Vec3f(0.263f, 0.2f, 0.2f);
        for (const geometry::TriMesh* mesh : {static_cast<geometry::TriMesh*>(nullptr), &surface}) {
            if (flat && mesh) continue;  // a sheet's points lie in its plane
            const CornerBody body = make_corner_body(cubes, {}, mesh, true);
            const TornSkin torn(body.skin, lattice, broken, 0.1);
            EXPECT_TRUE(torn.bare().empty());
            State state;
            for (const Vec3& p : rest) state.x.push_back(moved(p, beyond(p)));
            state.v.assign(rest.size(), Vec3::Zero());
            const std::vector<double> inverse_mass(rest.size(), 1);
            const ContactScene scene{body, state, inverse_mass, 0.01, {}, &torn};
            Collider ground;
            ground.pose.translate(Vec3(0, 50, 0));
            ground.before = ground.pose;
            std::size_t of_torn = 0, count = 0;
            for (const auto& p : find_skin_pushes(scene, {pose_collider(ground, 1, 0.01, 0.1)})) {
                ++count;
                bool here = false, there = false;
                double total = 0;
                for (std::size_t a = 0; a < 8; ++a) {
                    total += p.weight[a];
                    if (p.weight[a] > 0) (beyond(rest[p.corners[a]]) ? there : here) = true;
                }
                EXPECT_NEAR(total, 1, 1e-6);
                EXPECT_NE(here, there);
                of_torn += std::ranges::any_of(p.corners, [&](auto k) {
                    return beyond(rest[k]) != beyond(rest[p.corners[0]]);
                });
            }
            EXPECT_GE(of_torn, 5u);
            // At rest the same points lie where they did, and moved apart where each half takes
            // them: the depths are those of the rest points, moved.
            std::vector<double> depth, expected;
            for (const auto& p : find_skin_pushes(scene, {pose_collider(ground, 1, 0.01, 0.1)})) {
                depth.push_back(p.bias * 0.01 / 0.2);
            }
            body.skin.corners.for_each(0, body.skin.corners.size(), [&](auto c, const auto& k) {
                const SurfacePatch& patch = body.skin.on(c);
                for (auto i = patch.point; i < (torn.is_open(c) ? patch.points_end : patch.within);
                     ++i) {
                    Vec3 at = Vec3::Zero();
                    for (std::size_t a = 0; a < 8; ++a)
                        at += double(body.skin.point[i][a]) * rest[k[a]];
                    const bool driven_out = i < patch.within;
                    expected.push_back(driven_out ? moved(at, beyond(at))[1] - 50 : 0);
                }
            });
            std::ranges::sort(depth);
            std::ranges::sort(expected);
            ASSERT_EQ(depth.size(), expected.size());
            EXPECT_EQ(count, expected.size());
            for (std::size_t i = 0; i < depth.size(); ++i) EXPECT_NEAR(depth[i], expected[i], 1e-6);
        }
    }
}

TEST(LatticeContact, ACornerLaidBareByATearIsTouched)
{
    // Of a surface in one octant of a cube all corners carry a part, until the last is torn off.
    const Cubes cubes = fixtures::box(1, 1, 1, 0.1);
    const Lattice lattice = corner_lattice(cubes);
    geometry::TriMesh surface;
    surface.positions = {Vec3f(0.01f, 0.01f, 0.01f), Vec3f(0.02f, 0.01f, 0.01f),
                         Vec3f(0.01f, 0.02f, 0.02f)};
    const CornerBody body = make_corner_body(cubes, {}, &surface, true);
    std::vector<std::uint32_t> broken;
    for (std::uint32_t i = 0; i < 8; ++i) {
        for (std::uint32_t d = 0; d < 3; ++d) {
            if (lattice.next[i][d] == 7) broken.push_back(3 * i + d);
        }
    }
    ASSERT_EQ(broken.size(), 3u);
    const TornSkin torn(body.skin, lattice, broken, 0.1);
    ASSERT_EQ(torn.bare().size(), 1u);
    EXPECT_EQ(torn.bare()[0], 7u);
    State state;
    state.x = geometry::corner_positions(cubes);
    state.x[7] = Vec3(3, -2, 0);
    state.v.assign(8, Vec3::Zero());
    state.balls.push_back({.x = Vec3(3, -2.3, 0)});
    const std::vector<double> inverse_mass(8, 1);
    const std::vector<Ball> balls = {{.radius = 0.5}};
    const ContactScene scene{body, state, inverse_mass, 0.01, balls, &torn};
    const auto pushes = find_skin_pushes(scene, {pose_collider(Collider{}, 1, 0.01, 0.1)});
    ASSERT_EQ(pushes.size(), 1u);  // the others are above the ground
    EXPECT_EQ(pushes[0].corners[0], 7u);
    EXPECT_EQ(pushes[0].weight[0], 1);
    EXPECT_EQ(pushes[0].bias, 0);  // it goes no deeper, and is not driven out
    const auto of_ball = find_ball_pushes(scene, {});
    ASSERT_EQ(of_ball.size(), 1u);
    EXPECT_EQ(of_ball[0].corners[0], 7u);
}

TEST(LatticeContact, NoNeighboursGiveNoPushes)
{
    const Crowd crowd(20, 0);
    const PairPushes found = find_pair_pushes(crowd.scene(), crowd.side, crowd.piece, 1e-9, 0.3);
    EXPECT_TRUE(found.row.empty());
    Pushes pushes;
    pushes.pairs = found;
    std::vector<Vec3> v = crowd.state.v;
    std::vector<BallState> balls;
    solve_pushes(crowd.scene(), pushes, 8, v, balls);
    EXPECT_EQ(v, crowd.state.v);
}
