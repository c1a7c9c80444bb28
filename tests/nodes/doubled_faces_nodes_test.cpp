// Meshes whose faces are there twice, front and back or twice the same: nodes count each face once.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;

enum class Second { back, copy };

TriMesh with_second(const TriMesh& mesh, Second second)
{
    geometry::MeshTopology topology;
    topology.triangles = mesh.triangles();
    for (geometry::Triangle t : mesh.triangles()) {
        if (second == Second::back) std::swap(t[0], t[1]);
        topology.triangles.push_back(t);
    }
    TriMesh out;
    out.positions = mesh.positions;
    out.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return out;
}

void expect_doubled_told(const NodeRun& node, bool told, const std::string& count)
{
    std::size_t times = 0;
    for (const auto& text : node.warnings) {
        if (text.find("so that each face counts once") == std::string::npos) continue;
        ++times;
        EXPECT_NE(text.find(count), std::string::npos) << text;
    }
    EXPECT_EQ(times, told ? 1u : 0u) << count;
}

// kg, of faces 0.002 m thick at 1000 kg/m^3.
double thin_mass(const TriMesh& mesh, const std::string& method, const std::string& pieces,
                 const std::string& count)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("method").is = method;
    node.param("pieces").is = pieces;
    node.param("size").is = 0.1;
    node.param("thickness").is = 0.002;
    const auto cubes = node.run().as<geometry::Cubes>();
    expect_doubled_told(node, !count.empty(), count);
    return geometry::total_mass(*cubes);
}

TEST(DoubledFacesOfNodes, CubesOfASurfaceHoldEachFaceOnce)
{
    const TriMesh box = geometry::box({1, 1, 1}, {2, 2, 2});
    for (const Second second : {Second::back, Second::copy}) {
        for (const std::string pieces : {"merge", "apart", "each"}) {
            EXPECT_NEAR(thin_mass(box, "surface", pieces, ""), 12, 1e-9);
            EXPECT_NEAR(
                thin_mass(with_second(box, second), "surface", pieces, "48 of 96 triangles"), 12,
                1e-9)
                << pieces;
        }
    }
}

TEST(DoubledFacesOfNodes, ASheetAmongSolidsHasItsThicknessOnce)
{
    const TriMesh sheet = geometry::grid(1, 1, 4, 4);
    for (const std::string pieces : {"merge", "apart"}) {
        const double mass = thin_mass(sheet, "solid", pieces, "");
        EXPECT_NEAR(
            thin_mass(with_second(sheet, Second::back), "solid", pieces, "32 of 64 triangles"),
            mass, 1e-9)
            << pieces;
    }
}

// A solid has no use for the number of its faces.
TEST(DoubledFacesOfNodes, ASolidIsNotTold)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {
        graph::Value::of(with_second(geometry::box({1, 1, 1}, {1, 1, 1}), Second::back))};
    node.param("method").is = std::string("solid");
    node.param("size").is = 0.25;
    EXPECT_NEAR(geometry::total_mass(*node.run().as<geometry::Cubes>()), 1000, 1e-6);
    EXPECT_TRUE(node.warnings.empty());
}

TEST(DoubledFacesOfNodes, SamplesLieOnEachFaceOnce)
{
    const TriMesh one = geometry::box({1, 1, 1}, {2, 2, 2});
    const auto sampled = [](const TriMesh& mesh, const std::string& pattern,
                            const std::string& count) {
        NodeRun node("Sample");
        node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
        node.param("pattern").is = pattern;
        node.param("spacing").is = 0.1;
        node.param("mass").is = std::string("surface_density");
        node.param("surface_density").is = 3.0;
        const auto points = node.run().as<geometry::Samples>();
        expect_doubled_told(node, !count.empty(), count);
        return points;
    };
    for (const std::string pattern : {"even", "blue"}) {
        const auto plain = sampled(one, pattern, "");
        for (const Second second : {Second::back, Second::copy}) {
            const auto points = sampled(with_second(one, second), pattern, "48 of 96 triangles");
            EXPECT_EQ(points->positions, plain->positions) << pattern;
            EXPECT_EQ(points->mass, plain->mass) << pattern;
            EXPECT_EQ(points->triangle, plain->triangle) << pattern;
        }
    }
}

// As samples of the whole mesh name its triangles: those after a face that is left out too.
TEST(DoubledFacesOfNodes, SamplesNameTheTrianglesOfTheWholeMesh)
{
    TriMesh mesh = geometry::box({1, 1, 1}, {1, 1, 1});
    geometry::MeshTopology topology;
    topology.triangles = mesh.triangles();
    topology.triangles.insert(topology.triangles.begin(), mesh.triangles()[0]);
    mesh.topology = std::make_shared<const geometry::MeshTopology>(topology);
    NodeRun node("Sample");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("count").is = std::int64_t{1000};
    const auto points = node.run().as<geometry::Samples>();
    ASSERT_EQ(points->triangle.size(), 1000u);
    for (std::size_t i = 0; i < 1000; ++i) {
        EXPECT_NE(points->triangle[i], 1u);
        const auto& [a, b, c] = mesh.triangles()[points->triangle[i]];
        const geometry::Vec3f &p = mesh.positions[a], &q = mesh.positions[b],
                              &r = mesh.positions[c];
        const geometry::Vec3f normal = (q - p).cross(r - p).normalized();
        EXPECT_NEAR(normal.dot(points->positions[i] - p), 0, 1e-6f);
    }
}

TEST(DoubledFacesOfNodes, ASheetOfQuadsAndTheirBacksIsOne)
{
    // A quad, and its back cut along the other diagonal.
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = {{0, 1, 2}, {0, 2, 3}, {3, 2, 1}, {3, 1, 0}};
    mesh.topology = topology;
    NodeRun node("Sheet");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("thickness").is = 0.002;
    const auto cubes = node.run().as<geometry::Cubes>();
    EXPECT_EQ(cubes->count(), 2u);
    EXPECT_NEAR(geometry::total_mass(*cubes), 2, 1e-9);
    EXPECT_EQ(node.warnings.size(), 1u);
    expect_doubled_told(node, true, "2 of 4 triangles");
}

// One block falls upon another, whose surface is at half the height of its upper cubes.
TEST(DoubledFacesOfNodes, BodiesTouchASurfaceWithTwoSidesWhereItIs)
{
    const auto block = [](const geometry::Vec3& origin) {
        geometry::Cubes cubes = fixtures::box(2, 2, 2, 0.1, {.young = 1e6});
        cubes.origin = origin;
        return graph::Value::of(std::move(cubes));
    };
    const auto surface = [](double height, double bottom) {
        TriMesh mesh = geometry::box({0.2, height, 0.2}, {2, 2, 2});
        for (auto& p : mesh.positions) p += geometry::Vec3f(0.1f, float(bottom + height / 2), 0.1f);
        return mesh;
    };
    const TriMesh low = surface(0.15, 0), high = surface(0.2, 0.16);
    const auto fallen = [&](const TriMesh& lower) {
        NodeRun ground("Ground");
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {block({0, 0, 0}), block({0, 0.16, 0})};
        simulate.inputs["surface"] = {graph::Value::of(TriMesh(lower)),
                                      graph::Value::of(TriMesh(high))};
        simulate.inputs["colliders"] = {ground.run()};
        graph::Value state = simulate.run();
        for (int frame = 2; frame < 6; ++frame) {
            simulate.previous = {state};
            state = simulate.run(frame);
        }
        return state.as<physics::State>()->x;
    };
    EXPECT_EQ(fallen(with_second(low, Second::back)), fallen(low));
}

}  // namespace
