// Figures led by keyframes.

#include "physics/layered_bodies/layered.hpp"
#include "tests/nodes/scene.hpp"

#include <cmath>

namespace {

// Two limbs along x, the second from x = 0.45 on; `end` is where it ends.
std::string arm(const std::string& end, const std::string& degrees,
                const std::string& base = "rigid")
{
    return R"("skeletons": { "type": "Skeletons@1", "params": { "blend": "largest_group",
            "links": [ { "a": 0, "b": 1 } ],
            "skeletons": [
            { "kind": "segment", "frame": 0, "points": [ { "at": [0, 0, 0] }, { "at": [0.4, 0, 0] } ],
              "contribution": { "thickness": 0.1, "stiffness": 10, "radius": 0.22 } },
            { "kind": "segment", "frame": 1, "points": [ { "at": [0.5, 0, 0] }, { "at": )" +
           end + R"( } ],
              "contribution": { "thickness": 0.1, "stiffness": 10, "radius": 0.22 } } ] } },
        "layer": { "type": "ImplicitLayer@3", "inputs": { "layer": "skeletons.layer" },
            "params": { "base": ")" +
           base + R"(", "seed_spacing": 0.05 } },
        "figure": { "type": "Figure@1", "inputs": { "part": "layer.part" }, "params": {
            "hinges": [ { "a": 0, "b": 1, "point": [0.45, 0, 0], "axis": [0, 0, 1] } ] } },
        "pose": { "type": "Pose@1", "inputs": { "part": "figure.part" }, "params": {
            "hinges": [ { "hinge": 0, "degrees": )" +
           degrees + R"( } ] } },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["pose.part"] } })";
}

}  // namespace

TEST(PoseNodes, KeyedAnglesTurnTheLimbWithASpin)
{
    const double slope = 5, radian = std::acos(-1.0) / 180;  // degrees a frame
    fixtures::Scene scene(
        arm("[0.9, 0, 0]", R"({ "keys": [ [1, 0], [19, 90] ], "interpolation": "linear" })"));
    const auto at = scene.at<physics::LayeredScene>("bodies", 7);
    const auto& state = at->states[0];
    const double angle = 6 * slope * radian;
    const geometry::Vec3 elbow(0.45, 0, 0);
    const geometry::Vec3 arm = at->parts[0].body->base.frames[1].translation() - elbow;
    const Eigen::AngleAxisd turn(angle, geometry::Vec3::UnitZ());
    EXPECT_LT((state.position[1] - elbow - turn * arm).norm(), 1e-9);
    EXPECT_NEAR(state.spin[1].z(), slope * radian * 24, 1e-6);
    EXPECT_NEAR(state.spin[0].norm(), 0, 1e-9);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(PoseNodes, AStillFigureTurnsAsARigidOne)
{
    const std::string keys = R"({ "keys": [ [1, 0], [19, 90] ], "interpolation": "linear" })";
    fixtures::Scene rigid(arm("[0.9, 0, 0]", keys)), still(arm("[0.9, 0, 0]", keys, "still"));
    const auto a = rigid.at<physics::LayeredScene>("bodies", 7);
    const auto b = still.at<physics::LayeredScene>("bodies", 7);
    EXPECT_LT((a->states[0].spin[1] - b->states[0].spin[1]).norm(), 1e-9);
    const geometry::Transform& drawn = a->parts[0].body->base.frames[1];
    EXPECT_LT((b->parts[0].frames[1] * drawn.translation() - a->states[0].position[1]).norm(),
              1e-9);
}

TEST(PoseNodes, KeyedLengthsGoOn)
{
    fixtures::Scene scene(arm(R"({ "keys": [ [1, [0.9, 0, 0]], [9, [1.1, 0, 0]] ] })", "20"));
    EXPECT_EQ(scene.failure_at<physics::LayeredScene>("bodies", 9), "");
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
}

TEST(PoseNodes, AHingeThatIsNotThereIsRefused)
{
    std::string nodes = arm("[0.9, 0, 0]", "0");
    nodes.replace(nodes.find(R"("hinge": 0)"), 10, R"("hinge": 3)");
    fixtures::Scene scene(nodes);
    EXPECT_NE(scene.failure_at<physics::LayeredScene>("bodies").find("names hinge 3"),
              std::string::npos);
}

// A pin would hold the lower limb as drawn in the first frame, and Bullet would refuse it.
TEST(PoseNodes, PinsOfALedFigureAreLeftOutWithAWarning)
{
    std::string nodes = arm("[0.9, 0, 0]", "90");
    const std::string spacing = R"("seed_spacing": 0.05)", last = R"("parts": ["pose.part"] })";
    nodes.replace(nodes.find(spacing), spacing.size(), spacing + R"(, "pins": [ { "frame": 1 } ])");
    nodes.replace(nodes.find(last), last.size(),
                  last + R"(, "params": { "rigid_bodies": "bullet" })");
    nodes += R"(, "reach": { "type": "Reach@1", "inputs": { "part": "figure.part" } })";
    fixtures::Scene scene(nodes);
    const auto at = scene.at<physics::LayeredScene>("bodies", 1);
    const geometry::Vec3 elbow(0.45, 0, 0);
    const geometry::Vec3 arm = at->parts[0].body->base.frames[1].translation() - elbow;
    EXPECT_LT(
        (at->states[0].position[1] - elbow - geometry::Vec3(-arm.y(), arm.x(), arm.z())).norm(),
        1e-9);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("pins of the body have no effect, because Pose leads"),
              std::string::npos);
    EXPECT_TRUE(scene.at<physics::LayeredPart>("reach", 1)->held.empty());
    EXPECT_EQ(scene.warnings.size(), 2u);
}
