// Pins that hold some axes only: rollers, planes of symmetry, guides; against closed forms.

#include "physics/bricks/neo_hookean.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;
using graph::Value;
using Vector = std::array<double, 3>;

// The corners at one end along an axis.
NodeRun pin_at(const Value& cubes, const std::string& axis, const std::string& end,
               const std::string& axes)
{
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {cubes};
    pin.param("where").is = std::string("ends");
    pin.param("ends.axis").is = axis;
    pin.param("ends.end").is = end;
    pin.param("ends.layers").is = std::int64_t{0};
    pin.param("axes").is = axes;
    return pin;
}

NodeRun simulation(const Value& cubes, std::vector<Value> pins)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = std::move(pins);
    simulate.param("gravity").is = Vector{0, 0, 0};
    simulate.param("step.tolerance").is = 1e-11;
    return simulate;
}

double force_along(const Value& state, const Value& pins, const Vector& direction)
{
    NodeRun measure("Measure");
    measure.inputs["state"] = {state};
    measure.inputs["pins"] = {pins};
    measure.param("what").is = std::string("reaction_force");
    measure.param("direction").is = direction;
    return *measure.run().as<double>();
}

// A bar of 2 x 1 x 1 m, E = 1 MPa, nu = 0.3, stretched by 5 % between its ends. Forces are measured
// where a frame has gone by in that shape.
struct Stretched {
    explicit Stretched(const std::string& end_axes, double by = 0.1,
                       const std::string& law = "corotated")
        : cubes(Value::of(fixtures::box(4, 2, 2, 0.5, {.young = 1e6, .poisson = 0.3})))
    {
        NodeRun pull = pin_at(cubes, "x", "high", end_axes);
        pull.param("translate").is = Vector{by, 0, 0};
        pulled = pull.run();
        sides = {pin_at(cubes, "y", "low", "y").run(), pin_at(cubes, "z", "low", "z").run()};
        NodeRun simulate = simulation(
            cubes, {pin_at(cubes, "x", "low", end_axes).run(), pulled, sides[0], sides[1]});
        simulate.param("bricks.law").is = law;
        simulate.param("initial_shape").is = std::string("equilibrium");
        const Value start = simulate.run();
        simulate.previous = {start};
        state = simulate.run();
    }

    Value cubes, pulled, state;
    std::vector<Value> sides;
};

TEST(AxisPins, ABarBetweenRollersContractsFreelySideways)
{
    // One stress alone: sigma = E eps, and -nu eps across. 1 MPa * 0.05 * 1 m^2.
    const Stretched bar("x");
    EXPECT_NEAR(force_along(bar.state, bar.pulled, {1, 0, 0}), 5e4, 5e4 * 1e-6);
    const auto cubes = bar.cubes.as<geometry::Cubes>();
    const auto state = bar.state.as<physics::State>();
    for (std::uint32_t k = 0; k < cubes->corner_count(); ++k) {
        const Vec3 goal = cubes->corner_position(k).cwiseProduct(Vec3(1.05, 0.985, 0.985));
        EXPECT_LT((state->x[k] - goal).norm(), 1e-8) << k;
    }
    // Planes of symmetry take nothing along them, and here nothing across either.
    for (const Value& side : bar.sides) {
        EXPECT_NEAR(force_along(bar.state, side, {1, 1, 1}), 0, 5e4 * 1e-6);
    }
}

TEST(AxisPins, ABarOfRubberPulledToTwiceItsLengthHasTheClosedFormsForceAndWidth)
{
    const Stretched bar("x", 2.0, "neo_hookean");
    const physics::NeoHookean law(physics::lame(1e6, 0.3));
    const auto stress = [&](double across) -> geometry::Mat3 {
        return law.stress(Vec3(2, across, across).asDiagonal());
    };
    double low = 0.3, high = 1;  // no stress across
    for (int i = 0; i < 100; ++i) {
        const double across = 0.5 * (low + high);
        (stress(across)(1, 1) > 0 ? high : low) = across;
    }
    const double force = stress(low)(0, 0);
    EXPECT_NEAR(force_along(bar.state, bar.pulled, {1, 0, 0}), force, force * 1e-6);
    const auto cubes = bar.cubes.as<geometry::Cubes>();
    const auto state = bar.state.as<physics::State>();
    for (std::uint32_t k = 0; k < cubes->corner_count(); ++k) {
        const Vec3 goal = cubes->corner_position(k).cwiseProduct(Vec3(2, low, low));
        EXPECT_LT((state->x[k] - goal).norm(), 1e-7) << k;
    }
}

TEST(AxisPins, WhereClampsWouldHoldItWide)
{
    // Clamped ends keep the bar from contracting there: it is stiffer, by less than a bar that is
    // held on all its sides, (1 - nu) / (1 + nu) / (1 - 2 nu) = 1.346.
    const Stretched bar("xyz");
    const double force = force_along(bar.state, bar.pulled, {1, 0, 0});
    EXPECT_GT(force, 1.02 * 5e4);
    EXPECT_LT(force, 1.34 * 5e4);
}

TEST(AxisPins, AQuarterBetweenPlanesOfSymmetryIsTheWhole)
{
    const auto solved = [](const geometry::Cubes& model, bool quarter) {
        const Value cubes = Value::of(model);
        NodeRun push = pin_at(cubes, "x", "high", "xyz");
        push.param("translate").is = Vector{0.15, 0, 0};
        std::vector<Value> pins{pin_at(cubes, "x", "low", "xyz").run(), push.run()};
        if (quarter) {
            pins.push_back(pin_at(cubes, "y", "low", "y").run());
            pins.push_back(pin_at(cubes, "z", "low", "z").run());
        }
        NodeRun simulate = simulation(cubes, pins);
        simulate.param("initial_shape").is = std::string("equilibrium");
        return simulate.run().as<physics::State>();
    };
    const geometry::Cubes whole = fixtures::box(4, 4, 4, 0.25);
    std::vector<geometry::Vec3i> cells;
    for (const auto& cell : whole.cell) {
        if (cell.y() >= 2 && cell.z() >= 2) cells.push_back(cell);
    }
    const geometry::Cubes quarter = fixtures::cubes_on(cells, 0.25);
    const auto all = solved(whole, false), some = solved(quarter, true);
    double most = 0;
    for (std::uint32_t k = 0; k < quarter.corner_count(); ++k) {
        const auto same = std::find(whole.corner.begin(), whole.corner.end(), quarter.corner[k]);
        const Vec3 x = all->x[std::size_t(same - whole.corner.begin())];
        EXPECT_LT((some->x[k] - x).norm(), 1e-9) << k;
        most = std::max(most, std::abs(x.y() - quarter.corner_position(k).y()));
    }
    EXPECT_GT(most, 0.005);  // it does contract
}

TEST(AxisPins, ABlockOnRollersSlidesAsItFalls)
{
    // Gravity along x and y, held along y: it falls freely along x. The rollers carry the weight,
    // 1000 kg * 9.81 m/s^2, and of the block's sinking in on itself no more than damps out.
    const Value cubes =
        Value::of(fixtures::box(2, 2, 2, 0.5, {.young = 1e7, .stiffness_damping = 0.05}));
    const Value rollers = pin_at(cubes, "y", "low", "y").run();
    NodeRun simulate = simulation(cubes, {rollers});
    simulate.param("gravity").is = Vector{2, -9.81, 0};
    Value state = simulate.run();
    for (int i = 0; i < 12; ++i) {
        simulate.previous = {state};
        state = simulate.run();
    }
    EXPECT_TRUE(simulate.warnings.empty());
    const auto is = [&](const char* what, const Vector& direction) {
        NodeRun measure("Measure");
        measure.inputs["state"] = {state};
        measure.inputs["cubes"] = {cubes};
        measure.param("what").is = std::string(what);
        measure.param("direction").is = direction;
        return *measure.run().as<double>();
    };
    const double dt = 1.0 / 24;
    EXPECT_NEAR(is("momentum", {1, 0, 0}), 1000 * 12 * 2 * dt, 1e-6);
    EXPECT_NEAR(is("centre_of_mass", {1, 0, 0}), 0.5 + 2 * dt * dt * 144 / 2, 1e-9);
    EXPECT_NEAR(is("momentum", {0, 0, 1}), 0, 1e-6);
    EXPECT_NEAR(force_along(state, rollers, {0, 1, 0}), 9810, 1);
    EXPECT_EQ(force_along(state, rollers, {1, 0, 0}), 0);
    const auto pins = rollers.as<physics::Pins>();
    for (const auto k : pins->corner) EXPECT_EQ(state.as<physics::State>()->x[k].y(), 0);
}

TEST(AxisPins, AMovingPinLeadsAlongItsAxesOnly)
{
    // One layer of corners led along x and, by another pin, along z; all else falls freely: by
    // g dt^2 / 2 in a frame.
    const Value cubes = Value::of(fixtures::box(1, 1, 1, 0.5));
    NodeRun along_x = pin_at(cubes, "y", "low", "x"), along_z = pin_at(cubes, "y", "low", "z");
    along_x.param("translate").is = Vector{0.01, 5, 7};
    along_z.param("translate").is = Vector{3, 5, -0.02};
    for (const char* const method : {"bricks", "springs"}) {
        NodeRun simulate = simulation(cubes, {along_x.run(), along_z.run()});
        simulate.param("gravity").is = Vector{0, -9.81, 0};
        simulate.param("method").is = std::string(method);
        const Value start = simulate.run();
        simulate.previous = {start};
        const Value state = simulate.run();
        EXPECT_TRUE(simulate.warnings.empty());  // no two of one axis
        const auto x = state.as<physics::State>()->x;
        const auto pins = along_x.run().as<physics::Pins>();
        ASSERT_EQ(pins->corner.size(), 4u);
        double fallen = 0;
        for (std::uint32_t k = 0; k < 8; ++k) {
            const Vec3 at = cubes.as<geometry::Cubes>()->corner_position(k);
            fallen += (at.y() - x[k].y()) / 8;
            if (at.y() > 0) continue;
            EXPECT_EQ(x[k].x(), at.x() + 0.01);
            EXPECT_EQ(x[k].z(), at.z() - 0.02);
        }
        EXPECT_NEAR(fallen, 9.81 / 24 / 24 / 2, 1e-9) << method;
        EXPECT_EQ(force_along(state, along_x.run(), {0, 0, 1}), 0);
        EXPECT_GT(force_along(state, along_x.run(), {1, 0, 0}), 0);
        EXPECT_LT(force_along(state, along_z.run(), {0, 0, 1}), 0);
    }
}

template <class Run> std::string error_of(const Run& run)
{
    try {
        run();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

TEST(AxisPins, AreRefusedWhereTheyWouldBeHeldWholly)
{
    const Value cubes = Value::of(fixtures::box(2, 2, 1, 0.5));
    const Value rollers = pin_at(cubes, "y", "low", "y").run();
    for (const char* const method : {"lattice", "shell"}) {
        NodeRun plane("Plane");
        const Value model = std::string(method) == "shell" ? plane.run() : cubes;
        NodeRun simulate = simulation(model, {pin_at(model, "x", "low", "y").run()});
        simulate.param("method").is = std::string(method);
        EXPECT_EQ(
            error_of([&] { simulate.run(); }),
            "method " + std::string(method) +
                " does not take pins that leave axes free: set axes = xyz in Pin, or use Simulate "
                "with method bricks or springs");
    }
    NodeRun modes("Modes");
    modes.inputs["cubes"] = {cubes};
    modes.inputs["pins"] = {rollers};
    EXPECT_NE(error_of([&] { modes.run(); }).find("Modes does not take pins"), std::string::npos);
    // On rollers alone it would slide for ever.
    NodeRun simulate = simulation(cubes, {rollers});
    simulate.param("initial_shape").is = std::string("equilibrium");
    EXPECT_EQ(error_of([&] {
                  simulate.run();
              }).rfind("1 of 1 parts of the body have no pin that holds the x axis", 0),
              0u);
}

}  // namespace
