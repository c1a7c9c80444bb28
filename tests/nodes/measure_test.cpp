// What Measure tells of a simulation, against closed forms.

#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <numbers>

namespace {

using fixtures::Scene;

// A box of 0.4 x 0.2 x 0.2 m of 1000 kg/m^3, 16 kg, 4 x 2 x 2 cubes, or one upright of 0.2 x 1 x
// 0.2 m, 40 kg; and what is measured of them.
std::string body(const std::string& size, const std::string& matter)
{
    return R"("box": { "type": "Primitive@1", "params": { "shape": "box", "box": { "size": )" +
           size + R"( } } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" }, "params": {
                   "method": "solid", "size": 0.1, "matter": { "density": 1000, )" +
           matter + R"( } } })";
}

std::string measured(const std::string& what, const std::string& inputs, const std::string& more)
{
    return fmt::format(R"(, "{0}": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state"{1} }},
                            "params": {{ "what": "{0}"{2} }} }})",
                       what, inputs, more);
}

// Hung by its top, the bar rests: its pins carry m g = 392.4 N, also about a point a metre away. It
// holds (rho g)^2 A L^3 / (6 E) = 0.6416 J, and the middle of its top cubes carries rho g (L - h /
// 2) = 9319.5 Pa. Ten cubes in a row miss 1 / (4 n^2) of the energy at most.
TEST(Measure, OfAHangingBarForcesStressAndEnergyAreThoseOfTheBook)
{
    const std::string down = R"(, "direction": [0, 1, 0])";
    Scene scene(
        body("[0.2, 1, 0.2]", R"("young": 1e6, "poisson": 0)") + R"(,
        "top": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                 "where": "ends", "ends": { "axis": "y", "end": "high", "layers": 0 } } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes", "pins": ["top.pins"] },
                 "params": { "initial_shape": "equilibrium" } })" +
        measured("reaction_force", R"(, "pins": "top.pins")", down) +
        measured("reaction_torque", "", R"(, "direction": [0, 0, 1], "point": [-1, 0, 0])") +
        measured("elastic_energy", "", "") + measured("stress_max", "", ""));
    for (const int frame : {1, 3}) {  // settled, and after steps that leave it so
        EXPECT_NEAR(*scene.at<double>("reaction_force", frame), 392.4, 0.1);
        EXPECT_NEAR(*scene.at<double>("reaction_torque", frame), 392.4, 0.1);
        EXPECT_NEAR(*scene.at<double>("elastic_energy", frame), 0.6416, 0.008);
        EXPECT_NEAR(*scene.at<double>("stress_max", frame), 9319.5, 100);
    }
}

// The box flies at 1 m/s along x and turns at a quarter a second about z: I = m (0.4^2 + 0.2^2) /
// 12, of which cubes two thick have at most 2 % more. Nothing acts on it.
TEST(Measure, OfAFlyingBoxMomentaAndInertiaAreThoseOfARigidOne)
{
    const std::string own = R"(, "cubes": "cubes.cubes")", z = R"(, "direction": [0, 0, 1])";
    const std::string x = R"(, "direction": [1, 0, 0])";
    Scene scene(body("[0.4, 0.2, 0.2]", R"("young": 1e7)") + R"(,
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" }, "params": {
                 "gravity": [0, 0, 0], "initial_velocity": [1, 0, 0],
                 "initial_spin_degrees": [0, 0, 90] } })" +
                measured("momentum", own, x) + measured("angular_momentum", own, z) +
                measured("centre_of_mass", own, x) + measured("moment_of_inertia", own, z) +
                measured("kinetic_energy", own, ""));
    const double inertia = 16 * (0.16 + 0.04) / 12, spin = std::numbers::pi / 2;
    EXPECT_NEAR(*scene.at<double>("moment_of_inertia"), inertia, 0.02 * inertia);
    const double own_inertia = *scene.at<double>("moment_of_inertia");
    for (const int frame : {1, 25}) {
        EXPECT_NEAR(*scene.at<double>("momentum", frame), 16, 1e-6);
        EXPECT_NEAR(*scene.at<double>("angular_momentum", frame), own_inertia * spin,
                    1e-3 * own_inertia);
        EXPECT_NEAR(*scene.at<double>("centre_of_mass", frame), (frame - 1) / 24.0, 1e-6);
    }
    EXPECT_NEAR(*scene.at<double>("kinetic_energy"), 0.5 * 16 + 0.5 * own_inertia * spin * spin,
                1e-4);
}

// Pins move evenly within a frame, so that all of what they speed up is in its first step. One that
// moves 16 kg with 4 m/s^2 pushes by 64 N, however many steps that takes. (A tolerance is a share
// of the forces at work, which are high where springs are drawn along.)
TEST(Measure, ForcesOfPinsAreThoseOfAllStepsOfAFrame)
{
    struct Case {
        const char *hold, *rigid;
        int substeps;
        const char* integrator;
    };
    for (const Case& one : {Case{"corners", "false", 1, "implicit_euler"},
                            {"corners", "false", 8, "implicit_euler"},
                            {"corners", "true", 8, "implicit_euler"},
                            {"points", "false", 2, "implicit_euler"},
                            {"points", "true", 8, "implicit_euler"},
                            {"corners", "false", 1, "sdirk2"},
                            {"corners", "false", 4, "sdirk2"}}) {
        Scene scene(
            body("[0.4, 0.2, 0.2]", R"("young": 1e7, "stiffness_damping": 0.01)") +
            fmt::format(R"(,
        "end": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params": {{
                  "hold": "{}", "where": "ends", "ends": {{ "end": "low" }},
                  "translate": ["=2 * time^2", 0, 0] }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                  "pins": ["end.pins"] }}, "params": {{ "gravity": [0, 0, 0],
                  "bodies": [{{ "rigid": {} }}],
                  "step": {{ "substeps": {}, "integrator": "{}", "tolerance": 1e-7 }} }} }})",
                        one.hold, one.rigid, one.substeps, one.integrator) +
            measured("reaction_force", R"(, "pins": "end.pins")", R"(, "direction": [1, 0, 0])"));
        EXPECT_NEAR(*scene.at<double>("reaction_force", 13), 64, 1)
            << one.hold << one.rigid << one.substeps << one.integrator;
    }
}

// A bar of 10 kg and 1 m that pins turn about its middle, 30 degrees a frame: I w^2 / 2 = 66.455 J,
// and nothing that keeps it turning. Along chords its pins moved slower than they turn.
TEST(Measure, OfABarThatPinsTurnIsTheEnergyThatItTurnsWith)
{
    for (const char* const hold : {"corners", "points"}) {
        for (const char* const rigid : {"true", "false"}) {
            for (const int substeps : {1, 4, 8}) {
                Scene scene(
                    R"("box": { "type": "Primitive@1", "params": { "shape": "box",
                               "box": { "size": [1, 0.1, 0.1] } } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" }, "params": {
                   "method": "solid", "size": 0.05, "matter": { "density": 1000, "young": 1e7 } } })" +
                    fmt::format(R"(,
        "pin": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params": {{
                  "hold": "{}", "where": "box", "box": {{ "size": [0.4, 1, 1] }},
                  "rotate_degrees": [0, "=30 * frame - 30", 0] }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                  "surface": "box.mesh", "pins": ["pin.pins"] }}, "params": {{
                  "gravity": [0, 0, 0], "bodies": [{{ "rigid": {} }}],
                  "step": {{ "substeps": {} }} }} }})",
                                hold, rigid, substeps) +
                    measured("kinetic_energy", R"(, "cubes": "cubes.cubes")", "") +
                    measured("reaction_torque", "", R"(, "direction": [0, 1, 0])"));
                const double energy = *scene.at<double>("kinetic_energy", 13);
                const double torque = *scene.at<double>("reaction_torque", 13);
                EXPECT_NEAR(energy, 66.455, 0.3) << hold << rigid << substeps;
                EXPECT_NEAR(torque, 0, 1) << hold << rigid << substeps;
            }
        }
    }
}

// Two pins hold the same points, along y and along x and z. Weight and a wind along x, as gravity
// has them, are told apart.
TEST(Measure, ForcesOfPinsOfTheSamePointsAreToldApart)
{
    const auto pin = [](const char* name, const char* axes) {
        return fmt::format(R"(,
        "{}": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params": {{
                 "hold": "points", "axes": "{}", "where": "ends", "ends": {{ "end": "low" }} }} }})",
                           name, axes);
    };
    const auto force = [](const char* name, const char* of, const char* direction) {
        return fmt::format(R"(,
        "{}": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state", "pins": "{}.pins" }},
                 "params": {{ "what": "reaction_force", "direction": {} }} }})",
                           name, of, direction);
    };
    Scene scene(body("[0.4, 0.2, 0.2]", R"("young": 1e7)") + pin("up", "y") + pin("side", "xz") +
                R"(,
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
                 "pins": ["up.pins", "side.pins"] }, "params": { "gravity": [-3, -9.81, 0],
                 "initial_shape": "equilibrium" } })" +
                force("up_y", "up", "[0, 1, 0]") + force("up_x", "up", "[1, 0, 0]") +
                force("side_y", "side", "[0, 1, 0]") + force("side_x", "side", "[1, 0, 0]"));
    for (const int frame : {1, 3}) {
        EXPECT_NEAR(*scene.at<double>("up_y", frame), 16 * 9.81, 0.1);
        EXPECT_NEAR(*scene.at<double>("side_x", frame), 16 * 3, 0.1);
        EXPECT_EQ(*scene.at<double>("up_x", frame), 0);
        EXPECT_EQ(*scene.at<double>("side_y", frame), 0);
    }
}

// Two boxes on the ground, one of them pinned, and a simulation of another kind that goes on from
// one of bricks: each quantity is told of what it is asked of, and of nothing older.
TEST(Measure, KnowsBodiesAndSimulationsApart)
{
    const std::string box = body("[0.4, 0.2, 0.2]", R"("young": 1e6)");
    Scene scene(box + R"(,
        "far": { "type": "Primitive@1", "params": { "shape": "box", "centre": [3, 0, 0],
                 "box": { "size": [0.4, 0.2, 0.2] } } },
        "heavy": { "type": "Voxelize@1", "inputs": { "mesh": "far.mesh" }, "params": { "method":
                   "solid", "size": 0.1, "matter": { "density": 3000, "young": 1e6 } } },
        "floor": { "type": "Ground@1", "params": { "height": -0.1 } },
        "p1": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                "where": "ends", "ends": { "end": "low" } } },
        "p2": { "type": "Pin@1", "inputs": { "cubes": "heavy.cubes" }, "params": {
                "where": "ends", "ends": { "axis": "y", "end": "high", "layers": 2 } } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": ["cubes.cubes", "heavy.cubes"],
                 "pins": ["p1.pins", "p2.pins"], "colliders": ["floor.collider"] } },
        "second": { "type": "Measure@1", "inputs": { "state": "sim.state", "pins": "p2.pins" },
                    "params": { "what": "reaction_force" } },
        "own": { "type": "Measure@1", "inputs": { "state": "sim.state", "pins": "p2.pins",
                 "cubes": "heavy.cubes" }, "params": { "what": "reaction_force" } },
        "mixed": { "type": "Measure@1", "inputs": { "state": "sim.state", "pins": "p2.pins",
                   "cubes": "cubes.cubes" }, "params": { "what": "reaction_force" } },
        "deep": { "type": "Measure@1", "inputs": { "state": "sim.state" },
                  "params": { "what": "contact_depth" } },
        "deep_of": { "type": "Measure@1", "inputs": { "state": "sim.state",
                     "cubes": "cubes.cubes" }, "params": { "what": "contact_depth" } },
        "bricks": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
                    "pins": ["p1.pins"] } },
        "then": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
                  "start": "bricks.state" }, "params": { "method": "lattice" } },
        "plain": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "method": "lattice" } },
        "turning": { "type": "Measure@1", "inputs": { "state": "then.state",
                     "cubes": "cubes.cubes" }, "params": { "what": "moment_of_inertia" } },
        "lumped": { "type": "Measure@1", "inputs": { "state": "plain.state",
                    "cubes": "cubes.cubes" }, "params": { "what": "moment_of_inertia" } })");
    EXPECT_DOUBLE_EQ(*scene.at<double>("turning"), *scene.at<double>("lumped"));
    const double held = *scene.at<double>("second", 4);
    EXPECT_NEAR(held, 48 * 9.81, 0.02 * 48 * 9.81);  // all of it is pinned
    EXPECT_EQ(*scene.at<double>("own", 4), held);
    EXPECT_NE(scene.failure_at<double>("mixed", 4).find("pins are of other cubes"),
              std::string::npos);
    EXPECT_GT(*scene.at<double>("deep", 4), 0);
    EXPECT_EQ(*scene.at<double>("deep_of", 4), *scene.at<double>("deep", 4));
    EXPECT_TRUE(scene.at<physics::State>("then", 4)->reactions.empty());
}

// Two ends of a box are held for two frames, then one, then none: those that let go exert no force,
// while another Pin holds too. Corners and points of the material, and rigid bodies.
TEST(Measure, OfAPinThatHasLetGoTheForceIsZero)
{
    for (const std::string hold : {"corners", "points"}) {
        for (const std::string rigid : {"false", "true"}) {
            const auto pin = [&](const std::string& end, const std::string& on) {
                return fmt::format(R"(, "{0}": {{ "type": "Pin@1", "inputs": {{ "cubes":
                    "cubes.cubes" }}, "params": {{ "hold": "{1}", "where": "ends", "on": "{2}",
                    "ends": {{ "end": "{0}", "axis": "y" }} }} }})",
                                   end, hold, on);
            };
            const auto force = [](const std::string& name, const std::string& pins) {
                return fmt::format(R"(, "{}": {{ "type": "Measure@1", "inputs": {{ "state":
                    "sim.state"{} }}, "params": {{ "what": "reaction_force" }} }})",
                                   name, pins);
            };
            Scene scene(body("[0.4, 0.2, 0.2]", R"("young": 1e6)") + pin("low", "=frame < 3") +
                        pin("high", "=frame < 5") + R"(, "sim": { "type": "Simulate@3", "inputs":
                        { "cubes": "cubes.cubes", "pins": ["low.pins", "high.pins"] },
                        "params": { "bodies": [{ "rigid": )" +
                        rigid + "}] } }" + force("all", "") +
                        force("of_low", R"(, "pins": "low.pins")") +
                        force("of_high", R"(, "pins": "high.pins")"));
            const auto at = [&](const char* node, int frame) {
                return *scene.at<double>(node, frame);
            };
            EXPECT_NE(at("of_low", 2), 0) << hold << rigid;
            for (const int frame : {3, 4}) {
                EXPECT_EQ(at("of_low", frame), 0) << hold << rigid;
                EXPECT_EQ(at("of_high", frame), at("all", frame)) << hold << rigid;
                EXPECT_NE(at("all", frame), 0) << hold << rigid;
            }
            for (const char* node : {"of_low", "of_high", "all"}) EXPECT_EQ(at(node, 5), 0) << node;
        }
    }
}

// Before anything is cooked, and not at the first frame that is asked for.
TEST(Measure, OfASimulationThatLacksTheQuantitySaysSoAtOnce)
{
    const auto said = [](const std::string& method, const std::string& what,
                         const std::string& pins = "") {
        const std::string text =
            R"({ "aspic": 1, "nodes": { "plane": { "type": "Plane@1" },
            "pin": { "type": "Pin@1", "inputs": { "cubes": "plane.cubes" }, "params": {
                     "where": "rim" } },
            "sim": { "type": "Simulate@3", "inputs": { "cubes": ["plane.cubes"])" +
            pins + R"( }, "params": { "method": ")" + method + R"(" } },
            "m": { "type": "Measure@1", "inputs": { "state": "sim.state" },
                   "params": { "what": ")" +
            what + R"(" } } } })";
        std::string all;
        for (const auto& problem :
             graph::load_text(text, "scene.json", nodes::registry()).problems) {
            all += problem.message + "\n";
        }
        return all;
    };
    EXPECT_EQ(said("shell", "stress_max"),
              "only method bricks knows the stress of cubes, and 'sim' has method shell\n");
    EXPECT_EQ(said("shell", "elastic_energy"),
              "only method bricks knows the elastic energy of cubes, and 'sim' has method shell\n");
    EXPECT_EQ(said("shell", "speed_max"), "");
    const std::string pins = R"(, "pins": ["pin.pins"])";
    EXPECT_EQ(said("shell", "reaction_force"),
              "'sim' has no pins whose force to measure: link a Pin to its input 'pins'\n");
    EXPECT_EQ(said("shell", "reaction_torque", pins), "");
    EXPECT_EQ(said("lattice", "reaction_force", pins),
              "method lattice knows no forces of pins, and 'sim' has it: bricks, springs and shell "
              "know them\n");
    EXPECT_EQ(said("bricks", "stress_max"), "");
}

TEST(Measure, OfRigidBodiesSaysThatInertiaIsThatOfCubes)
{
    const auto hints = [](const std::string& what, const std::string& bodies) {
        const std::string text = R"({ "aspic": 1, "nodes": {
            "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
            "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "ball.mesh" },
                       "params": { "method": "solid", "size": 0.2 } },
            "sim": { "type": "Simulate@3", "inputs": { "cubes": ["cubes.cubes", "cubes.cubes"] },
                     "params": { "bodies": [)" +
                                 bodies + R"(] } },
            "m": { "type": "Measure@1", "inputs": { "state": "sim.state", "cubes": "cubes.cubes" },
                   "params": { "what": ")" +
                                 what + R"(" } } } })";
        int count = 0;
        for (const auto& problem :
             graph::load_text(text, "scene.json", nodes::registry()).problems) {
            EXPECT_EQ(problem.severity, graph::Severity::warning) << problem.message;
            if (problem.node == "m") ++count;
        }
        return count;
    };
    const std::string rigid = R"({ "rigid": true })";
    EXPECT_EQ(hints("moment_of_inertia", rigid + ", " + rigid), 1);
    EXPECT_EQ(hints("angular_momentum", rigid + ", " + rigid), 1);
    EXPECT_EQ(hints("momentum", rigid + ", " + rigid), 0);
    EXPECT_EQ(hints("moment_of_inertia", rigid + ", {}"), 0);
    EXPECT_EQ(hints("moment_of_inertia", ""), 0);
}

TEST(Measure, CountsComponentsThatNobodySought)
{
    Scene scene(R"("box": { "type": "Primitive@1", "params": { "shape": "box",
                            "box": { "size": [0.2, 0.2, 0.2] } } },
        "row": { "type": "Copies@1", "inputs": { "mesh": "box.mesh" }, "params": {
                 "count_x": 3, "step": [1, 0, 0] } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "row.mesh" }, "params": {
                   "method": "solid", "size": 0.1 } },
        "largest": { "type": "ConnectedComponent@1", "inputs": { "cubes": "cubes.cubes" } },
        "all": { "type": "Measure@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                 "what": "components" } },
        "one": { "type": "Measure@1", "inputs": { "cubes": "largest.cubes" }, "params": {
                 "what": "components" } })");
    EXPECT_EQ(*scene.at<double>("all"), 3);
    EXPECT_EQ(*scene.at<double>("one"), 1);
}

TEST(Measure, SaysWhatIsMissing)
{
    Scene scene(body("[0.4, 0.2, 0.2]", R"("young": 1e6)") + R"(,
        "end": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                 "where": "ends", "ends": { "end": "low" } } },
        "other": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                   "where": "ends", "ends": { "end": "high" } } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes", "pins": ["end.pins"] } },
        "free": { "type": "Measure@1", "inputs": { "state": "sim.state", "pins": "other.pins" },
                  "params": { "what": "reaction_force" } })");
    EXPECT_EQ(scene.failure_at<double>("free"), "");  // at the start there is none
    const std::string told = scene.failure_at<double>("free", 2);
    EXPECT_NE(told.find("none of the corners or points of `pins` was held"), std::string::npos)
        << told;
}

}  // namespace
