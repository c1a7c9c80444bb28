// Flow of lattices beyond their yield strain: solids and planes.

#include "tests/physics/lattice/lattice_fixtures.hpp"

#include <gtest/gtest.h>

using namespace physics;
using fixtures::box;
using fixtures::drive;
using fixtures::expect_sane;
using fixtures::extent_in_x;
using fixtures::whole_sheet;
using geometry::Cubes;

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
    // added, a fifth in a step at most, at constant volume, up to the limit. Regions with pins,
    // which weigh those by more, are strained alike.
    struct Case {
        double flow, limit;
        bool pinned = false;
    };
    const double dt = 0.01, yield = 0.1;
    const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    for (const bool flat : {false, true}) {
        for (const Case& c :
             {Case{20, 0.9}, Case{1e6, 0.9}, Case{1e6, 0.15}, Case{20, 0.9, true}}) {
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
                Loads loads;
                for (std::uint32_t k = 0; c.pinned && k < state.x.size(); ++k) {
                    if (cubes.corner[k][0] != 0) continue;
                    loads.pins.corner.push_back(k);
                    loads.pins.target.push_back(state.x[k]);
                }
                state = advance(body, state, loads, dt, options);
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
                    ASSERT_LT((one + got - shape).norm(), 1e-6)
                        << flat << c.flow << c.pinned << step;
                    ASSERT_LT(std::abs(p[1]) + std::abs(p[2]) + std::abs(p[4]), 1e-6f);
                }
            }
        }
    }
}

TEST(LatticePlasticity, APinnedBodyAtRestKeepsItsShape)
{
    // Nothing acts on a body whose ends are held: it stays to rounding, in single precision.
    for (int kind = 0; kind < 3; ++kind) {
        LatticeOptions options{.half_width = 2, .substeps = 8};
        if (kind == 2) options.plane = PlaneMotion::in_plane;
        options.plastic = {.yield = 0.02, .flow = 10};
        const Cubes cubes = kind == 0 ? box(10, 1, 2, 0.1, {1000, 1e6, 0.3}) : whole_sheet(10, 2);
        const LatticeBody body = make_lattice(cubes, options);
        const State rest = rest_state(body);
        const State state =
            drive(body, cubes, rest, 8, options, [](const Vec3& x, double) { return x; });
        EXPECT_EQ(state.plastic_strain, std::vector<float>(cubes.count(), 0.0f)) << kind;
        for (std::size_t i = 0; i < rest.x.size(); ++i) {
            ASSERT_LT((state.x[i] - rest.x[i]).norm(), 1e-5) << kind;
        }
    }
}

TEST(LatticePlasticity, APlasticBodyRestsUnderAnyRigidMotion)
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
            EXPECT_EQ(state.plastic_strain, std::vector<float>(cubes.count(), 0.0f));
            for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
                const float packed[6] = {0.25f, 0, 0.125f, 0, 0, -0.125f};
                state.plastic.insert(state.plastic.end(), packed, packed + 6);
                state.plastic_of = PlasticOf::regions;
            }
            for (Vec3& x : state.x) x = turn * shape * x + Vec3(0.2, 0, 0.3);
            const State after = advance(body, state, {}, 0.01, options);
            ASSERT_EQ(after.plastic_strain.size(), cubes.count());
            for (const float strain : after.plastic_strain) {
                EXPECT_NEAR(strain, std::sqrt(0.25 * 0.25 + 3 * 0.125 * 0.125), 1e-6);
            }
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

TEST(LatticePlasticity, AMembraneCellFlowsByTheMeanOfItsCorners)
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
            state.plastic_of = PlasticOf::regions;
        }
        return advance(body, state, {}, 1e-3, options);
    };
    const State own = step(false), averaged = step(true);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_GT(averaged.v[i].norm(), 0.01);
        EXPECT_LT((own.v[i] - averaged.v[i]).norm(), 1e-9 * averaged.v[i].norm());
    }
}

TEST(LatticePlasticity, ASheetStretchedBeyondItsYieldStaysLonger)
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
