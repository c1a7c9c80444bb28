// From a document to values on its wires, for the nodes that make cubes, carry meshes and vibrate:
// each with a number that is known beforehand.

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using fixtures::NodeRun;
using fixtures::Scene;
using geometry::Cubes;
using geometry::Samples;
using geometry::TriMesh;
using geometry::Vec3;

const std::string metre = R"("box": { "type": "Primitive@1", "params": { "shape": "box" } })";

TEST(GraphOfCubes, SampleSpreadsPointsOverAMeshAndThroughIt)
{
    Scene scene(metre + R"(,
        "even": { "type": "Sample@2", "inputs": { "mesh": "box.mesh" },
                  "params": { "count": 5000 } },
        "heavy": { "type": "Sample@2", "inputs": { "mesh": "box.mesh" },
                   "params": { "count": 5000, "mass": "total", "total_mass": 7, "pattern": "blue" } },
        "spaced": { "type": "Sample@2", "inputs": { "mesh": "box.mesh" },
                    "params": { "spacing": 0.1 } },
        "inside": { "type": "Sample@2", "inputs": { "mesh": "box.mesh" },
                    "params": { "where": "volume", "count": 2000 } })");
    const auto even = scene.at<Samples>("even");
    EXPECT_EQ(even->positions.size(), 5000u);
    for (const auto& p : even->positions) {
        EXPECT_NEAR(double(p.cwiseAbs().maxCoeff()), 0.5, 1e-6);
    }
    double mass = 0;
    for (const float m : scene.at<Samples>("heavy")->mass) mass += double(m);
    EXPECT_NEAR(mass, 7, 1e-4);
    EXPECT_EQ(scene.at<Samples>("spaced")->positions.size(), 600u);  // 6 m^2 by 0.01
    const auto inside = scene.at<Samples>("inside");
    mass = 0;
    for (std::size_t i = 0; i < inside->positions.size(); ++i) {
        EXPECT_LT(inside->positions[i].cwiseAbs().maxCoeff(), 0.5f);
        mass += double(inside->mass[i]);
    }
    EXPECT_NEAR(mass, 1000, 1);  // 1 m^3 of 1000 kg/m^3
}

TEST(GraphOfCubes, VoxelizeMethodsAgreeOnABox)
{
    // 4 x 4 x 4 cubes of 0.3 m around a box of 1 m; the middle 2 x 2 x 2 hold no face.
    Scene scene(metre + R"(,
        "points": { "type": "Sample@2", "inputs": { "mesh": "box.mesh" } },
        "samples": { "type": "Voxelize@1",
                     "inputs": { "points": "points.points", "mesh": "box.mesh" },
                     "params": { "size": 0.3 } },
        "surface": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" },
                     "params": { "method": "surface", "size": 0.3 } },
        "solid": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" },
                   "params": { "method": "solid", "size": 0.3 } },
        "light": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" },
                   "params": { "method": "solid", "size": 0.3, "total_mass": 5 } },
        "many": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" },
                  "params": { "method": "solid", "size": 0.01, "max_cubes": 1000 } },
        "large": { "type": "Transform@1", "inputs": { "mesh": "box.mesh" },
                   "params": { "scale": [100, 100, 100] } },
        "centimetres": { "type": "Voxelize@1", "inputs": { "mesh": "large.mesh" },
                         "params": { "method": "solid", "size": 1, "max_cubes": 1000 } })");
    const auto samples = scene.at<Cubes>("samples"), surface = scene.at<Cubes>("surface"),
               solid = scene.at<Cubes>("solid");
    EXPECT_EQ(surface->count(), 56u);
    EXPECT_EQ(solid->count(), 64u);
    EXPECT_EQ(samples->cell, surface->cell);
    // Full of their matter, all by default: the two ways to a shell agree in everything.
    EXPECT_NEAR(total_mass(*samples), 56 * 27, 1e-6);
    EXPECT_NEAR(total_mass(*surface), 56 * 27, 1e-6);
    EXPECT_NEAR(total_mass(*solid), 1000, 1e-2);  // by what is inside: 1 m^3
    EXPECT_NEAR(total_mass(*scene.at<Cubes>("light")), 5, 1e-9);
    try {
        scene.at<Cubes>("many");
        FAIL();
    } catch (const std::exception& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("would fit"), std::string::npos) << what;
        EXPECT_NE(what.find("the model, 1 m long, exceeds"), std::string::npos) << what;
        EXPECT_EQ(what.find("unit"), std::string::npos) << what;
    }
    try {
        scene.at<Cubes>("centimetres");
        FAIL();
    } catch (const std::exception& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("100 m long"), std::string::npos) << what;
        EXPECT_NE(what.find("set `unit` of ReadMesh"), std::string::npos) << what;
    }
}

// A ball every third face of which is turned over.
TEST(GraphOfCubes, FacesThatLookInAreTurnedOut)
{
    const auto ball = geometry::icosphere(1, 3);
    auto topology = std::make_shared<geometry::MeshTopology>(*ball.topology);
    for (std::size_t t = 0; t < topology->triangles.size(); t += 3) {
        std::swap(topology->triangles[t][0], topology->triangles[t][1]);
    }
    auto broken = ball;
    broken.topology = topology;
    const auto mass = [&](const TriMesh& mesh, const std::string& inside) {
        NodeRun node("Voxelize");
        node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
        node.param("method").is = std::string("solid");
        node.param("inside").is = inside;
        const auto out = node.run();
        EXPECT_TRUE(node.warnings.empty()) << node.warnings[0];
        return total_mass(*out.as<Cubes>());
    };
    const double whole = mass(ball, "winding");
    EXPECT_EQ(mass(broken, "winding"), whole);
    EXPECT_EQ(mass(broken, "parity"), whole);
}

// A prism over a pentagon whose caps are turned inside out, and hang together with fins at their
// edges: which way they look is not known, and almost nothing is inside by winding.
TriMesh finned_prism()
{
    TriMesh prism;
    auto topology = std::make_shared<geometry::MeshTopology>();
    auto& faces = topology->triangles;
    for (std::uint32_t i = 0; i < 5; ++i) {
        const double angle = 2 * std::numbers::pi * i / 5;
        for (const float z : {-1.0f, 1.0f}) {
            prism.positions.emplace_back(float(std::cos(angle)), float(std::sin(angle)), z);
        }
        const std::uint32_t low = 2 * i, next = 2 * ((i + 1) % 5);
        faces.push_back({low, next, next + 1});
        faces.push_back({low, next + 1, low + 1});
    }
    for (std::uint32_t i = 1; i < 4; ++i) {
        faces.push_back({0, 2 * i, 2 * i + 2});
        faces.push_back({1, 2 * i + 3, 2 * i + 1});
    }
    for (std::uint32_t i = 0; i < 5; ++i) {
        const std::uint32_t low = 2 * i, next = 2 * ((i + 1) % 5);
        for (std::uint32_t end = 0; end < 2; ++end) {
            faces.push_back({low + end, next + end, std::uint32_t(prism.positions.size())});
            prism.positions.push_back(
                0.5f * (prism.positions[low + end] + prism.positions[next + end]) +
                geometry::Vec3f(0, 0, end == 0 ? -0.01f : 0.01f));
        }
    }
    prism.topology = topology;
    return prism;
}

TEST(GraphOfCubes, WarnsOfFacesThatCouldNotBeTurnedOut)
{
    const auto warnings = [&](const std::string& inside) {
        NodeRun node("Voxelize");
        node.inputs["mesh"] = {graph::Value::of(finned_prism())};
        node.param("method").is = std::string("solid");
        node.param("inside").is = inside;
        node.run();
        std::string all;
        for (const auto& text : node.warnings) all += text + "\n";
        return all;
    };
    EXPECT_EQ(warnings("parity").find("set inside"), std::string::npos);
    EXPECT_NE(warnings("winding").find("more than two faces meet at 10 edges"), std::string::npos)
        << warnings("winding");
}

// Samples as near as that volume asks are not sought, however they are asked for.
TEST(GraphOfCubes, SampleTellsAtOnceOfAMeshWithoutAnInside)
{
    for (const double spacing : {0.0, 0.05}) {
        NodeRun sample("Sample");
        sample.inputs["mesh"] = {graph::Value::of(finned_prism())};
        sample.param("where").is = std::string("volume");
        sample.param("spacing").is = spacing;
        try {
            sample.run();
            FAIL() << "was sampled";
        } catch (const std::invalid_argument& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("more than two faces meet at 10 edges"), std::string::npos) << text;
            EXPECT_NE(text.find("set inside = parity"), std::string::npos) << text;
        }
        sample.param("inside").is = std::string("parity");
        EXPECT_NO_THROW(sample.run());
    }
}

TEST(GraphOfCubes, SkeletonsTellOfTooManyPoints)
{
    const auto told = [](std::size_t count) {
        Samples points;
        points.positions.assign(count, geometry::Vec3f(0, 0, 0));
        for (std::size_t i = 0; i < count; ++i) points.positions[i].x() = float(i);
        NodeRun node("Skeletons");
        node.inputs["points"] = {graph::Value::of(points)};
        node.run();
        return node.warnings;
    };
    EXPECT_TRUE(told(5000).empty());
    ASSERT_EQ(told(5001).size(), 1u);
    EXPECT_NE(told(5001)[0].find("5001 points"), std::string::npos);
    EXPECT_NE(told(5001)[0].find("Set count = 1000 in Sample"), std::string::npos);
}

TEST(GraphOfCubes, ConnectedComponentKeepsTheChosenComponent)
{
    Scene scene(metre + R"(,
        "other": { "type": "Primitive@1", "params": { "shape": "box",
                   "box": { "size": [0.5, 0.5, 0.5] }, "centre": [3, 0, 0] } },
        "both": { "type": "Merge@1", "inputs": { "meshes": ["box.mesh", "other.mesh"] } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "both.mesh" },
                   "params": { "method": "solid", "size": 0.19 } },
        "largest": { "type": "ConnectedComponent@1", "inputs": { "cubes": "cubes.cubes" } },
        "right": { "type": "ConnectedComponent@1", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "keep": "point", "point": [3, 0, 0] } },
        "all": { "type": "ConnectedComponent@1", "inputs": { "cubes": "cubes.cubes" },
                 "params": { "keep": "all" } },
        "pieces": { "type": "Measure@1", "inputs": { "cubes": "all.cubes" },
                    "params": { "what": "components" } })");
    const auto all = scene.at<Cubes>("all"), largest = scene.at<Cubes>("largest"),
               right = scene.at<Cubes>("right");
    EXPECT_EQ(*scene.at<double>("pieces"), 2);
    EXPECT_EQ(largest->count() + right->count(), all->count());
    EXPECT_GT(largest->count(), right->count());
    for (std::size_t c = 0; c < right->count(); ++c) {
        const Vec3 middle =
            right->origin + right->size * (right->cell[c].cast<double>() + Vec3::Constant(0.5));
        EXPECT_LT((middle - Vec3(3, 0, 0)).cwiseAbs().maxCoeff(), 0.4);
    }
    ASSERT_EQ(scene.warnings.size(), 2u);
    EXPECT_EQ(scene.warnings[0].rfind("dropped 1 of 2 components", 0), 0u) << scene.warnings[0];
}

TEST(GraphOfCubes, EmbedMovesAMeshWithItsCubes)
{
    // Thrown without gravity, each frame takes 1/24 s: 1 m/s is 2/24 m at frame 3.
    Scene scene(metre + R"(,
        "ball": { "type": "Primitive@1", "params": { "shape": "sphere",
                  "sphere": { "radius": 0.4, "subdivisions": 2 } } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" },
                   "params": { "method": "solid", "size": 0.3 } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" },
                 "params": { "gravity": [0, 0, 0], "initial_velocity": [1, 0, 0] } },
        "shape": { "type": "Embed@3", "inputs": { "mesh": "ball.mesh", "cubes": "cubes.cubes",
                   "state": "sim.state" } },
        "far": { "type": "Transform@1", "inputs": { "mesh": "ball.mesh" },
                 "params": { "translate": [0, 2, 0] } },
        "stray": { "type": "Embed@3", "inputs": { "mesh": "far.mesh", "cubes": "cubes.cubes",
                   "state": "sim.state" } })");
    const auto rest = scene.at<TriMesh>("ball"), moved = scene.at<TriMesh>("shape", 3);
    ASSERT_EQ(moved->positions.size(), rest->positions.size());
    EXPECT_EQ(moved->topology, rest->topology);
    for (std::size_t v = 0; v < rest->positions.size(); ++v) {
        const geometry::Vec3f way = moved->positions[v] - rest->positions[v];
        EXPECT_NEAR(double((way - geometry::Vec3f(2 / 24.0f, 0, 0)).norm()), 0, 1e-6);
    }
    std::vector<std::string> names;
    for (const auto& a : moved->attributes) names.push_back(a.name + " " + a.unit);
    EXPECT_EQ(names, (std::vector<std::string>{"displacement m", "speed m/s", "stress Pa"}));
    EXPECT_NEAR(double(moved->attributes[1].values[0]), 1, 1e-6);
    EXPECT_TRUE(scene.warnings.empty());
    // What lies in no cube goes along all the same, and is said.
    EXPECT_NEAR(double(scene.at<TriMesh>("stray", 3)->positions[0].x() -
                       scene.at<TriMesh>("far")->positions[0].x()),
                2 / 24.0, 1e-6);
    ASSERT_FALSE(scene.warnings.empty());
    EXPECT_NE(scene.warnings[0].find("vertices lie in no cube"), std::string::npos);
}

TEST(GraphOfCubes, EmbedCutsHidesOrStretchesTornFaces)
{
    // A row of four cubes, torn in the third; its right end is carried off by a metre.
    const geometry::Cubes cubes =
        geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, 0.5);
    physics::State state;
    state.x = geometry::corner_positions(cubes);
    for (std::uint32_t k = 0; k < state.x.size(); ++k) {
        if (cubes.corner[k].x() == 2) state.broken.push_back(3 * k);
        if (cubes.corner[k].x() > 2) state.x[k].x() += 1;
    }
    const TriMesh mesh = geometry::box({1.9, 0.2, 0.2}, {8, 1, 1});
    const auto embedded = [&](const char* torn, const char* inside = "material") {
        NodeRun node("Embed");
        TriMesh moved = mesh;
        for (auto& p : moved.positions) p += geometry::Vec3f(1, 0.25f, 0.25f);
        node.inputs["mesh"] = {graph::Value::of(moved)};
        node.inputs["cubes"] = {graph::Value::of(cubes)};
        node.inputs["state"] = {graph::Value::of(state)};
        node.param("torn").is = std::string(torn);
        node.param("inside").is = std::string(inside);
        return *node.run().as<TriMesh>();
    };
    const double whole = geometry::surface_area(mesh);
    const TriMesh cut = embedded("cut"), hidden = embedded("hide"), drawn = embedded("stretch");
    EXPECT_NEAR(geometry::surface_area(cut), whole + 2 * 0.2 * 0.2, 1e-4);
    EXPECT_NEAR(geometry::enclosed_volume(cut), geometry::enclosed_volume(mesh), 1e-6);
    EXPECT_NEAR(geometry::surface_area(embedded("cut", "open")), whole, 1e-4);
    EXPECT_EQ(cut.topology->materials.back().name, "inside");
    EXPECT_EQ(embedded("cut", "surface").topology->materials, mesh.topology->materials);
    EXPECT_GT(cut.positions.size(), mesh.positions.size());
    EXPECT_EQ(cut.attributes[0].values.size(), cut.positions.size());
    EXPECT_LT(geometry::surface_area(hidden), whole - 0.25);
    EXPECT_EQ(hidden.positions.size(), mesh.positions.size());
    EXPECT_NEAR(geometry::surface_area(drawn), whole + 4 * 0.2, 1e-4);
    EXPECT_EQ(drawn.topology->triangles, mesh.topology->triangles);
}

// A cantilever of 1 m by 0.1 m by 0.1 m, E = 1e7, rho = 1000, and what follows.
std::string cantilever(const std::string& nodes)
{
    return R"("beam": { "type": "Primitive@1", "params": { "shape": "beam",
                  "beam": { "length": 1, "height": 0.1, "width": 0.1, "divisions": 20 },
                  "centre": [0.5, 0, 0] } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "beam.mesh" },
                   "params": { "method": "solid", "size": 0.1,
                               "matter": { "young": 1e7, "poisson": 0.3 } } },
        "wall": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" },
                  "params": { "where": "ends", "ends": { "axis": "x", "end": "low",
                              "layers": 0 } } },
        "modes": { "type": "Modes@1", "inputs": { "cubes": "cubes.cubes", "mesh": "beam.mesh",
                   "pins": "wall.pins" }, "params": { "count": 8 } },)" +
           nodes;
}

TEST(GraphOfCubes, ModesFindsTheFirstFrequencyOfABeam)
{
    Scene scene(cantilever(R"("held": { "type": "Modes@1", "inputs": { "cubes": "cubes.cubes",
        "mesh": "beam.mesh" }, "params": { "count": 8, "keep_rigid": true } })"));
    const auto model = scene.at<physics::ModalModel>("modes");
    ASSERT_EQ(model->count(), 8u);
    // 1.8751^2 / 2 pi sqrt(E I / rho A L^4) = 1.6154 Hz, 1 % less by shear and rotary inertia at
    // L/h = 10 and by lumped mass, as much more by the clamped root. Two ways to bend.
    for (const int k : {0, 1}) {
        EXPECT_NEAR(std::sqrt(model->omega_sq[std::size_t(k)]) / (2 * std::numbers::pi), 1.6154,
                    0.02 * 1.6154);
    }
    const auto free = scene.at<physics::ModalModel>("held");
    for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(free->omega_sq[k], 0);
    EXPECT_GT(free->omega_sq[6], 0);
}

// Coordinates in the modes of a held body mean nothing in those of a free one. Other damping is of
// the same modes.
TEST(GraphOfCubes, VibrateRefusesModesThatChangeOverFrames)
{
    Scene scene(cantilever(R"("grip": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" },
        "params": { "where": "ends", "ends": { "end": "high" }, "on": "=frame < 4" } },
        "gripped": { "type": "Modes@1", "inputs": { "cubes": "cubes.cubes", "mesh": "beam.mesh",
                     "pins": "grip.pins" }, "params": { "count": 8 } },
        "play": { "type": "Vibrate@1", "inputs": { "model": "gripped.model" },
                  "params": { "gravity": [0, -9.81, 0] } },
        "damped": { "type": "Voxelize@1", "inputs": { "mesh": "beam.mesh" }, "params": {
                    "method": "solid", "size": 0.1, "matter": { "mass_damping": "=frame" } } },
        "same": { "type": "Modes@1", "inputs": { "cubes": "damped.cubes", "mesh": "beam.mesh",
                  "pins": "wall.pins" }, "params": { "count": 8 } },
        "fade": { "type": "Vibrate@1", "inputs": { "model": "same.model" },
                  "params": { "gravity": [0, -9.81, 0] } })"));
    EXPECT_EQ(scene.failure_at<geometry::TriMesh>("play", 3), "");
    const std::string told = scene.failure_at<geometry::TriMesh>("play", 4);
    EXPECT_NE(told.find("must be the same in all frames"), std::string::npos) << told;
    EXPECT_EQ(scene.failure_at<geometry::TriMesh>("fade", 5), "");
}

TEST(GraphOfCubes, VibrateSagsUnderItsWeightAndSwingsWhenKicked)
{
    Scene scene(cantilever(R"(
        "sag": { "type": "Vibrate@1", "inputs": { "model": "modes.model" },
                 "params": { "gravity": [0, -9.81, 0], "damping": { "kind": "ratio", "ratio": 1 } } },
        "tip": { "type": "Measure@1", "inputs": { "mesh": "sag.mesh", "rest": "beam.mesh" },
                 "params": { "what": "displacement_at", "point": [1, 0, 0],
                             "direction": [0, -1, 0] } },
        "kicked": { "type": "Vibrate@1", "inputs": { "model": "modes.model" },
                    "params": { "kicks": [ { "frame": 3, "position": [1, 0, 0],
                                             "impulse": [0, 0.1, 0] } ] } },
        "swing": { "type": "Measure@1", "inputs": { "mesh": "kicked.mesh", "rest": "beam.mesh" },
                   "params": { "what": "displacement_max" } })"));
    // rho g A L^4 / 8 E I + rho g L^2 / 2 kappa G = 0.1472 + 0.0015 m.
    EXPECT_NEAR(*scene.at<double>("tip", 100), 0.1487, 0.02 * 0.1487);
    EXPECT_EQ(*scene.at<double>("swing", 3), 0);
    // The first mode alone: q' = phi(L) J, u = phi(L)^2 J / omega at most, phi(L)^2 = 4 / m.
    // A quarter of a period, 0.155 s, is 3.7 frames after the kick.
    const double most = 4 / 10.0 * 0.1 / (2 * std::numbers::pi * 1.6154);
    double largest = 0;
    for (int frame = 4; frame < 12; ++frame) {
        largest = std::max(largest, *scene.at<double>("swing", frame));
    }
    EXPECT_GT(largest, 0.9 * most);
    EXPECT_LT(largest, 1.6 * most);  // higher modes on top
}

// A block that falls on a block that is held: it rests there, or passes where contact is off.
TEST(GraphOfCubes, ABlockThatFallsOnAnotherRestsOnIt)
{
    const auto height_of = [](const std::string& method, const std::string& on) {
        Scene scene(fmt::format(R"(
        "low": {{ "type": "Primitive@1", "params": {{ "shape": "box", "centre": [0, 0.1, 0],
                 "box": {{ "size": [0.4, 0.2, 0.4] }} }} }},
        "high": {{ "type": "Primitive@1", "params": {{ "shape": "box", "centre": [0, 0.4, 0],
                  "box": {{ "size": [0.2, 0.2, 0.2] }} }} }},
        "both": {{ "type": "Merge@1", "inputs": {{ "meshes": ["low.mesh", "high.mesh"] }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "both.mesh" }},
                   "params": {{ "method": "solid", "size": 0.1, "align": "origin",
                               "matter": {{ "young": 1e6, "stiffness_damping": 0.01 }} }} }},
        "pin": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
                 "params": {{ "box": {{ "centre": [0, 0, 0], "size": [1, 0.1, 1] }} }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes", "pins": ["pin.pins"],
                                                    "surface": "both.mesh" }},
                 "params": {{ "method": "{}", "contact": {{ "on": {} }} }} }},
        "shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "both.mesh", "cubes": "cubes.cubes",
                                                   "state": "sim.state" }} }})",
                                method, on));
        const auto rest = scene.at<TriMesh>("both"), moved = scene.at<TriMesh>("shape", 30);
        float lowest = 10;  // of the upper block
        for (std::size_t v = 0; v < rest->positions.size(); ++v) {
            if (rest->positions[v].y() > 0.25f) lowest = std::min(lowest, moved->positions[v].y());
        }
        return lowest;
    };
    for (const std::string method : {"bricks", "springs"}) {
        EXPECT_NEAR(height_of(method, "true"), 0.2f, 0.005f) << method;
        EXPECT_LT(height_of(method, "false"), -1.0f) << method;
    }
}

// Two sheets in one layer of cubes: each part's shape is that of its cubes, and they overlap.
TEST(GraphOfCubes, PartsThatOverlapAtRestAreNotPushedApart)
{
    Scene scene(R"(
        "low": { "type": "Primitive@1", "params": { "shape": "grid", "centre": [0, 0.02, 0] } },
        "high": { "type": "Primitive@1", "params": { "shape": "grid", "centre": [0, 0.07, 0] } },
        "both": { "type": "Merge@1", "inputs": { "meshes": ["low.mesh", "high.mesh"] } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "both.mesh" },
                   "params": { "method": "surface", "size": 0.1, "align": "origin",
                               "pieces": "apart" } },
        "parts": { "type": "ConnectedComponent@1", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "keep": "all" } },
        "count": { "type": "Measure@1", "inputs": { "cubes": "parts.cubes" },
                   "params": { "what": "components" } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" },
                 "params": { "gravity": [0, 0, 0] } },
        "shape": { "type": "Embed@3", "inputs": { "mesh": "both.mesh", "cubes": "cubes.cubes",
                                                  "state": "sim.state" } })");
    ASSERT_EQ(*scene.at<double>("count"), 2);
    const auto rest = scene.at<TriMesh>("both"), moved = scene.at<TriMesh>("shape", 6);
    for (std::size_t v = 0; v < rest->positions.size(); ++v) {
        EXPECT_LT((moved->positions[v] - rest->positions[v]).norm(), 1e-4f) << v;
    }
}

TEST(GraphOfCubes, OfTwoBlocksHalfACubeApartOneIsHeldAndTheOtherFalls)
{
    // The blocks end at x = -0.025 and 0.025, cubes of 0.1 m meet at x = 0 or contain the gap.
    const auto scene_of = [](const std::string& pieces, double origin) {
        return fmt::format(R"(
        "left": {{ "type": "Primitive@1", "params": {{ "shape": "box", "centre": [-0.125, 0, 0],
                  "box": {{ "size": [0.2, 0.2, 0.2] }} }} }},
        "right": {{ "type": "Primitive@1", "params": {{ "shape": "box", "centre": [0.125, 0, 0],
                   "box": {{ "size": [0.2, 0.2, 0.2] }} }} }},
        "both": {{ "type": "Merge@1", "inputs": {{ "meshes": ["left.mesh", "right.mesh"] }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "both.mesh" }},
                   "params": {{ "method": "solid", "size": 0.1, "pieces": "{0}", "align": "origin",
                               "origin": [{1}, -0.1, -0.1] }} }},
        "parts": {{ "type": "ConnectedComponent@1", "inputs": {{ "cubes": "cubes.cubes" }},
                   "params": {{ "keep": "all" }} }},
        "count": {{ "type": "Measure@1", "inputs": {{ "cubes": "parts.cubes" }},
                   "params": {{ "what": "components" }} }},
        "pin": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
                 "params": {{ "box": {{ "centre": [-0.225, 0, 0], "size": [0.4, 1, 1] }} }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes", "pins": ["pin.pins"],
                                                    "surface": "both.mesh" }},
                 "params": {{ "step": {{ "substeps": 4 }} }} }},
        "shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "both.mesh", "cubes": "cubes.cubes",
                                                   "state": "sim.state" }} }})",
                           pieces, origin);
    };
    for (const double origin : {-0.3, -0.25, -0.275}) {
        SCOPED_TRACE(origin);
        Scene scene(scene_of("apart", origin));
        EXPECT_EQ(*scene.at<double>("count"), 2);
        const auto rest = scene.at<TriMesh>("both"), fallen = scene.at<TriMesh>("shape", 13);
        for (std::size_t v = 0; v < rest->positions.size(); ++v) {
            const float drop = rest->positions[v].y() - fallen->positions[v].y();
            // Half a second of free fall, in steps of 1 / 96 s: 1.23 m and a little more.
            if (rest->positions[v].x() > 0)
                EXPECT_NEAR(drop, 1.25f, 0.05f) << v;
            else
                EXPECT_NEAR(drop, 0.0f, 0.01f) << v;
        }
        Scene merged(scene_of("merge", origin));
        EXPECT_EQ(*merged.at<double>("count"), 1);
    }
}

TEST(GraphOfCubes, TheTeethOfACombSwingByThemselves)
{
    // Five teeth of 0.15 x 0.8 x 0.1 m on a bar that is held, gaps of half a cube between them.
    const auto lowest_and_fifth = [](int teeth, const std::string& pieces) {
        std::string nodes, links = R"("bar.mesh")";
        for (int i = 0; i < teeth; ++i) {
            nodes += fmt::format(R"("tooth{0}": {{ "type": "Primitive@1", "params": {{
                "shape": "box", "centre": [{1}, 0.4, 0.05],
                "box": {{ "size": [0.15, 0.8, 0.1] }} }} }},)",
                                 i, 0.2 * i + 0.075);
            links += fmt::format(R"(, "tooth{}.mesh")", i);
        }
        Scene scene(nodes + R"(
            "bar": { "type": "Primitive@1", "params": { "shape": "box",
                     "centre": [0.475, -0.05, 0.05], "box": { "size": [0.95, 0.1, 0.1] } } },
            "comb": { "type": "Merge@1", "inputs": { "meshes": [)" +
                    links + R"(] } },
            "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "comb.mesh" },
                       "params": { "method": "solid", "size": 0.1, "align": "origin",
                                   "pieces": ")" +
                    pieces + R"(" } },
            "held": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" },
                      "params": { "where": "below", "below": { "height": 0.001 } } },
            "modes": { "type": "Modes@1", "inputs": { "cubes": "cubes.cubes", "mesh": "comb.mesh",
                       "pins": "held.pins" }, "params": { "count": 5 } })");
        const auto model = scene.at<physics::ModalModel>("modes");
        return std::pair(std::sqrt(model->omega_sq.at(0)), std::sqrt(model->omega_sq.at(4)));
    };
    const double one = lowest_and_fifth(1, "merge").first;
    const auto [first, fifth] = lowest_and_fifth(5, "apart");
    EXPECT_NEAR(first, one, 0.03 * one);
    EXPECT_NEAR(fifth, one, 0.03 * one);
    EXPECT_GT(lowest_and_fifth(5, "merge").second, 1.5 * one);
}

}  // namespace
