// Simulate with method = shell, and what it refuses.

#include "geometry/cubes/local_matter.hpp"
#include "geometry/cubes/plane.hpp"
#include "physics/state/state_models.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace {

using fixtures::NodeRun;
using geometry::Cubes;
using geometry::Vec3;

std::string what_is_wrong(NodeRun& node)
{
    try {
        node.run();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "nothing was refused";
}

NodeRun shell_of(const Cubes& cubes)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {graph::Value::of(cubes)};
    simulate.param("method").is = std::string("shell");
    return simulate;
}

// 10 by 2 cells of 0.1 m, 1 cm thick, across y, of density 1000.
Cubes strip()
{
    return geometry::plane_cubes(geometry::rectangle_cells(10, 2), {1, 0.1, {0, 0, 0}}, 0.01,
                                 {"strip", 1000, 1e6, 0.3, 0, 0});
}

// How far a strip hangs down at rest under 1 mm/s^2, its corners at x <= 0.1 m held.
double sag(const Cubes& cubes, double bend)
{
    NodeRun simulate = shell_of(cubes);
    physics::Pins pins;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k].x() > 1) continue;
        pins.corner.push_back(k);
        pins.target.push_back(cubes.corner_position(k));
    }
    simulate.inputs["pins"] = {graph::Value::of(pins)};
    simulate.param("gravity").is = std::array<double, 3>{0, -1e-3, 0};
    simulate.param("shell.bend").is = bend;
    simulate.param("dt").is = 1000.0;  // it is at rest then
    simulate.param("step.tolerance").is = 1e-8;
    simulate.previous = simulate.outputs(1);
    const auto state = simulate.outputs(2)[0];
    double lowest = 0;
    for (const Vec3& x : state.as<physics::State>()->x) lowest = std::min(lowest, x.y());
    return -lowest;
}

// A flat sheet of 1 cm, E = 1 MPa, nu = 0.3 and density 1000, in the middle of the world, and what
// holds it. Frames after the first are at rest; the weight is small.
struct Flat {
    double along, across;  // m
    int cells;             // along
    bool triangles;        // of Sheet; if not, squares of Plane

    std::string nodes() const
    {
        const double size = along / cells;
        const std::string matter = R"("matter": { "density": 1000, "young": 1e6, "poisson": 0.3 })";
        if (!triangles) {
            return fmt::format(R"("flat": {{ "type": "Plane@1", "params": {{ "thickness": 0.01,
                "sides": {{ "u": {}, "v": {} }}, "size": {}, {} }} }})",
                               along, across, size, matter);
        }
        return fmt::format(R"(
            "grid": {{ "type": "Primitive@1", "params": {{ "shape": "grid", "grid": {{
                "size_x": {}, "size_z": {}, "divisions_x": {}, "divisions_z": {} }} }} }},
            "flat": {{ "type": "Sheet@1", "inputs": {{ "mesh": "grid.mesh" }},
                "params": {{ "thickness": 0.01, {} }} }})",
                           along, across, cells, std::lround(across / size), matter);
    }
};

// Of `pins`, nodes by the names in `held`.
std::string at_rest(const Flat& flat, const std::string& pins, const std::string& held,
                    double gravity)
{
    return flat.nodes() + ", " + pins +
           fmt::format(R"(,
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "flat.cubes", "pins": [{}] }},
            "params": {{ "method": "shell", "gravity": [0, {}, 0], "dt": 10000,
                "step": {{ "tolerance": 1e-9, "newton_iterations": 20 }} }} }})",
                       held, gravity);
}

double lowest_at(fixtures::Scene& scene, int frame)
{
    const auto state = scene.at<physics::State>("sim", frame);
    EXPECT_TRUE(state->report.converged) << state->report.residual;
    double lowest = 0;
    for (const Vec3& x : state->x) lowest = std::min(lowest, x.y());
    return -lowest;
}

constexpr double flat_weight = 1000 * 0.01 * 1e-4;  // N/m^2 where g is 1e-4
constexpr double flat_bend = 1e6 * 1e-6 / 12;       // E h^3 / 12, N m

}  // namespace

// w = 0.00406 q a^4 / D where its rim is a hinge, 0.00126 clamped (Timoshenko, Woinowsky-Krieger.
// Theory of plates and shells. 1959, tables 8 and 35), D = E h^3 / (12 (1 - nu^2)).
TEST(ShellNode, APlateWithFourEdgesHeldSagsAsPlateTheorySays)
{
    for (const bool triangles : {false, true}) {
        const Flat flat{1, 1, 16, triangles};
        fixtures::Scene scene(at_rest(flat, R"("rim": { "type": "Pin@1",
            "inputs": { "cubes": "flat.cubes" }, "params": { "where": "rim" } })",
                                      R"("rim.pins")", -1e-4));
        const double expected = 0.00406 * flat_weight / flat_bend * (1 - 0.3 * 0.3);
        EXPECT_NEAR(lowest_at(scene, 2) / expected, 1, 0.03) << triangles;
    }
}

TEST(ShellNode, AClampedPlateSagsAsPlateTheorySays)
{
    // Clamped at two rows: the plate between is 1 m.
    const Flat flat{1 + 2.0 / 24, 1 + 2.0 / 24, 26, false};
    const auto wall = [](const char* name, const char* axis) {
        return fmt::format(R"("{}": {{ "type": "Pin@1", "inputs": {{ "cubes": "flat.cubes" }},
            "params": {{ "where": "ends", "ends": {{ "axis": "{}" }} }} }})",
                           name, axis);
    };
    fixtures::Scene scene(at_rest(flat, wall("two", "x") + ", " + wall("others", "z"),
                                  R"("two.pins", "others.pins")", -1e-4));
    const double expected = 0.001265 * flat_weight / flat_bend * (1 - 0.3 * 0.3);
    EXPECT_NEAR(lowest_at(scene, 2) / expected, 1, 0.03);
}

// q L^4 / (8 E I) for each width, from the clamp on: the strip is free to curve across.
TEST(ShellNode, APlateWithOneEdgeHeldSagsAsABeam)
{
    for (const bool triangles : {false, true}) {
        const Flat flat{1 + 1.0 / 20, 0.2 + 0.01, 21, triangles};
        fixtures::Scene scene(at_rest(flat, R"("wall": { "type": "Pin@1",
            "inputs": { "cubes": "flat.cubes" }, "params": { "where": "ends",
            "ends": { "axis": "x", "end": "low" } } })",
                                      R"("wall.pins")", -1e-4));
        EXPECT_NEAR(lowest_at(scene, 2) / (flat_weight / (8 * flat_bend)), 1, 0.03) << triangles;
    }
}

// A strip between hinges is pressed together while a small weight bends it. With u = pi / 2
// sqrt(P / P_cr) its sag is that without P times 12 (2 / cos u - 2 - u^2) / (5 u^4) (Timoshenko,
// Gere. Theory of elastic stability. 1961, section 1.3). The P_cr of the sag at 0.8 of Euler's
// load, by the force on the hinge, is Euler's pi^2 E I / L^2.
TEST(ShellNode, AStripBucklesAtEulersLoad)
{
    const double across = 0.1, euler = std::pow(std::numbers::pi, 2) * flat_bend * across;
    const double strain = 0.8 * euler / (1e6 * 0.01 * across);
    for (const bool triangles : {false, true}) {
        const Flat flat{1, across, 20, triangles};
        const auto hinge = [](const char* name, const char* end, const std::string& move) {
            return fmt::format(R"("{}": {{ "type": "Pin@1", "inputs": {{ "cubes": "flat.cubes" }},
                "params": {{ "where": "ends", "ends": {{ "axis": "x", "end": "{}", "layers": 0 }},
                "translate": {} }} }})",
                               name, end, move);
        };
        const std::string press = fmt::format(R"(["=frame > 2 ? {} : 0", 0, 0])", -strain);
        fixtures::Scene scene(
            at_rest(flat, hinge("left", "low", "[0, 0, 0]") + ", " + hinge("right", "high", press),
                    R"("left.pins", "right.pins")", -1e-8) +
            R"(, "force": { "type": "Measure@1", "inputs": { "state": "sim.state",
                "pins": "left.pins" }, "params": { "what": "reaction_force",
                "direction": [1, 0, 0] } })");
        const double times = lowest_at(scene, 3) / lowest_at(scene, 2);
        const double pressed = *scene.at<double>("force", 3);
        double low = 0, high = std::numbers::pi / 2;
        for (int i = 0; i < 40; ++i) {
            const double u = (low + high) / 2;
            const double more = 12 * (2 / std::cos(u) - 2 - u * u) / (5 * std::pow(u, 4));
            (more < times ? low : high) = u;
        }
        const double critical = pressed * std::pow(std::numbers::pi / 2 / low, 2);
        EXPECT_NEAR(critical / euler, 1, 0.03) << triangles << " " << pressed << " " << times;
    }
}

TEST(ShellNode, AStripHeldAtOneEndSagsByItsWeightAndThickness)
{
    // q L^4 / (8 E I) from the clamp on, 9 cells: with h = 0.01, E = 1e6 and g = 1e-3 it is
    // 12 rho g L^4 / (8 E h^2) = 15 s^2/m^4 g L^4. Factors of bending divide it.
    const double expected = 15 * 1e-3 * std::pow(0.9, 4);
    EXPECT_NEAR(sag(strip(), 1), expected, 0.03 * expected);
    EXPECT_NEAR(sag(strip(), 4), expected / 4, 0.03 * expected / 4);
}

// Thickness h(s) from 14 mm at the clamp to 5 mm at the tip, L = 0.9 m on. Per width, the moment of
// the weight beyond s is M(s) = integral of rho g h(t) (t - s), and the sag at the tip
//   w = integral of M(s) (L - s) / (E h(s)^3 / 12),
// here by midpoints. A strip of the mean thickness sags 2.5 times as far.
TEST(ShellNode, ATaperedStripSagsByItsThicknessAtEachPlace)
{
    const auto thickness = [](double s) { return 0.014 - 0.01 * s; };
    const Cubes cubes =
        geometry::with_local_values(strip(), geometry::LocalProperty::thickness,
                                    geometry::cube_means(strip(), [&](const Vec3& p, std::size_t) {
                                        return thickness(p.x() - 0.1);
                                    }));
    constexpr int steps = 900;
    const double length = 0.9, ds = length / steps;
    double expected = 0;
    for (int i = 0; i < steps; ++i) {
        const double s = (i + 0.5) * ds;
        double moment = 0;
        for (int j = i; j < steps; ++j) {
            moment += 1000 * 1e-3 * thickness((j + 0.5) * ds) * (j - i) * ds * ds;
        }
        expected += moment * (length - s) / (1e6 * std::pow(thickness(s), 3) / 12) * ds;
    }
    EXPECT_NEAR(sag(cubes, 1), expected, 0.03 * expected);
}

// A strip falls for 0.5 s on another one that is held, 2 cm below it. With contact it lies on it, a
// thickness of 1 cm above; without, it has fallen through by more than 1 m.
TEST(ShellNode, SheetsOfTwoPlanesCollide)
{
    const Cubes held = strip();
    Cubes other = strip();
    other.origin += Vec3(0.03, 0.02, 0.02);
    physics::Pins pins;
    pins.cubes = physics::mark_of(held);
    for (std::uint32_t k = 0; k < held.corner_count(); ++k) {
        pins.corner.push_back(k);
        pins.target.push_back(held.corner_position(k));
    }
    for (const bool on : {true, false}) {
        NodeRun simulate = shell_of(held);
        simulate.inputs["cubes"].push_back(graph::Value::of(other));
        simulate.inputs["pins"] = {graph::Value::of(pins)};
        simulate.param("contact.on").is = on;
        simulate.param("dt").is = 0.05;
        simulate.previous = simulate.outputs(1);
        for (int frame = 2; frame <= 11; ++frame) simulate.previous = simulate.outputs(frame);
        const auto state = simulate.previous[0];
        const double last = state.as<physics::State>()->x.back().y();
        if (on) {
            EXPECT_NEAR(last, 0.01, 0.001);
        } else {
            EXPECT_LT(last, -1);
        }
    }
}

TEST(ShellNode, TellsWhatItDoesNotSupport)
{
    NodeRun solid = shell_of(geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}}, 0.1));
    const std::string said = what_is_wrong(solid);
    for (const char* part : {"method shell needs a plane", "make the cubes with Plane"}) {
        EXPECT_NE(said.find(part), std::string::npos) << said;
    }
    NodeRun balls = shell_of(strip());
    balls.inputs["balls"] = {graph::Value::of(physics::Ball{})};
    EXPECT_NE(what_is_wrong(balls).find("method = lattice"), std::string::npos);
    NodeRun bricks("Simulate");
    bricks.inputs["cubes"] = {graph::Value::of(strip())};
    EXPECT_NE(what_is_wrong(bricks).find("use method shell"), std::string::npos)
        << what_is_wrong(bricks);
}
