// Hard cases for everything that moves the corners of cubes implicitly, bricks and springs, and for
// modes: what the report of speed against error calls stable is what these hold to.

#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/modal/modes.hpp"
#include "physics/modal/vibrate.hpp"
#include "physics/state/first_motion.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace {

using namespace physics;
using fixtures::finite;
using fixtures::shape_error;
using fixtures::Stuff;
using geometry::Cubes;
using geometry::Random;
using geometry::Vec3i;

double fastest(const State& s)
{
    double out = 0;
    for (const Vec3& v : s.v) out = std::max(out, v.norm());
    return out;
}

Pins pins_where(const Cubes& cubes, const std::function<bool(const Vec3i&)>& choose)
{
    Pins pins;
    pins.corner = fixtures::corners_where(cubes, choose);
    for (const auto k : pins.corner) pins.target.push_back(cubes.corner_position(k));
    return pins;
}

Pins held_at_the_left(const Cubes& cubes)
{
    return pins_where(cubes, [](const Vec3i& c) { return c.x() == 0; });
}

template <class Body> Body make(const Cubes& cubes);
template <> BricksBody make(const Cubes& cubes)
{
    return make_bricks(cubes);
}
template <> SpringsBody make(const Cubes& cubes)
{
    return make_springs(cubes);
}

template <class Body> class Stability : public testing::Test {};
using Bodies = testing::Types<BricksBody, SpringsBody>;
struct BodyNames {
    template <class Body> static std::string GetName(int)
    {
        return std::is_same_v<Body, BricksBody> ? "Bricks" : "Springs";
    }
};
TYPED_TEST_SUITE(Stability, Bodies, BodyNames);

TYPED_TEST(Stability, AnyShapeToStartFromComesToRest)
{
    constexpr bool bricks = std::is_same_v<TypeParam, BricksBody>;
    const Cubes cubes =
        fixtures::box(4, 2, 2, 0.1, {.young = 1e5, .mass_damping = 4, .stiffness_damping = 0.01});
    const auto body = make<TypeParam>(cubes);
    const Random random(12);
    using Deform = std::function<Vec3(const Vec3&, std::uint64_t)>;
    struct Case {
        const char* name;
        Deform deform;
        bool springs_return;  // a lattice of springs has other shapes without tension, folded ones
    };
    const std::vector<Case> cases{
        {"twisted by 720 degrees",
         [](const Vec3& p, auto) {
             return Vec3(Eigen::AngleAxisd(4 * std::numbers::pi * p.x() / 0.4, Vec3::UnitX()) * p);
         },
         false},
        {"stretched 10 times", [](const Vec3& p, auto) { return Vec3(10 * p.x(), p.y(), p.z()); },
         true},
        {"mirrored", [](const Vec3& p, auto) { return Vec3(-p.x(), p.y(), p.z()); }, true},
        {"on a plane", [](const Vec3& p, auto) { return Vec3(p.x(), 0, p.z()); }, false},
        {"on a line", [](const Vec3& p, auto) { return Vec3(p.x(), 0, 0); }, false},
        {"at a point", [](const Vec3&, auto) { return Vec3(0.1, 0.2, 0.3); }, false},
        {"random",
         [&](const Vec3&, std::uint64_t k) {
             return Vec3(random.unit(3 * k), random.unit(3 * k + 1), random.unit(3 * k + 2));
         },
         false}};
    for (const auto& [name, deform, springs_return] : cases) {
        State state = rest_state(body);
        for (std::size_t k = 0; k < state.x.size(); ++k) state.x[k] = deform(state.x[k], k);
        for (int i = 0; i < 250; ++i) {
            state = advance(body, state, {}, 0.02);
            ASSERT_TRUE(finite(state)) << name << ' ' << i;
        }
        EXPECT_LT(fastest(state), 1e-3) << name;
        // Distances alone do not tell a body from its mirror image.
        if (bricks) {
            EXPECT_LT(fixtures::misfit(rest_state(body), state), 1e-3 * 0.4) << name;
        }
        if (springs_return) {
            EXPECT_LT(shape_error(cubes, state), 1e-3 * 0.4) << name;
        }
    }
}

// The solver's tolerance may not move a body: of two that fly, one violently stretched, each keeps
// its own momentum to round-off, and in gravity both gain m g t.
TYPED_TEST(Stability, AFreeBodyKeepsItsMomentumWhateverTheTolerance)
{
    std::vector<Vec3i> cells;
    for (int x = 0; x < 4; ++x) cells.push_back(Vec3i(x, 0, 0)), cells.push_back(Vec3i(x, 5, 0));
    const Cubes cubes = fixtures::cubes_on(cells, 0.1, {.young = 1e5, .stiffness_damping = 1e-3});
    const auto body = make<TypeParam>(cubes);
    const auto mass = corner_masses(cubes);
    State state = rest_state(body);
    const auto momentum = [&](bool upper) {
        Vec3 sum = Vec3::Zero();
        for (std::size_t k = 0; k < mass.size(); ++k) {
            if ((cubes.corner[k].y() > 3) == upper) sum += mass[k] * state.v[k];
        }
        return sum;
    };
    for (std::size_t k = 0; k < mass.size(); ++k) {
        const bool upper = cubes.corner[k].y() > 3;
        state.v[k] = upper ? Vec3(1, 2, 3) : Vec3(-2, 0, state.x[k].x());
        if (upper) state.x[k].x() *= 10;
    }
    const Vec3 below = momentum(false), above = momentum(true);
    const Vec3 gained = 4.0 * Vec3(0, -9.81, 0) * 20 * 0.02;  // 4 kg each, 20 steps
    Loads loads;
    loads.forces = {Force{}};
    int violent = 0;
    for (int i = 0; i < 20; ++i) {
        state = advance(body, state, loads, 0.02, {.tolerance = 1e-2});
        violent += state.report.iterations > 0 ? 1 : 0;
    }
    EXPECT_GE(violent, 15);  // it was a solver that moved them, in most steps
    EXPECT_LT((momentum(false) - below - gained).norm(), 1e-13 * gained.norm());
    EXPECT_LT((momentum(true) - above - gained).norm(), 1e-13 * gained.norm());
}

TYPED_TEST(Stability, BothEndsOfABeamTurnedAgainstEachOther)
{
    // At pi / 4 a second each for 24 s: six turns in all. (Others run this case too.)
    const Cubes cubes =
        fixtures::box(8, 2, 2, 0.1, {.young = 1e5, .mass_damping = 2, .stiffness_damping = 0.01});
    const auto body = make<TypeParam>(cubes);
    const Pins rest = pins_where(cubes, [](const Vec3i& c) { return c.x() == 0 || c.x() == 8; });
    State state = rest_state(body);
    Loads loads;
    loads.pins = rest;
    const int frames = 24 * 12;
    for (int i = 1; i <= frames; ++i) {
        const double angle = std::numbers::pi / 4 * 24 * i / frames;
        for (std::size_t p = 0; p < rest.corner.size(); ++p) {
            const double way = cubes.corner[rest.corner[p]].x() == 0 ? -1 : 1;
            const Vec3 middle(0, 0.1, 0.1);
            loads.pins.target[p] =
                Eigen::AngleAxisd(way * angle, Vec3::UnitX()) * (rest.target[p] - middle) + middle;
        }
        state = advance(body, state, loads, 24.0 / frames);
        ASSERT_TRUE(finite(state)) << i;
    }
    // Wound up, nothing is flung out: within twice its section of the axis.
    for (const Vec3& p : state.x) {
        EXPECT_LT(std::hypot(p.y() - 0.1, p.z() - 0.1), 0.4);
        EXPECT_LT(std::abs(p.x() - 0.4), 0.6);
    }
    EXPECT_LT(fastest(state), 10);
    // Let go at one end, it unwinds and comes back.
    loads.pins = held_at_the_left(cubes);
    for (std::size_t p = 0; p < loads.pins.corner.size(); ++p) {
        loads.pins.target[p] = state.x[loads.pins.corner[p]];
    }
    for (int i = 0; i < 600; ++i) {
        state = advance(body, state, loads, 0.02);
        ASSERT_TRUE(finite(state)) << i;
    }
    EXPECT_LT(shape_error(cubes, state), 0.01);
}

TYPED_TEST(Stability, StepsFromAMicrosecondToTenSecondsOfAnythingStayBounded)
{
    // Neighbours a million times stiffer and heavier, nearly incompressible, under gravity, struck
    // at 1 m/s at every corner: the softest spring, 1e4 N/m, stops the heaviest corner, 1 kg, in 1
    // cm.
    Cubes cubes = fixtures::box(4, 2, 2, 0.1, {.density = 1e-3, .young = 1e5, .poisson = 0.499});
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (c % 2) cubes.young[c] *= 1e6;
        if (c % 3) cubes.mass[c] *= 1e6;
    }
    const auto body = make<TypeParam>(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.pins = held_at_the_left(cubes);
    const Random random(3);
    for (const auto integrator : {Integrator::implicit_euler, Integrator::sdirk2}) {
        for (const double dt : {1e-6, 1e-3, 1.0 / 24, 1.0, 10.0}) {
            State state = rest_state(body);
            for (std::size_t k = 0; k < state.x.size(); ++k) {
                state.v[k] = Vec3(random.unit(2 * k), random.unit(2 * k + 1), 0);
            }
            for (int i = 0; i < 10; ++i) {
                state = advance(body, state, loads, dt, {.integrator = integrator});
                ASSERT_TRUE(finite(state)) << dt;
            }
            for (const Vec3& p : state.x) ASSERT_LT(p.norm(), 1) << dt;
        }
    }
}

TYPED_TEST(Stability, TheSameMotionForAStepAndAQuarterOfIt)
{
    // A beam let go sways for a third of a second, 1.2 of its periods. Of second order, so a step
    // has 16 times the error of its quarter.
    const Cubes cubes =
        fixtures::box(6, 1, 1, 0.1, {.young = 2e5, .poisson = 0.25, .stiffness_damping = 0.002});
    const auto body = make<TypeParam>(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.pins = held_at_the_left(cubes);
    const auto tip = [&](int substeps) {
        State state = rest_state(body);
        const StepOptions options{.integrator = Integrator::sdirk2,
                                  .substeps = substeps,
                                  .newton_iterations = 5,
                                  .tolerance = 1e-7};
        for (int i = 0; i < 8; ++i) state = advance(body, state, loads, 1.0 / 24, options);
        return state.x.back().y();
    };
    const double coarse = tip(8), fine = tip(32), finest = tip(128);
    EXPECT_LT(std::abs(coarse - fine), 0.01 * 0.6);  // 1 % of its length
    EXPECT_LT(std::abs(fine - finest), 0.2 * std::abs(coarse - fine));
}

TYPED_TEST(Stability, ThousandsOfStepsOfTumblingNeitherGainNorDrift)
{
    // One cube turning once a second about no axis of symmetry, undamped, as long as the sanitizers
    // can bear; every frame is 100 steps.
    const Cubes cubes = fixtures::box(1, 1, 1, 0.1, {.young = 1e4});
    const auto body = make<TypeParam>(cubes);
    State state = rest_state(body);
    add_first_motion(state, cubes, Vec3(0.1, 0, 0), Vec3(3, 5, 2));
    const StepOptions options{.integrator = Integrator::implicit_midpoint,
                              .substeps = 100,
                              .newton_iterations = 3,
                              .tolerance = 1e-8};
    const auto mass = corner_masses(cubes);
    const auto kinetic = [&] {
        double e = 0;
        for (std::size_t k = 0; k < mass.size(); ++k) e += 0.5 * mass[k] * state.v[k].squaredNorm();
        return e;
    };
    const auto spin = [&] {
        Vec3 centre = Vec3::Zero(), out = Vec3::Zero();
        for (const Vec3& p : state.x) centre += p / 8;
        for (std::size_t k = 0; k < mass.size(); ++k) {
            out += mass[k] * (state.x[k] - centre).cross(state.v[k]);
        }
        return out;
    };
    const double energy = kinetic();
    const Vec3 turning = spin();
    for (int i = 0; i < 50; ++i) state = advance(body, state, {}, 0.5, options);
    ASSERT_TRUE(finite(state));
    // Masses at the corners stretch it by m w^2 r over E h: 2 % at most, and twice that goes from
    // the energy of motion with the inertia.
    EXPECT_NEAR(kinetic(), energy, 0.04 * energy);
    EXPECT_LT((spin() - turning).norm(), 1e-3 * turning.norm());
    EXPECT_LT(shape_error(cubes, state), 0.02 * 0.1);
    Vec3 centre = Vec3::Zero();
    for (const Vec3& p : state.x) centre += p / 8;
    EXPECT_LT((centre - Vec3(0.05 + 0.1 * 25, 0.05, 0.05)).norm(), 1e-6);
}

TEST(ModesStability, StiffHeavyAndNearlyIncompressibleNeighbours)
{
    Cubes cubes = fixtures::box(6, 2, 2, 0.1, {.young = 1e5, .poisson = 0.499});
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (c % 2) cubes.young[c] *= 1e6;
        if (c % 3) cubes.mass[c] *= 1e6;
    }
    const auto held = held_at_the_left(cubes);
    const Modes modes = lowest_modes(cubes, held.corner, {.count = 6});
    EXPECT_TRUE(modes.report.converged);
    ASSERT_EQ(modes.omega_sq.size(), 6u);
    for (std::size_t i = 0; i < 6; ++i) {
        const auto momenta = brick_momenta(cubes, modes.shape[i]);
        EXPECT_GT(modes.omega_sq[i], 0);
        for (std::size_t j = 0; j <= i; ++j) {
            double dot = 0;  // M-orthonormal
            for (std::size_t k = 0; k < momenta.size(); ++k) {
                dot += momenta[k].dot(modes.shape[j][k]);
            }
            EXPECT_NEAR(dot, i == j ? 1 : 0, 1e-6) << i << ' ' << j;
        }
    }
}

TEST(ModesStability, ModesRingFor100000StepsOfAnyLengthWithoutGainOrLoss)
{
    // Exact steps: energy is kept to rounding, a few ulp a step at random.
    const Cubes cubes = fixtures::box(4, 1, 1, 0.1, {.young = 1e5});
    const auto mesh = std::make_shared<const geometry::TriMesh>();
    const ModalModel model = make_modal_model(
        lowest_modes(cubes, held_at_the_left(cubes).corner, {.count = 6}), cubes, mesh);
    for (const double dt : {1e-3, 1.0 / 24, 10.0}) {
        ModalState state = rest_state(model);
        for (std::size_t k = 0; k < model.count(); ++k) state.q[k] = 1.0 / double(k + 1);
        const double before = energy(model, state);
        for (int i = 0; i < 100'000; ++i) {
            state = advance(model, std::move(state), {}, Vec3::Zero(), {}, dt);
        }
        EXPECT_NEAR(energy(model, state), before, 1e-10 * before) << dt;
    }
}

}  // namespace
