// Errors and warnings of Plane, Patch and Simulate about wrong links and parameters.

#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/primitive.hpp"
#include "render/png.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;

std::string refusal(NodeRun& node)
{
    try {
        node.run();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "nothing was refused";
}

bool has(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST(PlaneNode, RefusesAPictureWithoutInk)
{
    const auto path = std::filesystem::temp_directory_path() /
                      ("aspic_no_ink_" + std::to_string(::getpid()) + ".png");
    render::write_png(path, {4, 2, std::vector<std::uint8_t>(4 * 4 * 2, 255)});
    NodeRun plane("Plane");
    plane.param("outline").is = std::string("image");
    plane.param("image.path").is = path.string();
    const std::string said = refusal(plane);
    for (const char* part : {"aspic_no_ink_", "0.5 dark", "image.ink", "image.threshold"}) {
        EXPECT_TRUE(has(said, part)) << said;
    }
    plane.param("image.ink").is = std::string("bright");
    EXPECT_EQ(refusal(plane), "nothing was refused");
    std::filesystem::remove(path);
}

TEST(PatchNode, RefusesASurfaceOfAnotherNumberOfVertices)
{
    NodeRun plane("Plane");
    plane.param("size").is = 0.25;
    const auto made = plane.outputs();
    physics::State state;
    state.x = geometry::corner_positions(*made[0].as<geometry::Cubes>());
    NodeRun patch("Patch");
    patch.inputs["rest"] = {graph::Value::of(geometry::grid(1, 1, 2, 2))};
    patch.inputs["mesh"] = patch.inputs["rest"];
    patch.inputs["cubes"] = {made[0]};
    patch.inputs["carried"] = {made[1]};
    patch.inputs["state"] = {graph::Value::of(state)};
    EXPECT_EQ(refusal(patch), "nothing was refused");
    patch.inputs["mesh"] = {graph::Value::of(geometry::grid(1, 1, 3, 3))};
    EXPECT_TRUE(has(refusal(patch), "has 16 vertices, expected 9")) << refusal(patch);
    EXPECT_TRUE(has(refusal(patch), "torn = hide")) << refusal(patch);
    patch.inputs["mesh"] = patch.inputs["rest"];
    state.x.pop_back();
    patch.inputs["state"] = {graph::Value::of(state)};
    EXPECT_TRUE(has(refusal(patch), "Simulate that moves these cells")) << refusal(patch);
}

// Cubes of 0.1 m that fill 0.4 m along x from the origin.
TEST(SimulateNode, WarnsOfAPointForceOutOfReach)
{
    const geometry::Cubes cubes =
        geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, 0.1);
    const auto warnings = [&](const Vec3& position, double radius, const Vec3& push) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {graph::Value::of(cubes)};
        physics::Force force;
        force.kind = physics::Force::Kind::point;
        force.position = position;
        force.radius = radius;
        force.force = push;
        simulate.inputs["forces"] = {graph::Value::of(force)};
        simulate.param("gravity").is = std::array<double, 3>{0, 0, 0};
        simulate.previous = simulate.outputs(1);
        simulate.outputs(2);
        return simulate.warnings;
    };
    const Vec3 push(0, 0.01, 0);
    EXPECT_TRUE(warnings({0.2, 0.05, 0.05}, 0.1, push).empty());
    EXPECT_TRUE(warnings({0.2, 0.05, 0.05}, 0, push).empty());
    EXPECT_TRUE(warnings({0.5, 0.05, 0.05}, 0.2, push).empty());
    EXPECT_TRUE(warnings({9, 0, 0}, 9, push).empty());
    EXPECT_TRUE(warnings({9, 0, 0}, 0.1, {0, 0, 0}).empty()) << "it does nothing";
    const auto far = warnings({9, 0, 0}, 0.1, push);
    ASSERT_EQ(far.size(), 1u);
    EXPECT_TRUE(has(far[0], "Point force 1 of 1 has no material")) << far[0];
}

TEST(SimulateNode, WarnsOfParametersAndForcesWithoutEffect)
{
    const auto warnings = [](const geometry::Cubes& cubes, const char* motion, double bend,
                             const Vec3& push) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {graph::Value::of(cubes)};
        simulate.param("method").is = std::string("lattice");
        simulate.param("lattice.plane").is = std::string(motion);
        simulate.param("lattice.stiffness").is = std::string("rate");
        simulate.param("lattice.bend").is = bend;
        physics::Force force;
        force.kind = physics::Force::Kind::point;
        force.radius = 9;
        force.force = push;
        simulate.inputs["forces"] = {graph::Value::of(force)};
        simulate.previous = simulate.outputs(1);
        simulate.outputs(2);
        return simulate.warnings;
    };
    const geometry::Cubes solid = geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}}, 0.1);
    const geometry::Cubes plane =  // across y
        geometry::plane_cubes(geometry::rectangle_cells(4, 4), {1, 0.1, {0, 0, 0}}, 0.01);
    EXPECT_TRUE(warnings(solid, "space", 1, {0, 1, 0}).empty());
    EXPECT_TRUE(warnings(plane, "space", 0.5, {0, 1, 0}).empty());
    EXPECT_TRUE(warnings(plane, "in_plane", 1, {1, 1, 0}).empty());
    const auto bent = warnings(solid, "space", 0.5, {0, 1, 0});
    ASSERT_EQ(bent.size(), 1u);
    EXPECT_TRUE(has(bent[0], "lattice.bend has no effect")) << bent[0];
    const auto across = warnings(plane, "in_plane", 1, {0, 1, 0});
    ASSERT_EQ(across.size(), 1u);
    EXPECT_TRUE(has(across[0], "point force 1 of 1 has no effect")) << across[0];
}
