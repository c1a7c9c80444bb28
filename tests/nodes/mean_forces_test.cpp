// Forces that a frame tells of, of pins and of what is touched, by each integrator: they are what
// changes the momentum within the frame.

#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace {

using fixtures::Scene;

constexpr double g = 9.81;     // m/s^2
constexpr double rate = 24.0;  // frames a second

struct Steps {
    const char* integrator;
    int substeps;
};
const auto all_steps = {Steps{"implicit_euler", 1}, {"implicit_euler", 4}, {"implicit_midpoint", 1},
                        {"implicit_midpoint", 4},   {"sdirk2", 1},         {"sdirk2", 4}};

std::string step(const Steps& steps)
{
    return fmt::format(R"("step": {{ "substeps": {}, "integrator": "{}", "tolerance": 1e-9,
                                     "newton_iterations": 5 }})",
                       steps.substeps, steps.integrator);
}

std::string measure(const char* name, const char* what, const char* params)
{
    return fmt::format(R"(, "{}": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state",
        "cubes": "cubes.cubes" }}, "params": {{ "what": "{}"{} }} }})",
                       name, what, params);
}

constexpr const char* along_x = R"(, "direction": [1, 0, 0])";
constexpr const char* along_y = R"(, "direction": [0, 1, 0])";

// 16 kg, its bottom at a height (m).
std::string box(double low, double young)
{
    return fmt::format(R"("mesh": {{ "type": "Primitive@1", "params": {{ "shape": "box",
            "box": {{ "size": [0.4, 0.2, 0.2] }}, "centre": [0, {}, 0] }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "mesh.mesh" }}, "params": {{
            "method": "solid", "size": 0.1, "align": "origin",
            "matter": {{ "density": 1000, "young": {}, "stiffness_damping": 0 }} }} }},)",
                       low + 0.1, young);
}

// N, what changed the momentum of 16 kg in the frame but for gravity (of y alone).
double true_force(Scene& scene, const char* momentum, double gravity, int frame)
{
    const double gained =
        *scene.at<double>(momentum, frame) - *scene.at<double>(momentum, frame - 1);
    return rate * gained + 16 * gravity;
}

// A quarter of the box, or all of it, is moved ever faster, and the rest swings on it.
TEST(MeanForces, OfPinsAreWhatChangesTheMomentum)
{
    for (const char* const hold : {"corners", "points"}) {
        for (const double held : {0.2, 9.0}) {
            for (const Steps& steps : all_steps) {
                Scene scene(
                    box(0, 1e6) +
                    fmt::format(
                        R"("pin": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
                        "params": {{ "hold": "{}", "where": "box", "box": {{ "size": [{}, 9, 9],
                        "centre": [-0.2, 0, 0] }}, "translate": ["=2 * time^2", 0, 0] }} }},
                        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                        "pins": ["pin.pins"] }}, "params": {{ {} }} }})",
                        hold, held, step(steps)) +
                    measure("px", "momentum", along_x) + measure("py", "momentum", along_y) +
                    measure("fx", "reaction_force", along_x) +
                    measure("fy", "reaction_force", along_y));
                for (int frame = 2; frame < 7; ++frame) {
                    const auto where = fmt::format("{} {} {} {}: {}", hold, held, steps.integrator,
                                                   steps.substeps, frame);
                    EXPECT_NEAR(*scene.at<double>("fx", frame), true_force(scene, "px", 0, frame),
                                0.1)
                        << where;
                    EXPECT_NEAR(*scene.at<double>("fy", frame), true_force(scene, "py", g, frame),
                                0.1)
                        << where;
                }
            }
        }
    }
}

// A soft box that falls by 2 cm, and rests and swings on the ground.
TEST(MeanForces, OfTheGroundAreWhatChangesTheMomentum)
{
    for (const Steps& steps : all_steps) {
        Scene scene(box(0.02, 1e5) +
                    fmt::format(R"("ground": {{ "type": "Ground@1" }},
                        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                        "colliders": ["ground.collider"], "surface": "mesh.mesh" }},
                        "params": {{ {} }} }})",
                                step(steps)) +
                    measure("py", "momentum", along_y) + measure("fy", "contact_force", along_y));
        for (int frame = 2; frame < 12; ++frame) {
            EXPECT_NEAR(*scene.at<double>("fy", frame), true_force(scene, "py", g, frame), 1)
                << steps.integrator << steps.substeps << ": " << frame;
        }
    }
}

// N, what a pin of the far half holds a body by that two pins turn about y by 5 degrees a frame:
// towards the axis.
double pull_of_half(const std::string& body, const char* method, const Steps& steps)
{
    const auto pin = [](const char* name, double x) {
        return fmt::format(R"("{}": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
            "params": {{ "hold": "corners", "where": "box", "box": {{ "size": [0.9, 9, 9],
            "centre": [{}, 0, 0] }}, "rotate_degrees": [0, "=5 * frame - 5", 0] }} }},)",
                           name, x);
    };
    const auto along = [](const char* name, const char* direction) {
        return fmt::format(R"(, "{}": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state",
            "pins": "far.pins" }}, "params": {{ "what": "reaction_force", "direction": {} }} }})",
                           name, direction);
    };
    Scene scene(body + pin("far", 0.5) + pin("near", -0.4) +
                fmt::format(R"("sim": {{ "type": "Simulate@3", "inputs": {{
                    "cubes": "cubes.cubes", "pins": ["far.pins", "near.pins"] }},
                    "params": {{ "method": "{}", "gravity": [0, 0, 0], {} }} }})",
                            method, step(steps)) +
                along("x", "[1, 0, 0]") + along("z", "[0, 0, 1]"));
    return std::hypot(*scene.at<double>("x", 6), *scene.at<double>("z", 6));
}

// Mass times w^2 r of half of a body, as its ends have it. In bars of 40 kg/m, whose mass is spread
// over cubes, that is 40 (10 0.1^3 / 3 + (0.2^2 - 0.1^2) / 2) kg m for the corners at 0.1 and
// 0.2 m; in a plate of 8 kg/m, whose mass is on its corners, 8 (0.1 0.1 + 0.05 0.2) kg m.
TEST(MeanForces, OfPinsThatTurnHoldEachHalf)
{
    const double rate_sq = std::pow(5 * std::numbers::pi / 180 * rate, 2);
    const double of_box = 40 * (10 * 0.001 / 3 + 0.015) * rate_sq;
    const double of_plate = 8 * (0.1 * 0.1 + 0.05 * 0.2) * rate_sq;
    const std::string plate = R"("cubes": { "type": "Plane@1", "params": { "sides": { "u": 0.4,
        "v": 0.8 }, "size": 0.1, "thickness": 0.01, "matter": { "density": 1000,
        "young": 1e6 } } },)";
    for (const Steps& steps : all_steps) {
        const auto where = fmt::format("{} {}", steps.integrator, steps.substeps);
        EXPECT_NEAR(pull_of_half(box(-0.1, 1e6), "bricks", steps), of_box, 0.005 * of_box) << where;
        EXPECT_NEAR(pull_of_half(plate, "shell", steps), of_plate, 0.005 * of_plate) << where;
    }
}

// 16 kg that hang over from a hub at one end, which turns them about x by 30 degrees a frame. Their
// angular momentum stays: the hub has no moment about their centre, which lies at the origin.
TEST(MeanForces, OfAHubHoldTheMomentOfWhatHangsOver)
{
    for (const char* const hold : {"corners", "points"}) {
        for (const int substeps : {1, 8}) {
            Scene scene(
                box(-0.1, 1e6) +
                fmt::format(R"("pin": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
                    "params": {{ "hold": "{}", "where": "box", "box": {{ "size": [0.25, 9, 9],
                    "centre": [-0.2, 0, 0] }}, "rotate_degrees": ["=30 * frame - 30", 0, 0] }} }},
                    "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                    "pins": ["pin.pins"] }}, "params": {{ "bodies": [{{ "rigid": true }}],
                    "step": {{ "substeps": {}, "tolerance": 1e-9 }} }} }})",
                            hold, substeps) +
                measure("about_y", "reaction_torque", along_y) +
                measure("about_z", "reaction_torque", R"(, "direction": [0, 0, 1])"));
            const double moment = 16 * g * 0.15;  // N m, of their weight about the hub
            const auto at = [&](const char* name) { return *scene.at<double>(name, 6); };
            EXPECT_NEAR(at("about_z"), 0, 0.02 * moment) << hold << substeps;
            EXPECT_NEAR(at("about_y"), 0, 0.02 * moment) << hold << substeps;
        }
    }
}

}  // namespace
