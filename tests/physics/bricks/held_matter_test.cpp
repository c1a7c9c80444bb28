// Pins that hold points of the material by springs, wherever cubes lie.

#include "physics/state/hold_matter.hpp"

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/modal/modes.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/pins.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace {

using namespace physics;
using geometry::Cubes;

constexpr double h = 0.05;

Pins held_up_to(const Cubes& cubes, double x, std::uint8_t axes = all_axes,
                const Transform& motion = Transform::Identity())
{
    const Outside outside = [x](const Vec3& p) { return p.x() - x; };
    return matter_at(cubes, matter_within(cubes, outside, nullptr, axes), motion);
}

// Under its own weight, all of its material up to x = `clamp` held.
struct Cantilever {
    Cubes cubes = fixtures::box(24, 1, 1, h, {.young = 1e9, .poisson = 0.3});
    BricksBody body = make_bricks(cubes);
    Loads loads;

    explicit Cantilever(double clamp)
    {
        loads.forces.push_back({});  // gravity
        loads.pins = held_up_to(cubes, clamp);
    }
    double sag(const State& state) const
    {
        const std::size_t tip = cubes.corner_count() - 1;
        return cubes.corner_position(tip).y() - state.x[tip].y();
    }
};

double farthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b)
{
    double most = 0;
    for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, (a[k] - b[k]).norm());
    return most;
}

TEST(HeldMatter, ACantileverSagsByItsFreeLengthWhereverItsClampCutsACube)
{
    // w L^4 / (8 E I) + 1.2 w L^2 / (2 G A) with A = h^2, I = h^4 / 12, w = rho g A. Clamps of
    // corners, which end at the last plane of corners in the place, are up to 1.15 times that here.
    for (const double cut : {0.0, 0.25, 0.5, 0.75}) {
        const double clamp = (2 + cut) * h, free = 24 * h - clamp;
        const Cantilever beam(clamp);
        const State state = settle(beam.body, rest_state(beam.body), beam.loads, {});
        EXPECT_TRUE(state.report.converged);
        const double w = 1000 * 9.81, shear = 1e9 / 2.6;
        const double expected =
            w * std::pow(free, 4) * 12 / (8 * 1e9 * h * h) + 1.2 * w * free * free / (2 * shear);
        EXPECT_NEAR(beam.sag(state) / expected, 1, 0.05) << cut;
    }
}

TEST(HeldMatter, ItsSpringsCarryTheWeightAtItsArm)
{
    const Cantilever beam(2.5 * h);
    const State state = settle(beam.body, rest_state(beam.body), beam.loads, {});
    // All of the force of the pins, and that of this pin.
    for (const Pins* of : {static_cast<const Pins*>(nullptr), &beam.loads.pins}) {
        const PinForce force = pin_force(state, of, Vec3::Zero());
        const MassMoments body = mass_moments(state, beam.cubes);
        const Vec3 weight(0, 9.81 * body.mass, 0);
        EXPECT_LT((force.force - weight).norm(), 1e-4 * weight.norm());
        const Vec3 torque = body.centre.cross(weight);
        EXPECT_LT((force.torque - torque).norm(), 1e-4 * torque.norm());
    }
}

TEST(HeldMatter, WhatIsInEquilibriumStaysWhateverTheStep)
{
    // Also in the middle of a frame: the targets of springs that stay are where they were.
    const Cantilever beam(2.5 * h);
    const State rest = settle(beam.body, rest_state(beam.body), beam.loads, {});
    for (const auto integrator :
         {Integrator::implicit_euler, Integrator::sdirk2, Integrator::implicit_midpoint}) {
        State state = rest;
        for (int i = 0; i < 5; ++i) {
            StepOptions options;
            options.integrator = integrator;
            options.substeps = 3;
            state = advance(beam.body, std::move(state), beam.loads, 1.0 / 24, options);
        }
        EXPECT_LT(farthest(state.x, rest.x), 1e-4 * beam.sag(rest));
    }
}

TEST(HeldMatter, ABodyThatIsTurnedAndShiftedAsAWholeArrivesUnstrained)
{
    // All of it held: a quarter turn about x in 12 frames, by corners and points that go straight
    // from frame to frame.
    const Cubes cubes = fixtures::box(3, 2, 2, h, {.young = 1e7});
    const BricksBody body = make_bricks(cubes);
    State state = rest_state(body);
    Transform motion = Transform::Identity();
    for (int i = 1; i <= 12; ++i) {
        motion = Transform(Eigen::Translation3d(0.01 * i, 0, 0)) *
                 Eigen::AngleAxisd(i * std::numbers::pi / 24, Vec3::UnitX());
        Loads loads;
        loads.pins = held_up_to(cubes, 1, all_axes, motion);
        state = advance(body, std::move(state), loads, 1.0 / 24);
    }
    Loads loads;
    loads.pins = held_up_to(cubes, 1, all_axes, motion);
    for (int i = 0; i < 12; ++i) state = advance(body, std::move(state), loads, 1.0 / 24);
    std::vector<Vec3> goal;
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        goal.push_back(motion * cubes.corner_position(k));
    }
    EXPECT_LT(farthest(state.x, goal), 1e-6);
}

// Its springs bring it there within a step, which the midpoint rule leaves at twice that speed, or
// at none.
TEST(HeldMatter, WhatIsLetGoFliesOnAsFastAsItsPinMovedIt)
{
    const Cubes cubes = fixtures::box(3, 2, 2, h, {.young = 1e6});
    const BricksBody body = make_bricks(cubes);
    const auto speed = [&](Integrator integrator, int substeps, int frames) {
        const StepOptions step{.integrator = integrator, .substeps = substeps, .tolerance = 1e-9};
        State state = rest_state(body);
        Loads loads;
        double pushed = 0;  // N s
        for (int i = 1; i <= frames; ++i) {
            const Transform motion(Eigen::Translation3d(0.05 * i, 0, 0));
            loads.pins = held_up_to(cubes, 1, all_axes, motion);
            state = advance(body, std::move(state), loads, 1.0 / 24, step);
            pushed += pin_force(state, nullptr, Vec3::Zero()).force.x() / 24;
        }
        loads.pins = {};
        state = advance(body, std::move(state), loads, 1.0 / 24, step);
        const double mass = 1000 * 12 * h * h * h;
        const double mean = fixtures::brick_motion(cubes, state).linear.x() / mass;
        EXPECT_NEAR(pushed, mass * mean, 0.01 * mass * mean)
            << int(integrator) << " " << substeps << " " << frames;
        return mean;
    };
    for (const auto integrator :
         {Integrator::implicit_euler, Integrator::sdirk2, Integrator::implicit_midpoint}) {
        for (const int substeps : {1, 2, 3}) {
            for (const int frames : {4, 5}) {
                EXPECT_NEAR(speed(integrator, substeps, frames), 1.2, 0.02)
                    << int(integrator) << " " << substeps << " " << frames;
            }
        }
    }
}

// Swung about a place beside it by 30 degrees a frame: along the arc, not along its chord.
TEST(HeldMatter, WhatIsSwungAndLetGoFliesOffAlongTheTangent)
{
    const Cubes cubes = fixtures::box(2, 2, 2, h, {.young = 1e6});
    std::vector<std::uint32_t> all;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) all.push_back(k);
    const Vec3 pivot(-1, h, h);
    constexpr double turn = std::numbers::pi / 6;  // rad a frame
    const auto motion = [&](int frames) -> Transform {
        return Eigen::Translation3d(pivot) * Eigen::AngleAxisd(frames * turn, Vec3::UnitZ()) *
               Eigen::Translation3d(-pivot);
    };
    for (const bool points : {false, true}) {
        for (const bool rigid : {false, true}) {
            const BricksBody body = make_bricks(cubes, {.rigid = {std::uint8_t(rigid)}});
            for (const int substeps : {1, 8}) {
                State state = rest_state(body);
                Loads loads;
                for (int frame = 1; frame <= 4; ++frame) {
                    const Outside anywhere = [](const Vec3&) { return -1.0; };
                    loads.pins =
                        points ? matter_at(cubes, matter_within(cubes, anywhere, nullptr, all_axes),
                                           motion(frame), pivot)
                               : pins_at(cubes, all, motion(frame), pivot);
                    state = advance(body, std::move(state), loads, 1.0 / 24,
                                    {.substeps = substeps, .tolerance = 1e-9});
                }
                loads.pins = {};
                state = advance(body, std::move(state), loads, 1.0 / 24, {.substeps = substeps});
                const Vec3 arm = motion(4) * Vec3(h, h, h) - pivot;
                const Vec3 speed = 24 * turn * Vec3::UnitZ().cross(arm);
                const double mass = 1000 * 8 * h * h * h;
                const Vec3 seen = fixtures::brick_motion(cubes, state).linear / mass;
                // Springs know where the body goes, and not how fast: half a step's turn.
                const double late = points || rigid ? 0.5 * turn / substeps : 0;
                EXPECT_LT((seen - speed).norm(), (0.01 + late) * speed.norm())
                    << points << " " << rigid << " " << substeps << ": " << seen.transpose();
            }
        }
    }
}

// A vibration that the steps resolve goes on.
TEST(HeldMatter, TheMidpointRuleLetsWhatPointsHoldVibrate)
{
    Cantilever beam(2.5 * h);
    beam.cubes = fixtures::box(8, 1, 1, h, {.young = 1e6});
    beam.body = make_bricks(beam.cubes);
    beam.loads.pins = held_up_to(beam.cubes, 2.5 * h);
    State state = rest_state(beam.body);
    double early = 0, late = 0;  // m
    for (int i = 0; i < 240; ++i) {
        state = advance(beam.body, std::move(state), beam.loads, 1.0 / 240,
                        {.integrator = Integrator::implicit_midpoint, .substeps = 1});
        if (i < 80) early = std::max(early, beam.sag(state));
        if (i >= 160) late = std::max(late, beam.sag(state));
    }
    EXPECT_GT(early, 0.01);
    EXPECT_NEAR(late, early, 0.05 * early);
}

TEST(HeldMatter, AlongAnAxisThatItLeavesFreeABodyFalls)
{
    const Cubes cubes = fixtures::box(3, 2, 2, h, {.young = 1e7});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({Force::Kind::gravity, Vec3(3, -9.81, 0)});
    loads.pins = held_up_to(cubes, 1, 1);
    State state = rest_state(body);
    for (int i = 0; i < 3; ++i) state = advance(body, std::move(state), loads, 0.01);
    const double fall = 9.81 * 0.03 * 0.03 / 2;
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        EXPECT_NEAR(state.x[k].y(), cubes.corner_position(k).y() - fall, 1e-4 * fall);
        // 3 m/s^2 against 12 E / h^2 a volume: rho a h^2 / (12 E), a tenth of a micrometre.
        EXPECT_NEAR(state.x[k].x(), cubes.corner_position(k).x(), 1e-7);
    }
}

TEST(HeldMatter, HasTheStiffnessOfTheMaterialInThePlace)
{
    // The springs of all of a full cube resist a shift by 12 E h; those of its lower half by half.
    const Cubes cubes = fixtures::box(1, 1, 1, h, {.young = 1e7});
    const auto shift = [](const HeldMatter& matter) {
        double sum = 0;
        for (const HeldCube& cube : matter.cubes) {
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = 0; b < 8; ++b) sum += stiffness_at(cube, a, b);
            }
        }
        return sum;
    };
    const Outside all = outside_below(1), half = outside_below(h / 2);
    EXPECT_NEAR(shift(matter_within(cubes, all, nullptr, 7)), 12e7 * h, 12e7 * h * 1e-6);
    EXPECT_NEAR(shift(matter_within(cubes, half, nullptr, 7)), 6e7 * h, 6e7 * h * 1e-6);
    EXPECT_TRUE(matter_within(cubes, outside_below(-h), nullptr, 7).cubes.empty());
    // A slab from 3/8 to 5/8 of the cube: of its 2 layers of points, at 7/16 and 9/16, one is below
    // 0.47 h and none below 0.3 h. Spread over the cube, 2 of 8 layers are below 0.3 h.
    Cubes slab = cubes;
    slab.fill = {0.25};
    geometry::TriMesh mesh = geometry::box(Vec3(2 * h, h / 4, 2 * h), geometry::Vec3i(1, 1, 1));
    for (auto& p : mesh.positions) p.y() += static_cast<float>(h / 2);
    const geometry::TriangleBvh tree(mesh);
    const Outside low = outside_below(0.47 * h);
    EXPECT_NEAR(shift(matter_within(slab, low, &tree, 7)), 0.25 * 6e7 * h, 10);
    EXPECT_NEAR(shift(matter_within(slab, outside_below(0.3 * h), &tree, 7)), 0, 1e-9);
    EXPECT_NEAR(shift(matter_within(slab, outside_below(0.3 * h), nullptr, 7)),
                0.25 * 12e7 * h * 2 / 8, 10);
}

TEST(HeldMatter, EverySolverKnowsItsSprings)
{
    // Stiff bodies: the inverse at rest, and a factor of the step, take a few iterations where they
    // have the springs in them, and what they give is what conjugate gradients give.
    struct Shape {
        int length, thick;
        double young;
    };
    for (const auto& [length, thick, young] : {Shape{12, 6, 1e10}, Shape{100, 2, 1e10}}) {
        const Cubes cubes = fixtures::box(length, thick, thick, h, {.young = young});
        Loads loads;
        loads.forces.push_back({});
        loads.pins = held_up_to(cubes, 2.5 * h);
        StepOptions options;
        options.tolerance = 1e-6;
        const BricksBody body = make_bricks(cubes);
        BricksBody without = body;
        without.dissections = nullptr;
        without.multigrids = nullptr;
        const State rest = rest_state(body);
        const State a = advance(body, rest, loads, 1.0 / 24, options);
        const State b = advance(without, rest, loads, 1.0 / 24, options);
        EXPECT_LE(a.report.iterations, 15) << length;
        EXPECT_LT(farthest(a.x, b.x), 1e-4 * farthest(a.x, rest.x)) << length;
    }
}

TEST(HeldMatter, ModesAreThoseOfTheFreeLength)
{
    // The lowest of a cantilever: 1.8751^2 sqrt(E I / (rho A L^4)), less what shear and the turning
    // of sections take (0.2 % at 20 to 1).
    const Cubes cubes = fixtures::box(24, 1, 1, h, {.young = 1e7, .poisson = 0.3});
    const HeldMatter matter = held_up_to(cubes, 2.5 * h).matter;
    const Modes modes = lowest_modes(cubes, {}, {.count = 2}, matter.cubes);
    const double free = 21.5 * h;
    const double omega = 1.8751 * 1.8751 * std::sqrt(1e7 / 12 / 1000) * h / (free * free);
    for (const double sq : modes.omega_sq) EXPECT_NEAR(std::sqrt(sq) / omega, 1, 0.03);
}

TEST(HeldMatter, SpringsAreHeldAsWell)
{
    const Cubes cubes = fixtures::box(6, 2, 2, h, {.young = 1e7, .mass_damping = 200});
    const SpringsBody body = make_springs(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.pins = held_up_to(cubes, 1.5 * h);
    State state = rest_state(body);
    for (int i = 0; i < 60; ++i) state = advance(body, std::move(state), loads, 1.0 / 24);
    const double weight = 9.81 * geometry::total_mass(cubes);
    EXPECT_NEAR(pin_force(state, nullptr, Vec3::Zero()).force.y(), weight, 1e-3 * weight);
}

TEST(HeldMatter, PinsOfSeveralPlacesAddUpAndMethodsWithoutItSaySo)
{
    const Cubes cubes = fixtures::box(6, 1, 1, h);
    const auto one = std::make_shared<const Pins>(held_up_to(cubes, h));
    Transform away = Transform::Identity();
    away.translate(Vec3(0.1, 0, 0));
    const auto two = std::make_shared<const Pins>(held_up_to(cubes, 1.5 * h, all_axes, away));
    const std::vector<std::shared_ptr<const Pins>> both{one, two};
    const Pins all = merge_pins(both, cubes.corner_count());
    EXPECT_EQ(all.matter.cubes.size(), 3u);
    EXPECT_NO_THROW(check_pins(all, cubes.corner_count()));
    EXPECT_EQ(all.matter.target[all.matter.cubes[1].corner[0]], away * cubes.corner_position(0));
    EXPECT_EQ(conflicting_pins(both, 1e-3).size(), 1u);
    EXPECT_THROW(require_corners(all, "method lattice"), std::invalid_argument);
    EXPECT_THROW(check_pins(all, 3), std::invalid_argument);
}

TEST(HeldMatter, RefusesCubesThatAreNotThoseOfThePin)
{
    const Cubes cubes = fixtures::box(4, 1, 1, h), longer = fixtures::box(9, 1, 1, h);
    const Pins pins = held_up_to(longer, 1);
    EXPECT_NO_THROW(check_held(longer, pins.matter));
    EXPECT_THROW(check_held(cubes, pins.matter), std::invalid_argument);
    // As many cubes, of other corners.
    EXPECT_THROW(check_held(fixtures::box(3, 3, 1, h), pins.matter), std::invalid_argument);
}

TEST(HeldMatter, ForcesAreThoseOfPinsThatWereSimulated)
{
    Cantilever of(2 * h);
    State state = rest_state(of.body);
    for (int i = 0; i < 3; ++i) state = advance(of.body, std::move(state), of.loads, 1.0 / 24, {});
    EXPECT_GT(pin_force(state, &of.loads.pins, Vec3::Zero()).pins, 0u);
    const Pins others = held_up_to(of.cubes, 3 * h);
    EXPECT_EQ(pin_force(state, &others, Vec3::Zero()).pins, 0u);
}

// Springs that are loaded stay so while another pin comes and goes, within each of some steps.
TEST(HeldMatter, APinThatComesLeavesOthersAsTheyWere)
{
    std::vector<geometry::Vec3i> cells;
    for (int x = 0; x < 6; ++x) cells.emplace_back(x, 0, 0);
    cells.emplace_back(20, 0, 0);  // for itself
    const Cubes cubes = fixtures::cubes_on(cells, h, {.young = 1e6, .stiffness_damping = 0.05});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    const auto both = [&](bool second) {
        const auto place = [second](const Vec3& p) {
            return p.x() > 15 * h ? (second ? -1.0 : 1.0) : p.x() - h;
        };
        return matter_at(cubes, matter_within(cubes, place, nullptr, all_axes),
                         Transform::Identity());
    };
    loads.pins = both(false);
    State state = rest_state(body);
    for (int i = 0; i < 60; ++i) {
        state = advance(body, std::move(state), loads, 1.0 / 24, {.substeps = 4});
    }
    loads.pins = both(true);
    const State next = advance(body, state, loads, 1.0 / 24, {.substeps = 4});
    const auto far = [&](std::uint32_t k) { return cubes.corner[k].x() > 15; };
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (far(k)) continue;
        EXPECT_LT((next.x[k] - state.x[k]).norm(), 1e-4 * h);
    }
}

}  // namespace
