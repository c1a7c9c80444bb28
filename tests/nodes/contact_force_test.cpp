// Measure of contact forces: what rests is carried by its weight, by whatever it rests on.

#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace {

using fixtures::Scene;

constexpr double g = 9.81;

// A box of edge `size` (m) and 1000 kg/m^3 over x = `at`, its bottom at `low`.
std::string box(const std::string& name, double size, double at, double low)
{
    return fmt::format(R"("{0}_mesh": {{ "type": "Primitive@1", "params": {{ "shape": "box",
            "box": {{ "size": [{1}, {1}, {1}] }} }} }},
        "{0}_moved": {{ "type": "Transform@1", "inputs": {{ "mesh": "{0}_mesh.mesh" }},
            "params": {{ "translate": [{2}, {3}, 0] }} }},
        "{0}": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "{0}_moved.mesh" }}, "params": {{
            "method": "solid", "size": 0.1, "align": "origin",
            "matter": {{ "density": 1000, "young": 1e6, "stiffness_damping": 0.01 }} }} }},)",
                       name, size, at, low + size / 2);
}

std::string measure(const std::string& name, const std::string& inputs,
                    const std::string& params = "")
{
    return fmt::format(R"(, "{}": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state"{} }},
        "params": {{ "what": "contact_force"{} }} }})",
                       name, inputs, params);
}

constexpr const char* of_low = R"(, "cubes": "low.cubes")";
constexpr const char* of_high = R"(, "cubes": "high.cubes")";

// A box of 64 kg on the ground, one of 8 kg on it, and the first beside a ball that stands still.
void expect_weights(const char* bodies)
{
    Scene scene(box("low", 0.4, 0, 0) + box("high", 0.2, 0.05, 0.4) +
                    fmt::format(R"("ground": {{ "type": "Ground@1" }},
                "wall": {{ "type": "Collider@1", "params": {{ "kind": "sphere",
                           "translate": [5, 0, 0] }} }},
                "sim": {{ "type": "Simulate@3", "inputs": {{
                    "cubes": ["low.cubes", "high.cubes"],
                    "colliders": ["wall.collider", "ground.collider"] }},
                    "params": {{ "bodies": {} }} }})",
                                bodies) +
                    measure("all", "") + measure("low_all", of_low) + measure("high_all", of_high) +
                    measure("by_ground", of_low, R"(, "collider": 2)") +
                    measure("by_wall", of_low, R"(, "collider": 1)") +
                    measure("by_high", of_low + std::string(R"(, "against": "high.cubes")")) +
                    measure("by_low", of_high + std::string(R"(, "against": "low.cubes")")) +
                    measure("along_x", of_low, R"(, "direction": [1, 0, 0])"),
                {}, 48);
    const auto at_end = [&](const char* name) { return *scene.at<double>(name, 48); };
    EXPECT_EQ(*scene.at<double>("all", 1), 0) << "before the first step";
    EXPECT_NEAR(at_end("all"), 72 * g, 0.01 * 72 * g) << bodies;
    EXPECT_NEAR(at_end("low_all"), 64 * g, 0.01 * 64 * g) << bodies;
    EXPECT_NEAR(at_end("high_all"), 8 * g, 0.01 * 8 * g) << bodies;
    EXPECT_NEAR(at_end("by_ground"), 72 * g, 0.01 * 72 * g) << bodies;
    EXPECT_EQ(at_end("by_wall"), 0) << bodies;
    EXPECT_NEAR(at_end("by_high"), -8 * g, 0.01 * 8 * g) << bodies;
    EXPECT_NEAR(at_end("by_low"), 8 * g, 0.01 * 8 * g) << bodies;
    EXPECT_NEAR(at_end("along_x"), 0, 0.01 * 8 * g) << bodies;
}

TEST(ContactForce, OfWhatRestsIsTheWeightOfWhatItCarries)
{
    expect_weights(R"([{}, {}])");
    expect_weights(R"([{ "rigid": true }, { "rigid": true }])");
    expect_weights(R"([{}, { "rigid": true }])");
}

// What a measure of a box on the ground is refused with; empty: it is not.
std::string refused_with(const std::string& measured)
{
    const std::string scene = box("low", 0.4, 0, 0) + R"("ground": { "type": "Ground@1" },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "low.cubes",
                 "colliders": ["ground.collider"] } })" +
                              measured;
    const auto loaded = graph::load_text(R"({ "aspic": 1, "nodes": {)" + scene + "} }",
                                         "scene.json", nodes::registry());
    std::string out;
    for (const auto& problem : loaded.problems) out += problem.message;
    return out;
}

TEST(ContactForce, OfAColliderThatIsNotThereIsRefused)
{
    EXPECT_EQ(refused_with(measure("by", "", R"(, "collider": 1)")), "");
    const std::string why = refused_with(measure("by", "", R"(, "collider": 2)"));
    EXPECT_NE(why.find("expected 0 to 1, as many colliders as 'sim' has"), std::string::npos)
        << why;
}

TEST(ContactForce, OfOneColliderAndOneBodyAtOnceIsRefused)
{
    const std::string why = refused_with(
        measure("by", of_low + std::string(R"(, "against": "low.cubes")"), R"(, "collider": 1)"));
    EXPECT_NE(why.find("either one collider pushes or the body"), std::string::npos) << why;
}

// On a slope of 15 degrees: the push across it, and friction along it that holds.
TEST(ContactForce, HasFrictionInIt)
{
    const double slope = 15 * std::numbers::pi / 180;
    Scene scene(
        box("low", 0.4, 0, 0) +
            fmt::format(R"("ground": {{ "type": "Ground@1", "params": {{ "friction": 0.6 }} }},
                "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "low.cubes",
                    "colliders": ["ground.collider"] }},
                    "params": {{ "gravity": [{}, {}, 0] }} }})",
                        g * std::sin(slope), -g * std::cos(slope)) +
            measure("up", "") + measure("along", "", R"(, "direction": [1, 0, 0])"),
        {}, 48);
    EXPECT_NEAR(*scene.at<double>("up", 48), 64 * g * std::cos(slope), 0.01 * 64 * g);
    EXPECT_NEAR(*scene.at<double>("along", 48), -64 * g * std::sin(slope), 0.01 * 64 * g);
}

// Colliders move evenly within a frame, so that all of what they speed up is in its first step.
// 8 kg on a box that rises with 4 m/s^2 press it by 8 (9.81 + 4) N, however many steps that takes.
TEST(ContactForce, OfWhatSpeedsUpIsTheMeanOfTheFrame)
{
    for (const char* const rigid : {"true", "false"}) {
        for (const int substeps : {1, 2, 8}) {
            Scene scene(box("high", 0.2, 0, 0) +
                        fmt::format(R"("lift": {{ "type": "Collider@1", "params": {{ "kind": "box",
                            "box": {{ "size": [1, 0.2, 1] }},
                            "translate": [0, "=-0.1 + 2 * time^2", 0] }} }},
                        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": ["high.cubes"],
                            "surface": ["high_moved.mesh"], "colliders": ["lift.collider"] }},
                            "params": {{ "bodies": [{{ "rigid": {} }}],
                                         "step": {{ "substeps": {} }} }} }})",
                                    rigid, substeps) +
                        measure("up", ""));
            EXPECT_NEAR(*scene.at<double>("up", 13), 8 * (g + 4), 1) << rigid << substeps;
        }
    }
}

// A box that hits the ground and leaves it: what it was pushed by changes its momentum, also in a
// frame at whose end it touches nothing.
TEST(ContactForce, OfAllTouchesInAFrameIsWhatChangesMomentum)
{
    Scene scene(
        R"("mesh": { "type": "Primitive@1", "params": { "shape": "box", "centre": [0, 0.15, 0],
               "box": { "size": [0.2, 0.2, 0.2] } } },
           "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "mesh.mesh" }, "params": {
               "method": "solid", "size": 0.1, "align": "origin",
               "matter": { "density": 1000, "young": 1e5, "stiffness_damping": 0 } } },
           "ground": { "type": "Ground@1" },
           "sim": { "type": "Simulate@3", "inputs": { "cubes": ["cubes.cubes"],
               "surface": ["mesh.mesh"], "colliders": ["ground.collider"] },
               "params": { "initial_velocity": [0, -2, 0], "step": { "substeps": 16 } } },
           "p": { "type": "Measure@1", "inputs": { "state": "sim.state", "cubes": "cubes.cubes" },
               "params": { "what": "momentum", "direction": [0, 1, 0] } },
           "deep": { "type": "Measure@1", "inputs": { "state": "sim.state" },
               "params": { "what": "contact_depth" } })" +
        measure("up", ""));
    bool left = false;
    for (int frame = 2; frame < 8; ++frame) {
        const double gained = *scene.at<double>("p", frame) - *scene.at<double>("p", frame - 1);
        const double pushed = *scene.at<double>("up", frame);
        EXPECT_NEAR(pushed, 24 * gained + 8 * g, 1) << frame;
        left |= pushed > 100 && *scene.at<double>("deep", frame) == 0;
    }
    EXPECT_TRUE(left);
}

}  // namespace
