// Numerical stability of lattice shape matching where it is hard: solids and planes.

#include "geometry/plane.hpp"
#include "geometry/primitive.hpp"
#include "geometry/random.hpp"
#include "physics/lattice.hpp"
#include "physics/torn_regions.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>

using namespace physics;
using fixtures::box;
using geometry::Cubes;
using geometry::Random;
using geometry::Vec3i;

namespace {

Cubes whole_sheet(int ni, int nj)
{
    return geometry::plane_cubes(geometry::rectangle_cells(ni, nj), {1, 0.1, {0, 0, 0}}, 0.02,
                                 {"sheet", 500, 1e5, 0.3, 0, 0});
}

// The same cubes once more, `by` cells away and not linked to the first.
Cubes with_copy(const Cubes& one, const Vec3i& by)
{
    Cubes both = one;
    for (std::size_t c = 0; c < one.count(); ++c) {
        both.cell.push_back(one.cell[c] + by);
        auto corners = one.corners[c];
        for (auto& k : corners) k += std::uint32_t(one.corner_count());
        both.corners.push_back(corners);
        both.mass.push_back(one.mass[c]);
        both.fill.push_back(one.fill[c]);
        both.young.push_back(one.young[c]);
        both.poisson.push_back(one.poisson[c]);
        both.mass_damping.push_back(one.mass_damping[c]);
        both.stiffness_damping.push_back(one.stiffness_damping[c]);
        both.matter.push_back(one.matter[c]);
    }
    for (const Vec3i& at : one.corner) both.corner.push_back(at + by);
    return both;
}

double largest_x(const State& state)
{
    double most = 0;
    for (const Vec3& x : state.x) most = std::max(most, x.norm());
    return most;
}

double extent_in_x(const State& state)
{
    double low = 1e9, high = -1e9;
    for (const Vec3& x : state.x) low = std::min(low, x[0]), high = std::max(high, x[0]);
    return high - low;
}

double longest_link(const LatticeBody& body, const Cubes& cubes, const State& state)
{
    double most = 0;
    const Lattice lattice = corner_lattice(cubes);
    for (std::size_t i = 0; i < lattice.count(); ++i) {
        for (const auto j : lattice.next[i]) {
            if (j != none) most = std::max(most, (state.x[i] - state.x[j]).norm());
        }
    }
    return most / body.base.h;
}

double energy(const LatticeBody& body, const State& state)
{
    double sum = 0;
    for (std::size_t i = 0; i < state.v.size(); ++i) {
        sum += 0.5 * body.base.mass[i] * state.v[i].squaredNorm();
    }
    return sum;
}

void expect_sane(const State& state, const char* what)
{
    for (const Vec3& x : state.x) ASSERT_TRUE(x.allFinite()) << what;
    for (const Vec3& v : state.v) ASSERT_TRUE(v.allFinite()) << what;
}

// Both ends held, the far one moved by `motion` of the share of the way.
State drive(const LatticeBody& body, const Cubes& cubes, State state, int frames,
            const LatticeOptions& options,
            const std::function<Vec3(const Vec3&, double share)>& motion)
{
    int last = 0;
    for (const auto& at : cubes.corner) last = std::max(last, at[0]);
    for (int f = 1; f <= frames; ++f) {
        Loads loads;
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k][0] != 0 && cubes.corner[k][0] != last) continue;
            const Vec3 rest = cubes.corner_position(k);
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner[k][0] == 0 ? rest
                                                                : motion(rest, double(f) / frames));
        }
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
    }
    return state;
}

// How much too long a link is after ten seconds, let go from that shape: in air so thick that
// neither slow bending nor a spin, which would stretch it, is left.
double misfit_after_rest(const LatticeBody& body, const Cubes& cubes, State state,
                         LatticeOptions options)
{
    options.damping = 0.05;
    for (Vec3& v : state.v) v.setZero();
    for (int f = 0; f < 240; ++f) {
        state = advance(body, std::move(state), {}, 1.0 / 24, options);
        for (Vec3& v : state.v) v *= 0.8;
    }
    return longest_link(body, cubes, state) - 1;
}

}  // namespace

TEST(LatticeHardCases, TwistedByTwoTurnsAndLetGo)
{
    for (const bool flat : {false, true}) {
        const Cubes cubes = flat ? whole_sheet(12, 3) : box(12, 2, 2, 0.1, {500, 1e5, 0.3});
        const LatticeOptions options{.half_width = 2, .damping = 0.01, .substeps = 16};
        const LatticeBody body = make_lattice(cubes, options);
        const Vec3 axis = flat ? Vec3(0, 0, 0.15) : Vec3(0, 0.1, 0.1);
        State state = drive(
            body, cubes, rest_state(body), 48, options, [&](const Vec3& x, double share) -> Vec3 {
                const Eigen::AngleAxisd turn(4 * std::numbers::pi * share, Vec3::UnitX());
                return turn * (x - axis) + axis;
            });
        expect_sane(state, "twisted");
        EXPECT_LT(longest_link(body, cubes, state), 4);
        EXPECT_LT(misfit_after_rest(body, cubes, state, options), 1e-3) << flat;
    }
}

TEST(LatticeHardCases, StretchedTenTimesAndLetGo)
{
    for (const bool flat : {false, true}) {
        const Cubes cubes = flat ? whole_sheet(8, 3) : box(8, 2, 2, 0.1, {500, 1e5, 0.3});
        const LatticeOptions options{.half_width = 1, .damping = 0.01, .substeps = 16};
        const LatticeBody body = make_lattice(cubes, options);
        const State state =
            drive(body, cubes, rest_state(body), 24, options, [](const Vec3& x, double share) {
                return Vec3(x[0] * (1 + 9 * share), x[1], x[2]);
            });
        expect_sane(state, "stretched");
        EXPECT_GT(longest_link(body, cubes, state), 5);
        EXPECT_LT(misfit_after_rest(body, cubes, state, options), 1e-3) << flat;
    }
}

TEST(LatticeHardCases, NeighboursOfAMillionTimesTheMassOrStiffness)
{
    // Cubes of one body differ by 1e6, at random. Under gravity, held at one end, which is as much
    // as the uniform body can bear: its links there get more than three times as long. No blow-up,
    // and neither the light nor the soft parts hang on longer links than that.
    const Random random(7);
    double uniform = 0;
    for (int kind = 0; kind < 3; ++kind) {
        Cubes cubes = box(8, 3, 3, 0.1, {1000, 1e5, 0.3});
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            if (random.unit(c) < 0.5) continue;
            if (kind == 1) cubes.mass[c] *= 1e-6;
            if (kind == 2) cubes.young[c] *= 1e6;
        }
        const LatticeOptions options{.half_width = 2, .damping = 0.005, .substeps = 8};
        const LatticeBody body = make_lattice(cubes, options);
        Loads loads;
        loads.forces.push_back({});
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k][0] > 0) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        State state = rest_state(body);
        double longest = 0;
        for (int f = 0; f < 96; ++f) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
            longest = std::max(longest, longest_link(body, cubes, state));
        }
        expect_sane(state, "ratios");
        if (kind == 0) uniform = longest;
        EXPECT_LT(longest, 1.5 * uniform) << kind;
        // Stiffer than substeps can give: that is said.
        EXPECT_EQ(state.report.converged, kind != 2);
    }
}

TEST(LatticeHardCases, StepsOfAMillisecondToTenSecondsAtAnyStiffness)
{
    const double infinite = std::numeric_limits<double>::infinity();
    for (const bool flat : {false, true}) {
        const Cubes cubes = flat ? whole_sheet(6, 5) : box(5, 3, 2, 0.1);
        for (const double rate : {0.0, 1e-3, 30.0, 1e9, infinite}) {
            for (const double bend : {0.0, 1.0, infinite}) {
                if (!flat && bend != 1) continue;
                LatticeOptions options{.half_width = 2,
                                       .stiffness = Stiffness::rate,
                                       .rate = rate,
                                       .bend = bend,
                                       .damping = 1e-3,
                                       .substeps = 1};
                const LatticeBody body = make_lattice(cubes, options);
                for (const double dt : {1e-3, 1.0 / 24, 1.0, 10.0}) {
                    Loads loads;
                    loads.forces.push_back({});
                    loads.colliders.push_back({});
                    State state = rest_state(body);
                    for (Vec3& x : state.x) x[1] += 0.3;
                    for (int f = 0; f < 60; ++f) {
                        state = advance(body, std::move(state), loads, dt, options);
                    }
                    expect_sane(state, "steps");
                    EXPECT_TRUE(state.report.converged);
                    // Contact holds the corners outside; those inside fall g dt^2 in a step before
                    // their regions bring them back, and what is soft goes as far and back.
                    if (rate >= 30) {
                        EXPECT_LT(largest_x(state), 1 + 2 * 9.81 * dt * dt) << rate << " " << dt;
                    }
                }
            }
        }
    }
}

TEST(LatticeHardCases, AHundredThousandStepsOfTumbling)
{
    // A free spinning body: momentum as it began, shape within a few per cent (it turns by 0.02 rad
    // a step and swells by its own centrifugal force), no creeping energy.
    for (const bool flat : {false, true}) {
        const Cubes cubes = flat ? whole_sheet(2, 2) : box(2, 1, 1, 0.1);
        const LatticeOptions options{.half_width = 1,
                                     .stiffness = Stiffness::rate,
                                     .rate = 200,
                                     .damping = 1e-4,
                                     .substeps = 1000};
        const LatticeBody body = make_lattice(cubes, options);
        State state = rest_state(body);
        const Vec3 spin(3, 1, -2);
        Vec3 centre = Vec3::Zero();
        double mass = 0;
        for (std::size_t i = 0; i < state.x.size(); ++i) {
            centre += body.base.mass[i] * state.x[i];
            mass += body.base.mass[i];
        }
        centre /= mass;
        for (std::size_t i = 0; i < state.x.size(); ++i) {
            state.v[i] = spin.cross(Vec3(state.x[i] - centre));
        }
        const auto angular = [&] {
            Vec3 sum = Vec3::Zero();
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                sum += body.base.mass[i] * state.x[i].cross(state.v[i]);
            }
            return sum;
        };
        const Vec3 before = angular();
        const double start = energy(body, state);
        for (int f = 0; f < 100; ++f) state = advance(body, std::move(state), {}, 5, options);
        expect_sane(state, "tumbling");
        EXPECT_LT((angular() - before).norm(), 1e-9 * before.norm());
        EXPECT_NEAR(longest_link(body, cubes, state), 1, 0.05);
        EXPECT_LE(energy(body, state), 1.01 * start);
    }
}

TEST(LatticeHardCases, AHundredThousandStepsOfVibrationDoNotGainEnergy)
{
    for (const bool flat : {false, true}) {
        const Cubes cubes = flat ? whole_sheet(2, 1) : box(1, 1, 1, 0.1);
        const LatticeOptions options{.half_width = 1,
                                     .stiffness = Stiffness::rate,
                                     .rate = 100,
                                     .bend = 0.5,
                                     .damping = 0,
                                     .substeps = 1000,
                                     .precision = Precision::full};
        const LatticeBody body = make_lattice(cubes, options);
        State state = rest_state(body);
        for (Vec3& x : state.x) x[0] *= 1.1;
        double early = 0, late = 0;
        for (int f = 0; f < 100; ++f) {
            // 1000 steps of 5 ms: s dt = 0.5.
            state = advance(body, std::move(state), {}, 5, options);
            for (int probe = 0; probe < 10; ++probe) {
                LatticeOptions one = options;
                one.substeps = 1;
                state = advance(body, std::move(state), {}, 0.005, one);
                double& most = f < 10 ? early : late;
                most = std::max(most, energy(body, state));
            }
        }
        EXPECT_GT(late, 0.5 * early);
        EXPECT_LT(late, 1.2 * early);
    }
}

TEST(LatticeHardCases, AQuarterOfTheStepGivesTheSameMotion)
{
    for (const bool flat : {false, true}) {
        const Cubes cubes = flat ? whole_sheet(10, 4) : box(10, 2, 2, 0.1, {1000, 1e5, 0.3});
        const auto run = [&](int substeps) {
            const LatticeOptions options{.half_width = 1, .substeps = substeps};
            const LatticeBody body = make_lattice(cubes, options);
            Loads loads;
            loads.forces.push_back({});
            for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
                if (cubes.corner[k][0] > 0) continue;
                loads.pins.corner.push_back(k);
                loads.pins.target.push_back(cubes.corner_position(k));
            }
            State state = rest_state(body);
            for (int f = 0; f < 12; ++f) {
                state = advance(body, std::move(state), loads, 1.0 / 24, options);
            }
            return state;
        };
        // s dt = 0.5 or less at either: the difference is the order of the step times the motion.
        const State coarse = run(12), fine = run(48);
        double apart = 0, moved = 0;
        for (std::size_t k = 0; k < coarse.x.size(); ++k) {
            apart = std::max(apart, (coarse.x[k] - fine.x[k]).norm());
            moved = std::max(moved, (fine.x[k] - cubes.corner_position(k)).norm());
        }
        EXPECT_GT(moved, 0.1);
        EXPECT_LT(apart, 0.03 * moved) << flat;
    }
}

TEST(LatticePlasticity, ABarBentBeyondItsYieldStaysBent)
{
    const Cubes cubes = box(10, 2, 2, 0.1, {1000, 1e5, 0.3});
    const auto tip_after = [&](double yield) {
        LatticeOptions options{.half_width = 1, .damping = 0.01, .substeps = 12};
        options.plastic.yield = yield;
        const LatticeBody body = make_lattice(cubes, options);
        // Pulled out to twice its length for a second, then left alone.
        State state =
            drive(body, cubes, rest_state(body), 24, options,
                  [](const Vec3& x, double share) { return Vec3(x[0] * (1 + share), x[1], x[2]); });
        options.damping = 0.05;
        for (int f = 0; f < 120; ++f)
            state = advance(body, std::move(state), {}, 1.0 / 24, options);
        return extent_in_x(state);
    };
    EXPECT_NEAR(tip_after(0), 1, 5e-3);
    const double stayed = tip_after(0.05);
    EXPECT_GT(stayed, 1.15);             // it flowed,
    EXPECT_LT(stayed, 1.9);              // and what was elastic went back
    EXPECT_NEAR(tip_after(2), 1, 5e-3);  // never strained so far
}

TEST(LatticePlasticity, FlowKeepsTheVolumeAndTheLimit)
{
    const Cubes cubes = box(3, 3, 3, 0.1);
    LatticeOptions options{
        .half_width = 1, .stiffness = Stiffness::rate, .rate = 300, .substeps = 8};
    options.plastic = {.yield = 0.01, .flow = 1000, .limit = 0.3};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    for (Vec3& x : state.x) x = Vec3(2 * x[0], 0.8 * x[1], 0.8 * x[2]);
    for (int f = 0; f < 4; ++f) state = advance(body, std::move(state), {}, 1.0 / 24, options);
    ASSERT_EQ(state.plastic.size(), 6 * body.whole.regions.slots());
    double most = 0;
    for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
        const float* p = state.plastic.data() + 6 * s;
        Eigen::Matrix3d change;
        change << double(p[0]), double(p[1]), double(p[2]), double(p[1]), double(p[3]),
            double(p[4]), double(p[2]), double(p[4]), double(p[5]);
        EXPECT_LE(change.norm(), 0.3 + 1e-6);
        most = std::max(most, change.norm());
    }
    EXPECT_GT(most, 0.1);
    expect_sane(state, "plastic");
}

TEST(LatticePlasticity, FlowsByItsStrainBeyondTheYield)
{
    // Stretched evenly, whichever way it is turned, all regions are strained by the stretch over
    // what has flowed, less 1. Of that a share 1 - exp(-flow dt) of what is beyond the yield is
    // added, a fifth in a step at most, at constant volume, up to the limit.
    struct Case {
        double flow, limit;
    };
    const double dt = 0.01, yield = 0.1;
    const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    for (const bool flat : {false, true}) {
        for (const Case& c : {Case{20, 0.9}, Case{1e6, 0.9}, Case{1e6, 0.15}}) {
            LatticeOptions options{.half_width = 1,
                                   .stiffness = Stiffness::rate,
                                   .rate = 10,
                                   .substeps = 1,
                                   .precision = Precision::full};
            options.plastic = {.yield = yield, .flow = c.flow, .limit = c.limit};
            const Cubes cubes = flat ? whole_sheet(4, 3) : box(3, 3, 3, 0.1);
            const LatticeBody body = make_lattice(cubes, options);
            const Vec3 stretch = flat ? Vec3(1.4, 1, 0.9) : Vec3(1.5, 0.9, 0.8), one = Vec3::Ones();
            Vec3 shape = one;
            State state = rest_state(body);
            for (int step = 0; step < 2; ++step) {
                for (std::size_t i = 0; i < state.x.size(); ++i) {
                    state.x[i] = turn * stretch.cwiseProduct(cubes.corner_position(i));
                    state.v[i].setZero();
                }
                state = advance(body, state, {}, dt, options);
                const Vec3 strain = stretch.cwiseQuotient(shape) - one;
                const double size = strain.norm();
                const double give = (1 - std::exp(-c.flow * dt)) * (1 - yield / size);
                shape = shape.cwiseProduct(one + std::min(give, 0.2 / size) * strain);
                if (!flat) shape /= std::cbrt(shape.prod());
                const double change = (shape - one).norm();
                shape = one + std::min(1.0, c.limit / change) * (shape - one);
                for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
                    if (body.whole.regions.particle[s] == none) continue;
                    const float* const p = state.plastic.data() + 6 * s;
                    const Vec3 got(p[0], p[3], p[5]);
                    // Kept in single precision.
                    ASSERT_LT((one + got - shape).norm(), 1e-6) << flat << c.flow << step;
                    ASSERT_LT(std::abs(p[1]) + std::abs(p[2]) + std::abs(p[4]), 1e-6f);
                }
            }
        }
    }
}

TEST(LatticePlasticity, WhatHasFlowedRestsUnderAnyRigidMotion)
{
    // S sheared, the same everywhere: x = R S X is at rest, in solids, sheets and in the plane.
    Mat3 shape;
    shape << 1.25, 0, 0.125, 0, 1, 0, 0.125, 0, 0.875;
    for (int kind = 0; kind < 3; ++kind) {
        for (const Precision precision : {Precision::full, Precision::single}) {
            LatticeOptions options{.half_width = 2,
                                   .stiffness = Stiffness::rate,
                                   .rate = 1e4,
                                   .bend = 0.3,
                                   .substeps = 1,
                                   .precision = precision};
            if (kind == 2) options.plane = PlaneMotion::in_plane;
            options.plastic.yield = 10;
            const Cubes cubes = kind == 0 ? box(4, 3, 5, 0.1) : whole_sheet(7, 5);
            const LatticeBody body = make_lattice(cubes, options);
            const Vec3 about = kind == 2 ? Vec3(Vec3::UnitY()) : Vec3(1, -2, 3).normalized();
            const Mat3 turn = Eigen::AngleAxisd(2, about).toRotationMatrix();
            State state = rest_state(body);
            for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
                const float packed[6] = {0.25f, 0, 0.125f, 0, 0, -0.125f};
                state.plastic.insert(state.plastic.end(), packed, packed + 6);
            }
            for (Vec3& x : state.x) x = turn * shape * x + Vec3(0.2, 0, 0.3);
            const State after = advance(body, state, {}, 0.01, options);
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                // Rounding of places below 1 m, in single precision a few times over. A membrane
                // keeps the inverse of S in single precision in any case.
                ASSERT_LT((after.x[i] - state.x[i]).norm(), precision == Precision::single ? 2e-6
                                                            : kind == 1                    ? 1e-7
                                                                                           : 1e-14)
                    << kind;
            }
        }
    }
}

TEST(LatticePlasticity, ACellOfAMembraneHasFlowedAsItsCornersHaveOnTheAverage)
{
    // Regions that do not resist leave all to the membrane: one cell, whose corners' regions have
    // flowed by e each, differently in every direction, moves as one whose regions all have by the
    // mean of the four e. In one step from rest, as S has no say in where the regions are.
    LatticeOptions options{.half_width = 1,
                           .stiffness = Stiffness::rate,
                           .bend = 0,
                           .substeps = 1,
                           .precision = Precision::full};
    options.plastic.yield = 10;
    const LatticeBody body = make_lattice(whole_sheet(1, 1), options);
    ASSERT_EQ(body.whole.regions.slots(), 4u);
    const float flowed[4][3] = {// xx, xz and zz
                                {0.5f, 0, 0},
                                {0, 0.25f, -0.25f},
                                {0.25f, -0.125f, 0.5f},
                                {0.25f, 0.375f, 0.25f}};
    const auto step = [&](bool averaged) {
        State state = rest_state(body);
        for (const auto& own : flowed) {
            float e[3] = {own[0], own[1], own[2]};
            if (averaged) {
                for (int i = 0; i < 3; ++i) {
                    e[i] = (flowed[0][i] + flowed[1][i] + flowed[2][i] + flowed[3][i]) / 4;
                }
            }
            for (const float v : {e[0], 0.0f, e[1], 0.0f, 0.0f, e[2]}) state.plastic.push_back(v);
        }
        return advance(body, state, {}, 1e-3, options);
    };
    const State own = step(false), averaged = step(true);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_GT(averaged.v[i].norm(), 0.01);
        EXPECT_LT((own.v[i] - averaged.v[i]).norm(), 1e-9 * averaged.v[i].norm());
    }
}

TEST(LatticePlasticity, ASheetDrawnOutBeyondItsYieldStaysDrawnOut)
{
    for (const PlaneMotion motion : {PlaneMotion::space, PlaneMotion::in_plane}) {
        const auto length_after = [&](double yield) {
            const Cubes cubes = whole_sheet(10, 3);
            LatticeOptions options{
                .half_width = 1, .damping = 0.01, .plane = motion, .substeps = 12};
            options.plastic.yield = yield;
            const LatticeBody body = make_lattice(cubes, options);
            State state =
                drive(body, cubes, rest_state(body), 24, options, [](const Vec3& x, double share) {
                    return Vec3(x[0] * (1 + 0.5 * share), x[1], x[2]);
                });
            options.damping = 0.05;
            for (int f = 0; f < 48; ++f) {
                state = advance(body, std::move(state), {}, 1.0 / 24, options);
                for (Vec3& v : state.v) v *= 0.5;  // or it snaps back so fast that it crumples
            }
            return extent_in_x(state);
        };
        EXPECT_NEAR(length_after(0), 1, 5e-3);
        const double stayed = length_after(0.1);
        EXPECT_GT(stayed, 1.2);                 // it flowed,
        EXPECT_LT(stayed, 1.45);                // and what was elastic went back
        EXPECT_NEAR(length_after(3), 1, 5e-3);  // never strained so far
    }
}

TEST(LatticeTear, ASheetPulledApartTearsAndItsPartsForgetEachOther)
{
    // The middle row of links is pulled to three times its length and gives way; then each half
    // moves as if the other were not there.
    const Cubes cubes = whole_sheet(9, 4);
    LatticeOptions options{.half_width = 2, .damping = 0.01, .tear = 0.6, .substeps = 12};
    const LatticeBody body = make_lattice(cubes, options);
    State state =
        drive(body, cubes, rest_state(body), 72, options,
              [](const Vec3& x, double share) { return Vec3(x[0] * (1 + 2 * share), x[1], x[2]); });
    ASSERT_FALSE(state.broken.empty());
    EXPECT_TRUE(std::is_sorted(state.broken.begin(), state.broken.end()));
    EXPECT_EQ(std::adjacent_find(state.broken.begin(), state.broken.end()), state.broken.end())
        << "a link breaks once";
    // The halves come back to their shape: every link that is left is as long as it was.
    options.damping = 0.05;
    for (int f = 0; f < 120; ++f) state = advance(body, std::move(state), {}, 1.0 / 24, options);
    const Lattice lattice = corner_lattice(cubes);
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        for (std::uint32_t d = 0; d < 3; ++d) {
            const auto j = lattice.next[i][d];
            if (j == none) continue;
            if (std::binary_search(state.broken.begin(), state.broken.end(), 3 * i + d)) continue;
            EXPECT_NEAR((state.x[i] - state.x[j]).norm(), 0.1, 2e-3);
        }
    }
    double low = 1e9, high = -1e9;
    for (const Vec3& x : state.x) low = std::min(low, x[0]), high = std::max(high, x[0]);
    EXPECT_GT(high - low, 1.5);  // 2.7 m apart less what snapped back
}

TEST(LatticeTear, LinksTearAlongAnyAxis)
{
    const Cubes cubes = box(2, 3, 2, 0.1);
    const LatticeOptions options{.half_width = 1, .tear = 0.5, .substeps = 1};
    const LatticeBody body = make_lattice(cubes, options);
    const Lattice lattice = corner_lattice(cubes);
    for (std::uint32_t d = 0; d < 3; ++d) {
        State state = rest_state(body);
        for (Vec3& x : state.x) x[Eigen::Index(d)] *= 2;
        std::vector<std::uint32_t> along;
        for (std::uint32_t i = 0; i < lattice.count(); ++i) {
            if (lattice.next[i][d] != none) along.push_back(3 * i + d);
        }
        EXPECT_EQ(advance(body, state, {}, 1e-6, options).broken, along);
    }
}

TEST(LatticeTear, AStoredStateGoesOnAsIfItHadNotStopped)
{
    // The torn regions are a function of the broken links alone: a body made anew, as after a
    // restart, continues to the same bytes.
    const Cubes cubes = whole_sheet(9, 4);
    const LatticeOptions options{.half_width = 1, .damping = 0.01, .tear = 0.4, .substeps = 6};
    const auto pulled = [](const Vec3& x, double share) {
        return Vec3(x[0] * (1 + 2 * share), x[1], x[2]);
    };
    const LatticeBody one = make_lattice(cubes, options), other = make_lattice(cubes, options);
    const State half = drive(one, cubes, rest_state(one), 48, options, pulled);
    ASSERT_FALSE(half.broken.empty());
    const State a = advance(one, half, {}, 1.0 / 24, options);
    const State b = advance(other, half, {}, 1.0 / 24, options);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.broken, b.broken);
}

TEST(LatticeTear, RegionsChangeWithTheStepThatBreaksALink)
{
    // Two steps of one frame are two frames of one step, though a link breaks in the first: a kick
    // takes a corner away from its neighbours.
    const Cubes cubes = box(4, 3, 3, 0.1);
    LatticeOptions options{
        .half_width = 1, .tear = 0.2, .substeps = 2, .precision = Precision::full};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    state.v[0] = Vec3(-80, 0, 0);
    const State both = advance(body, state, {}, 0.002, options);
    options.substeps = 1;
    const State first = advance(body, state, {}, 0.001, options);
    ASSERT_FALSE(first.broken.empty());
    const State second = advance(body, first, {}, 0.001, options);
    EXPECT_EQ(both.broken, second.broken);
    for (std::size_t i = 0; i < both.x.size(); ++i) {
        EXPECT_LT((both.x[i] - second.x[i]).norm(), 1e-12);  // measured from other middles
    }
}

TEST(LatticeTear, OneBodyStepsStatesThatAreTornElsewhere)
{
    // As many broken links, but others: a body that has just stepped the one steps the other as a
    // body made for it does.
    const Cubes cubes = box(4, 3, 3, 0.1);
    const LatticeOptions options{.half_width = 1, .tear = 5, .substeps = 1};
    const LatticeBody shared = make_lattice(cubes, options), own = make_lattice(cubes, options);
    State state = rest_state(shared);
    for (std::size_t i = 0; i < state.x.size(); ++i) state.x[i][0] *= 1 + 0.1 * double(i % 3);
    State one = state, other = state;
    one.broken = {0, 1, 2};
    const std::uint32_t far = 3 * 21;
    other.broken = {far, far + 1, far + 2};
    const State a = advance(shared, one, {}, 0.01, options);
    const State b = advance(shared, other, {}, 0.01, options);
    EXPECT_EQ(b.x, advance(own, other, {}, 0.01, options).x);
    EXPECT_NE(a.x, b.x);
}

TEST(LatticeTear, PiecesStayAboveTheGroundAndGainNoEnergy)
{
    // Thrown down so that it shatters, with its own outside as its skin and with a ball inside it.
    const Cubes cubes = box(6, 6, 6, 0.1);
    auto ball = geometry::icosphere(0.26, 2);
    for (auto& p : ball.positions) p += geometry::Vec3f(0.3f, 0.3f, 0.3f);
    for (const geometry::TriMesh* surface : {static_cast<geometry::TriMesh*>(nullptr), &ball}) {
        const LatticeOptions options{.half_width = 1, .tear = 0.15, .substeps = 8};
        const LatticeBody body = make_lattice(cubes, options, surface);
        State state = rest_state(body);
        for (Vec3& x : state.x) x[1] += 0.05;
        state.v.assign(state.x.size(), Vec3(0.5, -6, 0));
        Loads loads;
        loads.forces.push_back({});
        loads.colliders.push_back({});
        const auto energy = [&] {
            double sum = 0;
            for (std::size_t k = 0; k < state.x.size(); ++k) {
                sum += body.base.mass[k] * (state.v[k].squaredNorm() / 2 + 9.81 * state.x[k][1]);
            }
            return sum;
        };
        const double before = energy();
        for (int f = 0; f < 36; ++f) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
            EXPECT_LT(energy(), before) << f << (surface ? " ball" : "");
            // The corners of the block are 0.26 m from the ball.
            const double low = surface ? -0.3 : -0.15;
            for (const Vec3& x : state.x) ASSERT_GT(x[1], low) << f;
        }
        EXPECT_GT(state.broken.size(), 100u);
    }
}

TEST(LatticeTear, WhatIsTornAtRandomRestsUnderAnyRigidMotion)
{
    // Regions that are left with a line of particles, or with one, see no twist, no stretch across
    // and nothing to flow.
    const Mat3 about_y = Eigen::AngleAxisd(2, Vec3(0, 1, 0)).toRotationMatrix();
    const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    for (int kind = 0; kind < 6; ++kind) {
        const bool solid = kind % 3 == 0, in_plane = kind % 3 == 2, plastic = kind >= 3;
        for (const Precision precision : {Precision::full, Precision::single}) {
            for (const int w : {1, 2, 3}) {
                LatticeOptions options{.half_width = w,
                                       .stiffness = Stiffness::rate,
                                       .rate = 1e4,
                                       .bend = 0.3,
                                       .tear = 5,
                                       .substeps = 1,
                                       .precision = precision};
                if (in_plane) options.plane = PlaneMotion::in_plane;
                if (plastic) options.plastic = {.yield = 0.01, .flow = 100};
                const LatticeBody body =
                    make_lattice(solid ? box(4, 3, 5, 0.1) : whole_sheet(7, 5), options);
                const Random random(std::uint64_t(10 * kind + w));
                State state = rest_state(body);
                for (Vec3& x : state.x) x = (in_plane ? about_y : turn) * x + Vec3(0.2, 0, 0.3);
                for (std::uint32_t link = 0; link < 3 * state.x.size(); ++link) {
                    if (random.unit(link) < 0.5) state.broken.push_back(link);
                }
                const State after = advance(body, state, {}, 0.01, options);
                const double tolerance = precision == Precision::full ? 1e-7 : 1e-6;
                double worst = 0, flowed = 0;
                for (std::size_t i = 0; i < state.x.size(); ++i) {
                    worst = std::max(worst, (after.x[i] - state.x[i]).norm());
                }
                for (const float p : after.plastic) flowed = std::max(flowed, std::abs(double(p)));
                EXPECT_LT(worst, tolerance) << kind << " " << w;
                EXPECT_EQ(flowed, 0) << kind << " " << w;
            }
        }
    }
}

TEST(LatticeTear, RegionsAwayFromABreakAreAsTheyWere)
{
    for (const bool flat : {false, true}) {
        const LatticeOptions options{.half_width = 1, .tear = 0.5};
        const Cubes cubes = flat ? whole_sheet(8, 3) : box(8, 2, 2, 0.1);
        const LatticeBody body = make_lattice(cubes, options);
        const std::uint32_t link = 0;  // of the first particle, along x
        const auto torn = body.torn->find(body.whole, {link});
        std::size_t alike = 0;
        for (std::size_t s = 0; s < body.whole.rate_sq.size(); ++s) {
            const auto r = body.whole.regions.particle[s];
            if (r == none || cubes.corner[r][0] < 3) continue;
            ASSERT_EQ(torn->regions.particle[s], r);
            EXPECT_EQ(torn->rate_sq[s], body.whole.rate_sq[s]);
            if (flat) {
                EXPECT_EQ(torn->bend_sq[s], body.whole.bend_sq[s]);
            }
            ++alike;
        }
        EXPECT_GT(alike, 10u);
        // The last few are kept.
        EXPECT_NE(body.torn->find(body.whole, {3}), torn);
        EXPECT_EQ(body.torn->find(body.whole, {link}), torn);
        const auto third = body.torn->find(body.whole, {6});
        EXPECT_EQ(body.torn->find(body.whole, {6}), third);
        EXPECT_EQ(body.torn->find(body.whole, {link}), torn);
    }
}

TEST(LatticeTear, WhatIsFoundDependsOnTheLinksAlone)
{
    // Whether links break a few at a time or all at once, and as a search of the torn lattice
    // finds.
    const double h = 0.1;
    struct Case {
        geometry::Cubes cubes;
        bool flat, slit;
    };
    // Small, and torn at random until all regions have changed; and large, with a slit that grows.
    const Case cases[] = {{box(7, 4, 3, h), false, false},
                          {whole_sheet(9, 6), true, false},
                          {box(19, 8, 7, h), false, true},
                          {whole_sheet(40, 30), true, true}};
    for (const auto& [cubes, flat, slit] : cases) {
        const Lattice lattice = corner_lattice(cubes);
        const auto n = std::uint32_t(lattice.count());
        const Random random(20 + flat);
        std::vector<std::array<double, 3>> matter;
        for (std::uint64_t i = 0; i < n; ++i) {
            matter.push_back({1 + random.unit(3 * i), 1 + random.unit(3 * i + 1),
                              flat ? 1e-3 * (1 + random.unit(3 * i + 2)) : 0});
        }
        const auto matched = [&](const Lattice& of) {
            return match_regions(find_regions(of, 2, flat ? 1 : -1), of, matter, h, true);
        };
        const MatchedRegions whole = matched(lattice);
        TornRegions bit_by_bit(lattice, matter, h, true), at_once(lattice, matter, h, true);
        std::vector<std::uint32_t> across;
        for (std::uint32_t i = 0; i < n; ++i) {
            if (lattice.at[i][0] == lattice.at[0][0] + 9) across.push_back(3 * i);
        }
        std::vector<std::uint32_t> broken;
        TornRegions::Found found;
        for (std::uint64_t some = 0; some < 5; ++some) {
            for (std::uint64_t k = 12 * some; k < 12 * some + 12; ++k) {
                if (!slit) broken.push_back(std::uint32_t(random.bits(1000 + k) % (3 * n)));
                if (slit && k / 2 < across.size()) broken.push_back(across[k / 2]);
            }
            std::sort(broken.begin(), broken.end());
            broken.erase(std::unique(broken.begin(), broken.end()), broken.end());
            found = bit_by_bit.find(whole, broken);
        }
        const auto same = at_once.find(whole, broken);
        EXPECT_EQ(found->mass, same->mass);
        EXPECT_EQ(found->held_by, same->held_by);
        EXPECT_EQ(found->rate_sq, same->rate_sq);
        EXPECT_EQ(found->bend_sq, same->bend_sq);
        EXPECT_EQ(found->inverse_spread, same->inverse_spread);
        EXPECT_EQ(found->regions.exceptions.child, same->regions.exceptions.child);
        ASSERT_EQ(found->twist.size(), same->twist.size());
        for (std::size_t k = 0; k < found->twist.size(); ++k) {
            EXPECT_EQ(found->twist[k].b, same->twist[k].b);
            EXPECT_EQ(found->twist[k].loose, same->twist[k].loose);
        }

        Lattice torn = lattice;
        for (const auto link : broken) torn.next[link / 3][link % 3] = none;
        const MatchedRegions anew = matched(torn);
        EXPECT_EQ(found->mass, anew.mass);
        EXPECT_EQ(found->held_by, anew.held_by);
        std::vector<std::size_t> slot(n);
        for (std::size_t s = 0; s < anew.regions.slots(); ++s) {
            if (anew.regions.particle[s] != none) slot[anew.regions.particle[s]] = s;
        }
        for (std::size_t s = 0; s < found->regions.slots(); ++s) {
            if (found->regions.particle[s] == none) continue;
            const std::size_t other = slot[found->regions.particle[s]];
            EXPECT_NEAR(found->rate_sq[s] / anew.rate_sq[other], 1, 1e-6);
            if (flat) {
                EXPECT_NEAR(found->bend_sq[s] / anew.bend_sq[other], 1, 1e-6);
                EXPECT_NEAR(found->twist[s].loose, anew.twist[other].loose,
                            1e-4 * std::abs(anew.twist[other].loose));
            }
            for (std::size_t k = 0; k < 6; ++k) {
                EXPECT_NEAR(found->inverse_spread[6 * s + k], anew.inverse_spread[6 * other + k],
                            1e-5);
            }
        }
    }
}

TEST(LatticeBodies, AreEachAsStiffAsAlone)
{
    // A slender beam bends too stiffly by far more than a block does: side by side, not linked,
    // each is softened by its own excess.
    const LatticeOptions options{.half_width = 2};
    std::vector<Vec3i> beam, block, both;
    for (int x = 0; x < 12; ++x) beam.emplace_back(x, 0, 0);
    for (int k = 0; k < 27; ++k) block.emplace_back(k % 3, 5 + k / 3 % 3, k / 9);
    both = beam;
    both.insert(both.end(), block.begin(), block.end());
    const auto rates = [&](const std::vector<Vec3i>& cells) {
        const Cubes cubes = fixtures::cubes_on(cells, 0.1);
        const LatticeBody body = make_lattice(cubes, options);
        std::map<std::array<int, 3>, float> out;
        for (std::size_t s = 0; s < body.whole.rate_sq.size(); ++s) {
            const auto r = body.whole.regions.particle[s];
            if (r == none) continue;
            const Vec3i& at = cubes.corner[r];
            out[{at[0], at[1], at[2]}] = body.whole.rate_sq[s];
        }
        return out;
    };
    auto alone = rates(beam);
    alone.merge(rates(block));
    const auto together = rates(both);
    ASSERT_EQ(together.size(), alone.size());
    // The bend that tells is so slight that some 1e-5 of it is rounding.
    for (const auto& [at, rate] : together) EXPECT_NEAR(rate / alone[at], 1, 1e-3);
}

TEST(LatticeBodies, CollideAndDoNotPassThroughEachOther)
{
    // One block falls on another that lies on the ground, half over its edge of contact distance.
    const Cubes one = fixtures::box(3, 3, 3, 0.1, {1000, 1e5, 0.3});
    const auto n = std::uint32_t(one.corner_count());
    const Cubes cubes = with_copy(one, Vec3i(0, 8, 0));
    LatticeOptions options{.half_width = 2, .damping = 0.01, .substeps = 8};
    options.contact.on = true;
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    State state = rest_state(body);
    for (int f = 0; f < 72; ++f) {
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
        double nearest = 1e9;
        for (std::uint32_t a = 0; a < n; ++a) {
            for (std::uint32_t b = n; b < 2 * n; ++b) {
                nearest = std::min(nearest, (state.x[a] - state.x[b]).norm());
            }
        }
        ASSERT_GT(nearest, 0.07) << f;  // 0.1 apart, less what a fifth a step has yet to resolve
    }
    double upper = 0;
    for (std::uint32_t k = n; k < 2 * n; ++k) upper += state.x[k].y() / n;
    EXPECT_NEAR(upper, 0.3 + 0.1 + 0.15, 0.06);  // on top of the other, a contact distance above
    // Momentum between free bodies is kept.
    State free = rest_state(body);
    for (std::uint32_t k = n; k < 2 * n; ++k) free.v[k] = Vec3(0.3, -6, 0);
    Vec3 before = Vec3::Zero(), after = before;
    for (std::uint32_t k = 0; k < 2 * n; ++k) before += body.base.mass[k] * free.v[k];
    for (int f = 0; f < 24; ++f) free = advance(body, std::move(free), {}, 1.0 / 48, options);
    for (std::uint32_t k = 0; k < 2 * n; ++k) after += body.base.mass[k] * free.v[k];
    EXPECT_LT((after - before).norm(), 1e-10 * before.norm());
    double moved = 0;
    for (std::uint32_t k = 0; k < n; ++k) moved = std::max(moved, free.v[k].norm());
    EXPECT_GT(moved, 0.5);  // the other was hit
}

TEST(LatticeBodies, AreAsFarApartAsTheirDistanceSays)
{
    // Two cubes of 0.1 m meet face to face, of which one may be held. A push leaves no gap and
    // closes none beyond, so while the corners in front touch they are the contact distance apart:
    // 0.16 m where that is given, the edge of a cube where it is 0. What is held gives nothing of
    // way: if its mass took part, each push would leave half the speed, 1 mm a step. Pushes are
    // kept in single precision: of 1 m/s for 1 ms.
    const Cubes cubes = with_copy(box(1, 1, 1, 0.1), Vec3i(3, 0, 0));
    for (const double distance : {0.0, 0.16}) {
        for (const bool held : {false, true}) {
            LatticeOptions options{.half_width = 1, .substeps = 1};
            options.contact.on = true;
            options.contact.distance = distance;
            const LatticeBody body = make_lattice(cubes, options);
            State state = rest_state(body);
            Loads loads;
            for (std::uint32_t k = 0; k < 16; ++k) {
                if (k < 8) state.v[k] = Vec3(2, 0, 0);
                if (k < 8 || !held) continue;
                loads.pins.corner.push_back(k);
                loads.pins.target.push_back(state.x[k]);
            }
            double nearest = 1;
            for (int f = 0; f < 200; ++f) {
                state = advance(body, std::move(state), loads, 1e-3, options);
                for (std::size_t a = 0; a < 8; ++a) {
                    for (std::size_t b = 8; b < 16; ++b) {
                        nearest = std::min(nearest, (state.x[a] - state.x[b]).norm());
                    }
                }
            }
            EXPECT_NEAR(nearest, distance > 0 ? distance : 0.1, 1e-6) << held;
        }
    }
}

TEST(LatticeBodies, TouchWithTheirOutside)
{
    // Of 4 x 4 x 4 particles all but the 2 x 2 x 2 within; of a plane, which has nothing but two
    // faces, all.
    LatticeOptions options{.half_width = 1};
    options.contact.on = true;
    EXPECT_EQ(make_lattice(box(3, 3, 3, 0.1), options).side.size(), 64u - 8u);
    EXPECT_EQ(make_lattice(whole_sheet(4, 5), options).side.size(), 5u * 6u);
}

TEST(LatticeBalls, RestOnASheetAndWeighOnItsPins)
{
    // A ball settles on a sheet held at its rim; momentum balance: its speed goes to 0 while
    // gravity pulls, so the pins carry it. It lies where it touches, above the sheet's dent.
    const Cubes cubes = whole_sheet(12, 12);
    LatticeOptions options{.half_width = 1, .damping = 0.02, .substeps = 16};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    Ball ball;
    ball.radius = 0.25;
    ball.mass = 4;
    ball.position = Vec3(0.6, 0.4, 0.6);
    loads.balls.push_back(ball);
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        const auto& at = cubes.corner[k];
        if (at[0] % 12 != 0 && at[2] % 12 != 0) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    State state = rest_state(body);
    for (int f = 0; f < 240; ++f) {
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
        for (Vec3& v : state.v) v *= 0.98;
    }
    ASSERT_EQ(state.balls.size(), 1u);
    EXPECT_LT(state.balls[0].v.norm(), 0.05);
    double lowest = 0;
    for (const Vec3& x : state.x) lowest = std::min(lowest, x[1]);
    EXPECT_LT(lowest, -0.01);
    EXPECT_NEAR(state.balls[0].x[1], lowest + 0.25, 0.02);
    EXPECT_NEAR(state.balls[0].x[0], 0.6, 0.02);
}

TEST(LatticeBalls, RollDownASlopeAsSolidBallsDo)
{
    // Without slip a = 5/7 g sin(30 deg): after 0.5 s it has gone 5/7 9.81 0.5 0.5^2 / 2 = 0.438 m.
    const Cubes cubes = fixtures::box(1, 1, 1, 0.1);
    LatticeOptions options{.half_width = 1, .substeps = 20};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    Collider slope;
    slope.pose.linear() = Eigen::AngleAxisd(std::numbers::pi / 6, Vec3::UnitZ()).toRotationMatrix();
    slope.before = slope.pose;
    loads.colliders.push_back(slope);
    Ball ball;
    ball.radius = 0.2;
    const Vec3 normal = slope.pose.linear() * Vec3::UnitY();
    ball.position = Vec3(5, 5 * std::tan(std::numbers::pi / 6), 0) + 0.2 * normal;
    loads.balls.push_back(ball);
    State state = rest_state(body);
    for (int f = 0; f < 12; ++f) state = advance(body, std::move(state), loads, 1.0 / 24, options);
    EXPECT_NEAR((state.balls[0].x - ball.position).norm(), 0.438, 0.01);
    EXPECT_NEAR(state.balls[0].spin.norm() * 0.2, state.balls[0].v.norm(), 0.01);
}

TEST(LatticeBalls, TurnAboutTheirSpinHoweverTheyLie)
{
    const LatticeOptions options{.half_width = 1, .substeps = 7};
    const LatticeBody body = make_lattice(box(1, 1, 1, 0.1), options);
    Loads loads;
    loads.balls.push_back({.position = Vec3(5, 5, 5)});
    State state = advance(body, rest_state(body), loads, 0.1, options);
    const Eigen::Quaterniond lies(Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()));
    state.balls[0].turn = {lies.w(), lies.x(), lies.y(), lies.z()};
    state.balls[0].spin = Vec3(0, 3, 0);
    const State after = advance(body, state, loads, 0.1, options);
    const Eigen::Vector4d q = after.balls[0].turn;
    const Eigen::Quaterniond turned(q[0], q[1], q[2], q[3]);
    const Eigen::Quaterniond expected = Eigen::AngleAxisd(0.3, Vec3::UnitY()) * lies;
    EXPECT_LT(turned.angularDistance(expected), 1e-7);  // the arc cosine of 1 less rounding
    state.balls[0].spin[1] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(advance(body, state, loads, 0.1, options), std::invalid_argument);
}

TEST(LatticeBalls, HitEachOtherAsSolidBallsWithFrictionDo)
{
    // One comes down on another at 2 m/s while it goes past at 5 m/s: they meet at t = 0.3 s, one
    // above the other, without bounce. Each takes on half of 2 m/s, J = m / 2 * 2; friction is of
    // the two coefficients' geometric mean, 0.3 J = 0.45 N s, far from what would stop their slip,
    // and turns both the same way at r 0.3 J / (2/5 m r^2) = 3.75 rad/s.
    const double m = 1.5, r = 0.2;
    const LatticeOptions options{.half_width = 1, .substeps = 400};
    const LatticeBody body = make_lattice(box(1, 1, 1, 0.1), options);
    Loads loads;
    Ball one{.radius = r, .mass = m, .friction = 1}, other = one;
    one.position = Vec3(-1.5, 1, 5);
    one.velocity = Vec3(5, -2, 0);
    other.position = Vec3(0, 0, 5);
    other.friction = 0.09;
    loads.balls = {one, other};
    State state = rest_state(body);
    for (int f = 0; f < 8; ++f) state = advance(body, std::move(state), loads, 1.0 / 24, options);
    // In a step of 0.1 ms they slide by 0.5 mm, so the normal is off by some thousandths.
    const auto& a = state.balls[0];
    const auto& b = state.balls[1];
    EXPECT_LT((a.v - Vec3(4.7, -1, 0)).norm(), 0.03);
    EXPECT_LT((b.v - Vec3(0.3, -1, 0)).norm(), 0.03);
    EXPECT_LT((a.spin - Vec3(0, 0, -3.75)).norm(), 0.05);
    EXPECT_LT((b.spin - Vec3(0, 0, -3.75)).norm(), 0.05);
}
