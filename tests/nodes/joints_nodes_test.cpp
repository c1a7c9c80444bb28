// Figure's joints through a graph.

#include "physics/layered_bodies/layered.hpp"
#include "tests/nodes/scene.hpp"

#include <cmath>

namespace {

std::string ball_on(const std::string& joint)
{
    return R"("skeletons": { "type": "Skeletons@1", "params": { "skeletons": [
            { "position": [0.3, 1, 0], "contribution":
                { "thickness": 0.1, "stiffness": 10, "radius": 0.25 } } ] } },
        "layer": { "type": "ImplicitLayer@3", "inputs": { "layer": "skeletons.layer" },
            "params": { "base": "rigid", "seed_spacing": 0.08 } },
        "figure": { "type": "Figure@1", "inputs": { "part": "layer.part" }, "params": {
            "joints": [ { "a": -1, "b": 0, )" +
           joint + R"( } ] } },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["figure.part"] },
            "params": { "substeps": 20 } })";
}

}  // namespace

TEST(JointsNodes, ABallOnTheWorldSwingsAboutItsPoint)
{
    fixtures::Scene scene(ball_on(R"("kind": "ball", "point": [0, 1, 0])"));
    const auto at = scene.at<physics::LayeredScene>("bodies", 8);
    const geometry::Vec3 arm = at->states[0].position[0] - geometry::Vec3(0, 1, 0);
    EXPECT_NEAR(arm.norm(), 0.3, 1e-3);
    EXPECT_LT(arm.y(), -0.1);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(JointsNodes, ASliderGoesToItsLimit)
{
    fixtures::Scene scene(
        ball_on(R"("kind": "slider", "point": [0.3, 1, 0], "axis": [0, -1, 0], "highest": 0.2)"));
    const auto at = scene.at<physics::LayeredScene>("bodies", 24);
    EXPECT_NEAR(at->states[0].position[0].y(), 0.8, 2e-3);
    EXPECT_NEAR(at->states[0].position[0].x(), 0.3, 1e-6);
}

// m v' = m g - d v: with m = 1 kg and d = 9.81 N s/m it comes to fall at 1 m/s.
TEST(JointsNodes, ASliderFallsAsFastAsItsDampingLetsIt)
{
    std::string nodes =
        ball_on(R"("kind": "slider", "point": [0.3, 1, 0], "axis": [0, -1, 0], "damping": 9.81)");
    const std::string spacing = R"("seed_spacing": 0.08)";
    nodes.replace(nodes.find(spacing), spacing.size(), spacing + R"(, "mass": 1)");
    fixtures::Scene scene(nodes);
    const auto at = scene.at<physics::LayeredScene>("bodies", 24);
    EXPECT_NEAR(at->states[0].velocity[0].y(), -1, 2e-3);
}

TEST(JointsNodes, LimitsTheWrongWayRoundAreRefused)
{
    fixtures::Scene scene(ball_on(R"("kind": "slider", "lowest": 1, "highest": 0)"));
    EXPECT_NE(scene.failure_at<physics::LayeredScene>("bodies").find("at most highest"),
              std::string::npos);
}

TEST(JointsNodes, MassAndSpinAreWhatTheLayerSays)
{
    fixtures::Scene scene(R"("skeletons": { "type": "Skeletons@1", "params": { "skeletons": [
            { "position": [0.3, 1, 0], "contribution":
                { "thickness": 0.1, "stiffness": 10, "radius": 0.25 } } ] } },
        "layer": { "type": "ImplicitLayer@3", "inputs": { "layer": "skeletons.layer" },
            "params": { "mass": 3, "spin_degrees": [0, 90, 0], "seed_spacing": 0.03 } },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["layer.part"] } })");
    const auto at = scene.at<physics::LayeredScene>("bodies");
    const physics::Base& base = at->parts[0].body->base;
    EXPECT_NEAR(base.mass[0], 3, 1e-12);
    EXPECT_NEAR(base.inertia[0](1, 1), 0.4 * 3 * 0.01, 0.01 * 0.4 * 3 * 0.01);
    EXPECT_NEAR(at->states[0].spin[0].y(), std::acos(-1.0) / 2, 1e-12);
}
