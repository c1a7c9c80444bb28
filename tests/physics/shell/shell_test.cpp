// Shells: forces and their derivative, rigid motion, folds, and what they touch.

#include "geometry/base/random.hpp"
#include "physics/body/point_contact.hpp"
#include "tests/physics/shell/shell_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <numbers>

using namespace physics;
using namespace fixtures;
using geometry::Mat3;
using geometry::Random;

namespace {

// Of two matters, with a hole, an inner corner and a strip one cell wide.
Cubes holed_sheet(int axis)
{
    auto cells = geometry::rectangle_cells(7, 6);
    std::erase(cells, std::array{2, 2});
    std::erase(cells, std::array{6, 5});
    for (int i = 7; i < 10; ++i) cells.push_back({i, 3});
    Cubes cubes = geometry::plane_cubes(cells, {axis, 0.1, {1, 2, 3}}, 0.03,
                                        {"sheet", 500, 1e6, 0.3, 0, 0.01});
    for (std::size_t c = 0; c < cubes.count(); c += 3) {
        cubes.young[c] = 3e6, cubes.poisson[c] = 0.1, cubes.stiffness_damping[c] = 0.02;
    }
    return cubes;
}

void shake(State& state, double by, std::uint64_t seed)
{
    const Random random(seed);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        for (std::size_t i = 0; i < 3; ++i) {
            state.x[k][Eigen::Index(i)] += by * (2 * random.unit(3 * k + i) - 1);
        }
    }
}

}  // namespace

TEST(Shell, TellsTheRateOfEachSheetByItsOwnCells)
{
    // v = 3 x / s stretches every sheet at 3 / s, however wide its cells are.
    const Cubes coarse = sheet(2, 2, 0.1, 0.01), fine = sheet(2, 2, 0.02, 0.002);
    for (const auto& models :
         {std::vector<BodyModel>{{&coarse}, {&fine}}, {{&coarse}}, {{&fine}}}) {
        const ShellBody body = make_shell(BodyModels(models, ModelKind::plane));
        std::vector<Vec3> v;
        for (const Vec3& x : rest_state(body).x) v.emplace_back(3 * x.x(), 0, 0);
        const ShellElasticity elasticity(body, {});
        EXPECT_NEAR(elasticity.largest_rate(by_slot(body.base, v).data()), 3, 1e-12);
    }
}

TEST(Shell, ItsForcesAndTheirDerivativeAreThoseOfItsEnergy)
{
    for (const int axis : {0, 1, 2}) {
        const Cubes cubes = holed_sheet(axis);
        const ShellBody body = make_shell(cubes, {.stretch = 0.5, .bend = 3});
        // Two rows of pins, so that some points are clamps.
        const Pins pins =
            held_where(cubes, [&](const Vec3i& at) { return at[(axis + 1) % 3] < 2; });
        ShellElasticity elasticity(body, pins);
        elasticity.use_hessian(true);
        State state = rest_state(body);
        shake(state, 0.03, 1);
        const Aligned<double> x = by_slot(body.base, state.x);
        const std::size_t n = body.base.numbers;
        Aligned<double> f(n, 0), more(f), less(f), p(f), y(f), unused(f);
        const Random random(2);
        for (std::size_t k = 0; k < body.base.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) p[4 * k + i] = 2 * random.unit(3 * k + i) - 1;
        }
        // Along p by central differences, which err by e^2 of third derivatives over h^2.
        constexpr double e = 1e-6;
        Aligned<double> ahead = x, behind = x;
        for (std::size_t i = 0; i < n; ++i) ahead[i] += e * p[i], behind[i] -= e * p[i];
        elasticity.forces(ahead.data(), more.data());
        elasticity.forces(behind.data(), less.data());
        elasticity.forces(x.data(), f.data());
        elasticity.weigh(1, 0);
        elasticity.multiply(p.data(), y.data());
        double work = 0, wrong = 0, size = 0;
        for (std::size_t i = 0; i < n; ++i) {
            work += f[i] * p[i];
            wrong += std::pow((less[i] - more[i]) / (2 * e) - y[i], 2);
            size += y[i] * y[i];
        }
        const double slope =
            (elasticity.energy(behind.data()) - elasticity.energy(ahead.data())) / (2 * e);
        EXPECT_NEAR(slope / work, 1, 1e-6) << axis;
        EXPECT_LT(std::sqrt(wrong / size), 1e-6) << axis;
    }
}

TEST(Shell, ChangesItsDerivativeWhereItStands)
{
    const ShellBody body = make_shell(holed_sheet(1));
    State state = rest_state(body);
    shake(state, 0.03, 1);
    const Aligned<double> x = by_slot(body.base, state.x), p = by_slot(body.base, state.x);
    Aligned<double> f(body.base.numbers, 0), fresh(f), changed(f);
    ShellElasticity positive(body, {}), whole(body, {});
    positive.forces(x.data(), f.data());
    positive.weigh(1, 0);
    positive.multiply(p.data(), fresh.data());
    whole.use_hessian(true);
    whole.forces(x.data(), f.data());
    whole.weigh(1, 0);
    whole.multiply(p.data(), changed.data());
    EXPECT_NE(fresh, changed);
    whole.use_hessian(false);
    whole.multiply(p.data(), changed.data());
    EXPECT_EQ(fresh, changed);
}

TEST(Shell, TheMatricesOfItsElementsAddUpToItsMatrix)
{
    for (const bool even : {true, false}) {
        Cubes cubes = holed_sheet(1);
        if (even) std::fill(cubes.stiffness_damping.begin(), cubes.stiffness_damping.end(), 0.01);
        const ShellBody body = make_shell(cubes);
        ShellElasticity elasticity(body, {});
        State state = rest_state(body);
        shake(state, 0.03, 4);
        const std::size_t n = body.base.numbers;
        Aligned<double> f(n, 0), p(f), y(f), diagonal(f);
        elasticity.forces(by_slot(body.base, state.x).data(), f.data());
        elasticity.weigh(0.3, 7);
        for (std::size_t i = 0; i < n; ++i) p[i] = i % 4 == 3 ? 0 : std::sin(double(i));
        elasticity.multiply(p.data(), y.data());
        elasticity.add_diagonal(diagonal.data());
        std::vector<BrickMatrix> matrices;
        ASSERT_TRUE(elasticity.cube_matrices(matrices));
        ASSERT_EQ(matrices.size(), body.elements.count());
        std::vector<Vec3> sum(body.base.corners, Vec3::Zero()), own = sum;
        for (std::size_t e = 0; e < matrices.size(); ++e) {
            const auto& corners = body.elements.corners[e];
            for (Eigen::Index a = 0; a < 8; ++a) {
                const auto k = corners[std::size_t(a)];
                own[k] += matrices[e].block<3, 3>(3 * a, 3 * a).diagonal();
                for (Eigen::Index b = 0; b < 8; ++b) {
                    sum[k] += matrices[e].block<3, 3>(3 * a, 3 * b) *
                              Eigen::Map<const Vec3>(&p[4 * std::size_t(corners[std::size_t(b)])]);
                }
            }
            // Each lies between two neighbouring planes of the grid that the factor is cut along.
            for (const auto k : corners) {
                const Vec3i apart = body.elements.corner[k] - body.elements.corner[corners[0]];
                EXPECT_LE(apart.cwiseAbs().maxCoeff(), 1);
            }
        }
        for (std::size_t k = 0; k < sum.size(); ++k) {
            const double size = own[k].norm();
            EXPECT_LT((sum[k] - Eigen::Map<Vec3>(&y[4 * k])).norm(), 1e-12 * size);
            EXPECT_LT((own[k] - Eigen::Map<Vec3>(&diagonal[4 * k])).norm(), 1e-12 * size);
        }
    }
}

TEST(Shell, AtRestUnderAnyRigidMotionStaysThere)
{
    const ShellBody body = make_shell(holed_sheet(2));
    const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    State state = rest_state(body);
    for (Vec3& x : state.x) x = turn * x + Vec3(5, 6, 7);
    const State before = state;
    for (int i = 0; i < 5; ++i) state = advance(body, state, {}, 1.0 / 24);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        EXPECT_LT((state.x[k] - before.x[k]).norm(), 1e-12);
        EXPECT_LT(state.v[k].norm(), 1e-11);
    }
}

TEST(Shell, FreeSpinAndFallKeepItsMomenta)
{
    const Cubes cubes = holed_sheet(1);
    const ShellBody body = make_shell(cubes);
    State state = rest_state(body);
    shake(state, 0.01, 3);
    const auto centre = [&](const std::vector<Vec3>& of) {
        Vec3 sum = Vec3::Zero();
        double mass = 0;
        for (std::size_t k = 0; k < of.size(); ++k) {
            sum += body.base.mass[k] * of[k], mass += body.base.mass[k];
        }
        return Vec3(sum / mass);
    };
    const auto spin = [&] {
        const Vec3 c = centre(state.x), v = centre(state.v);
        Vec3 sum = Vec3::Zero();
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            sum += body.base.mass[k] * (state.x[k] - c).cross(state.v[k] - v);
        }
        return sum;
    };
    for (Vec3& v : state.v) v = {1, 2, 3};
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        state.v[k] += Vec3(0.5, 3, 1).cross(state.x[k] - centre(state.x));
    }
    const Vec3 velocity = centre(state.v), momentum = spin();
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    for (int i = 0; i < 24; ++i) state = advance(body, state, loads, 1.0 / 24);
    EXPECT_LT((centre(state.v) - velocity - Vec3(0, -9.81, 0)).norm(), 1e-11);
    EXPECT_LT((spin() - momentum).norm(), 1e-9 * momentum.norm());
}

TEST(Shell, RecoversFromAnyDeformation)
{
    const Random random(3);
    using Move = std::function<Vec3(const Vec3&, std::uint64_t)>;
    const std::vector<std::pair<std::string, Move>> cases = {
        {"pressed",
         [](const Vec3& x, std::uint64_t) { return Vec3(0.2 * x[0], 1e-3 * x[2], x[2]); }},
        // Folded over, a hair apart: exactly flat, nothing says to which side it should open.
        {"folded",
         [](const Vec3& x, std::uint64_t) {
             return Vec3(std::abs(x[0] - 0.3), 1e-3 * std::max(0.0, x[0] - 0.3), x[2]);
         }},
        {"rolled",
         [](const Vec3& x, std::uint64_t) {
             return Vec3(0.1 * std::cos(10 * x[0]), 0.1 * std::sin(10 * x[0]), x[2]);
         }},
        {"random",
         [&](const Vec3&, std::uint64_t i) {
             return Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2));
         }},
    };
    const ShellBody body = make_shell(sheet(6, 5, 0.1, 0.02));
    for (const auto& [name, move] : cases) {
        State state = rest_state(body);
        for (std::size_t i = 0; i < state.x.size(); ++i) state.x[i] = move(state.x[i], i);
        for (int frame = 0; frame < 200; ++frame) state = advance(body, state, {}, 0.1);
        EXPECT_LT(misfit(rest_state(body), state), 1e-3 * 0.8) << name;
    }
}

TEST(Shell, SlidesDownASlopeAsFrictionLets)
{
    // With weight at an angle of 30 degrees and mu = 0.3: a = g (sin 30 - 0.3 cos 30). With mu =
    // 0.7 above tan 30 it stays.
    const Cubes cubes = sheet(4, 4, 0.1, 0.005);
    const ShellBody body = make_shell(cubes);
    const double g = 9.81, down = g / 2, into = g * std::sqrt(0.75);
    for (const double friction : {0.3, 0.7}) {
        Loads loads;
        loads.forces = {weight({down, -into, 0})};
        loads.colliders.resize(1);
        loads.colliders[0].friction = friction;
        State state = rest_state(body);
        for (int i = 0; i < 12; ++i) state = advance(body, state, loads, 1.0 / 24);
        const double expected = 0.5 * std::max(0.0, down - friction * into);
        for (const Vec3& v : state.v) EXPECT_NEAR(v.x(), expected, 0.02 * 0.5 * down) << friction;
        for (const Vec3& x : state.x) EXPECT_NEAR(x.y(), 0.0025, 1e-4);  // half its thickness
    }
}

// With its middle on the floor, half of it inside, a thick sheet is lifted and not thrown.
TEST(Shell, StartsOnAFloorWithoutAHop)
{
    const ShellBody body = make_shell(sheet(4, 4, 0.1, 0.05));
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    loads.colliders.resize(1);
    State state = rest_state(body);
    double highest = 0;
    for (int i = 0; i < 24; ++i) {
        state = advance(body, state, loads, 1.0 / 24, {.substeps = 8});
        for (const Vec3& x : state.x) highest = std::max(highest, x.y());
    }
    EXPECT_LT(highest, 0.026);
    for (const Vec3& x : state.x) EXPECT_NEAR(x.y(), 0.025, 5e-4);
}

// 5 mm and more below it likewise, however many steps a frame has.
TEST(Shell, ComesOutOfAFloorWithoutAHop)
{
    const ShellBody body = make_shell(sheet(6, 6, 0.05, 0.002, 0.3, 1e6, 300));
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    loads.colliders.resize(1);
    for (const double deep : {0.005, 0.05}) {
        for (const int substeps : {0, 1, 8}) {
            State state = rest_state(body);
            for (Vec3& x : state.x) x.y() -= deep;
            double highest = 0;
            for (int i = 0; i < 36; ++i) {
                state = advance(body, state, loads, 1.0 / 24, {.substeps = substeps});
                for (const Vec3& x : state.x) highest = std::max(highest, x.y());
            }
            EXPECT_LT(highest, 0.0015) << deep << substeps;
            for (const Vec3& x : state.x) EXPECT_NEAR(x.y(), 0.001, 1e-4) << deep << substeps;
        }
    }
}

TEST(Shell, LiesOnAFloorAtHalfOfItsThickness)
{
    const Cubes thin = sheet(4, 4, 0.1, 0.004), thick = sheet(4, 4, 0.1, 0.03);
    const BodyModel models[] = {{&thin, nullptr}, {&thick, nullptr}};
    const ShellBody body = make_shell(BodyModels(models, ModelKind::plane));
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    loads.colliders.resize(1);
    loads.colliders[0].thickness = 0.01;
    State state = rest_state(body);
    for (Vec3& x : state.x) x.y() += 0.02;
    for (std::size_t k = thin.corner_count(); k < state.x.size(); ++k) state.x[k].x() += 1;
    for (int i = 0; i < 48; ++i) state = advance(body, state, loads, 1.0 / 24, {.substeps = 2});
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        const double half = k < thin.corner_count() ? 0.002 : 0.015;
        EXPECT_NEAR(state.x[k].y(), 0.01 + half, 2e-4) << k;
    }
}

// A sheet on its contacts stores next to no energy: what their springs give and take there in a
// step is no gain.
TEST(Shell, ComesToRestOnAFloor)
{
    const ShellBody body = make_shell(sheet(12, 12, 0.05, 0.002, 0.3, 1e6, 300));
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    loads.colliders.resize(1);
    State state = rest_state(body);
    for (Vec3& x : state.x) x.y() += 0.1;
    for (int frame = 0; frame < 24; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, {.substeps = 0});
        EXPECT_TRUE(state.report.converged) << frame;
        EXPECT_LE(state.report.steps, 8) << frame;
    }
    EXPECT_TRUE(state.report.slept);
    for (const Vec3& x : state.x) EXPECT_NEAR(x.y(), 0.001, 1e-5);
}

TEST(Shell, FallsNoFasterThanTheAirLetsIt)
{
    // A level sheet of m / A = 1 kg/m^2 in still air: m g = 1/2 rho C A v^2, v = 4.04 m/s.
    const ShellBody body = make_shell(sheet(4, 4, 0.1, 0.001));
    Force air;
    air.kind = Force::Kind::wind;
    Loads loads;
    loads.forces = {weight({0, -9.81, 0}), air};
    State state = rest_state(body);
    for (int i = 0; i < 48; ++i) state = advance(body, state, loads, 1.0 / 24);
    for (const Vec3& v : state.v) EXPECT_NEAR(v.y(), -std::sqrt(2 * 9.81 / 1.2), 0.01);
    // At the speed that it keeps it goes as far as that takes it.
    const State before = state;
    state = advance(body, before, loads, 1.0 / 24);
    EXPECT_NEAR(before.x[0].y() - state.x[0].y(), std::sqrt(2 * 9.81 / 1.2) / 24, 2e-3);
}

TEST(Shell, FollowsPinsThatMove)
{
    // Two rows carry a strip along at 1 m/s and turn it over in the first second. It is so stiff,
    // 41 rad/s, that steps of 1/48 s leave no swing of it.
    const Cubes cubes = sheet(8, 2, 0.1, 0.02, 0.3, 1e9);
    const ShellBody body = make_shell(cubes);
    Loads loads;
    loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] < 2; });
    State state = rest_state(body);
    const auto turned = [&](std::uint32_t k, double time) {
        const Eigen::AngleAxisd turn(std::numbers::pi * std::min(time, 1.0), Vec3::UnitX());
        return Vec3(Vec3(time, 0, 0) + turn * cubes.corner_position(k));
    };
    for (int i = 1; i <= 96; ++i) {
        for (std::size_t p = 0; p < loads.pins.corner.size(); ++p) {
            loads.pins.target[p] = turned(loads.pins.corner[p], i / 24.0);
        }
        state = advance(body, state, loads, 1.0 / 24, {.substeps = 2});
    }
    for (std::uint32_t k = 0; k < state.x.size(); ++k) {
        EXPECT_LT((state.x[k] - turned(k, 4)).norm(), 0.02) << k;
    }
}

TEST(Shell, WhatTouchesIsPartOfItsElements)
{
    // A point of a cell, with weights that its two sides share: w w^T times the block is added.
    const Cubes cubes = holed_sheet(1);
    const ShellBody body = make_shell(cubes);
    ShellElasticity elasticity(body, {});
    Aligned<double> f(body.base.numbers, 0);
    elasticity.forces(body.base.rest.data(), f.data());
    elasticity.weigh(1, 0);
    std::vector<BrickMatrix> before, after;
    elasticity.cube_matrices(before);
    after = before;
    PointContact contact;
    contact.corners = {};
    std::copy(cubes.corners[7].begin(), cubes.corners[7].end(), contact.corners.begin());
    contact.weight = {0.1f, 0.2f, 0, 0.1f, 0.3f, 0.2f, 0.1f, 0};
    Mat3 block;
    block << 3, 1, 0, 1, 2, 0.5, 0, 0.5, 4;
    elasticity.add_contact(contact, block, after);
    const auto sum_over = [&](const std::vector<BrickMatrix>& all, std::uint32_t i,
                              std::uint32_t j) {
        Mat3 sum = Mat3::Zero();
        for (std::size_t e = 0; e < all.size(); ++e) {
            for (Eigen::Index a = 0; a < 8; ++a) {
                for (Eigen::Index b = 0; b < 8; ++b) {
                    const auto& k = body.elements.corners[e];
                    if (k[std::size_t(a)] != i || k[std::size_t(b)] != j) continue;
                    sum += all[e].block<3, 3>(3 * a, 3 * b);
                }
            }
        }
        return sum;
    };
    const auto weight_of = [&](std::uint32_t k) {
        double sum = 0;
        for (std::size_t a = 0; a < 8; ++a) {
            if (contact.corners[a] == k) sum += double(contact.weight[a]);
        }
        return sum;
    };
    for (const auto i : cubes.corners[7]) {
        for (const auto j : cubes.corners[7]) {
            const Mat3 added = sum_over(after, i, j) - sum_over(before, i, j);
            EXPECT_LT((added - weight_of(i) * weight_of(j) * block).norm(), 1e-9);
        }
    }
}

TEST(Shell, GivesTheSameBytesForAnyNumberOfThreads)
{
    const Cubes cubes = sheet(40, 40, 0.05, 0.005);
    const ShellBody body = make_shell(cubes);
    Loads loads;
    loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] == 0 && at[2] % 20 == 0; });
    loads.forces = {weight({0, -9.81, 0})};
    const auto run = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        State state = rest_state(body);
        for (int i = 0; i < 2; ++i) state = advance(body, state, loads, 1.0 / 24);
        return state;
    };
    const State one = run(1), two = run(2);
    EXPECT_EQ(one.x, two.x);
    EXPECT_EQ(one.v, two.v);
}

TEST(Shell, RefusesCubesThatAreNoPlane)
{
    const auto said = [](const Cubes& cubes, const ShellOptions& options) -> std::string {
        try {
            make_shell(cubes, options);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "nothing was refused";
    };
    const Cubes solid = geometry::solid_cubes({{0, 0, 0}}, 0.1);
    EXPECT_NE(said(solid, {}).find("use method bricks"), std::string::npos) << said(solid, {});
    const Cubes plane = sheet(2, 2, 0.1, 0.01);
    EXPECT_EQ(said(plane, {}), "nothing was refused");
    EXPECT_NE(said(plane, {.stretch = 0}).find("a stretch above 0"), std::string::npos);
    EXPECT_NE(said(plane, {.bend = -1}).find("found 1 and -1"), std::string::npos);
}
