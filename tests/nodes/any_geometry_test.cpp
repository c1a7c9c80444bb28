// Point clouds and curves from files to bodies of cubes, through a graph.

#include "geometry/cubes/cubes.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <numbers>

namespace {

using fixtures::Scene;
using geometry::Cubes;
using geometry::TriMesh;

std::string reading(const std::string& file, const std::string& more = "")
{
    return fmt::format(R"("read": {{ "type": "ReadMesh@1", "params": {{ "path": "{}"{} }} }})",
                       file, more);
}

TEST(AnyGeometry, PointsAreReadFromTextWithTheirColours)
{
    const files::Folder folder;
    folder.write("a.xyz", "# scanned\n0 0 0\n1,2,3\n\n-1.5e0\t+2 3 0.7\n");
    folder.write("a.pts", "2\n0 0 0 -12 255 0 0\n1 0 0 40 0 255 0\n");
    folder.write("a.asc", "X Y Z R G B\r\n0 0 0 0 0 255\r\n1 1 1 10 20 30\r\n");
    folder.write("n.xyz", "0 0 0 0 1 0\n1 1 1 1 0 0\n");
    const auto read = [&](const std::string& name) {
        return Scene(reading(name), folder.path).at<TriMesh>("read");
    };
    const auto plain = read("a.xyz");
    ASSERT_EQ(plain->positions.size(), 3u);
    EXPECT_EQ(plain->positions[2], geometry::Vec3f(-1.5f, 2, 3));
    EXPECT_TRUE(plain->colours.empty());
    const auto pts = read("a.pts");
    ASSERT_EQ(pts->colours.size(), 2u);
    EXPECT_EQ(pts->colours[1], geometry::Vec3f(0, 1, 0));
    EXPECT_EQ(read("a.asc")->colours.at(0), geometry::Vec3f(0, 0, 1));
    EXPECT_TRUE(read("n.xyz")->colours.empty());  // normals
    folder.write("bad.xyz", "0 0 0\n1 1\n");
    const std::string told = Scene(reading("bad.xyz"), folder.path).failure_at<TriMesh>("read");
    EXPECT_NE(told.find("expected x, y and z in line 2, found \"1 1\""), std::string::npos) << told;
}

TEST(AnyGeometry, RulesOfMaterialsForACloudAreToldToDoNothing)
{
    const files::Folder folder;
    folder.write("a.xyz", "0 0 0\n1 0 0\n0 1 0\n");
    const auto warnings = [&](const std::string& params) {
        Scene scene(reading("a.xyz") + R"(, "sample": { "type": "Sample@2",
            "inputs": { "mesh": "read.mesh" }, "params": {)" +
                        params + "} }",
                    folder.path);
        scene.at<geometry::Samples>("sample");
        return scene.warnings;
    };
    EXPECT_TRUE(warnings("").empty());
    const auto told = warnings(R"("materials": [{ "match": "material", "name": "wood" }])");
    ASSERT_EQ(told.size(), 1u);
    EXPECT_NE(told[0].find("materials have no effect"), std::string::npos) << told[0];
}

// Points 1 mm apart in a file that is read as one in metres: 1 m apart.
TEST(AnyGeometry, CubesThatTouchNoOtherAreTold)
{
    const files::Folder folder;
    std::string points;
    for (int i = 0; i < 200; ++i) points += fmt::format("{} {} 0\n", i % 20, i / 20);
    folder.write("scan.xyz", points);
    const auto warnings = [&](const std::string& unit, const std::string& size) {
        Scene scene(reading("scan.xyz", unit) + R"(, "c": { "type": "Voxelize@1",
            "inputs": { "mesh": "read.mesh" }, "params": { "method": "surface", "size": )" +
                        size + "} }",
                    folder.path);
        scene.at<Cubes>("c");
        return scene.warnings;
    };
    EXPECT_TRUE(warnings("", "1.5").empty());
    EXPECT_TRUE(warnings(R"(, "unit": "mm")", "0.0015").empty());
    const auto told = warnings("", "0.0015");
    ASSERT_EQ(told.size(), 1u);
    EXPECT_NE(told[0].find("200 of 200 cubes touch no other"), std::string::npos) << told[0];
}

TEST(AnyGeometry, NormalsOfFilesAreThoseThatAreAskedFor)
{
    const files::Folder folder;
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nvn 0.6 0.8 0\n"
                          "f 1//1 2//1 3//1 4//1\n");
    const auto normal = [&](const std::string& which) {
        Scene scene(reading("a.obj", R"(, "normals": ")" + which + "\""), folder.path);
        return scene.at<TriMesh>("read")->normals.at(0);
    };
    EXPECT_LT((normal("file") - geometry::Vec3f(0.6f, 0.8f, 0)).norm(), 1e-6f);
    EXPECT_LT((normal("computed") - geometry::Vec3f(0, -1, 0)).norm(), 1e-6f);
}

// 1000 points on a lattice of 0.1 m: one in each of 1000 cubes, which are full, by both ways.
TEST(AnyGeometry, AScannedCloudBecomesABody)
{
    const files::Folder folder;
    std::string text;
    for (int i = 0; i < 1000; ++i) {
        const int y = i / 10 % 10, z = i / 100;
        text += fmt::format("{:.2f} {:.2f} {:.2f}\n", 0.05 + 0.1 * (i % 10), 0.05 + 0.1 * y,
                            0.05 + 0.1 * z);
    }
    folder.write("cloud.xyz", text);
    const auto scene = [&](const std::string& params, const std::string& more) {
        return Scene(reading("cloud.xyz") + fmt::format(R"(,
            "sample": {{ "type": "Sample@2", "inputs": {{ "mesh": "read.mesh" }},
                        "params": {{ "mass": "total", "total_mass": 3 }} }},
            "cubes": {{ "type": "Voxelize@1", "inputs": {{ {} }}, "params": {{ "size": 0.1,
                        "align": "origin", {} }} }},
            "mass": {{ "type": "Measure@1", "inputs": {{ "cubes": "cubes.cubes" }},
                      "params": {{ "what": "mass" }} }})",
                                                        more, params),
                     folder.path);
    };
    Scene direct = scene(R"("method": "surface")", R"("mesh": "read.mesh")");
    EXPECT_EQ(direct.at<Cubes>("cubes")->count(), 1000u);
    EXPECT_NEAR(*direct.at<double>("mass"), 1000, 1e-6);
    // Each sample has m / N.
    Scene sampled = scene(R"("method": "samples")", R"("points": "sample.points")");
    EXPECT_NEAR(*sampled.at<double>("mass"), 3, 1e-6);
    for (const double m : sampled.at<Cubes>("cubes")->mass) EXPECT_NEAR(m, 0.003, 1e-9);
    Scene solid = scene(R"("method": "solid")", R"("mesh": "read.mesh")");
    const std::string told = solid.failure_at<Cubes>("cubes");
    EXPECT_NE(told.find("use method = surface"), std::string::npos) << told;
}

// The box is 10 cubes long from -0.5 m on. Its last cube holds its upper face, where no sample lies
// beyond that.
TEST(AnyGeometry, SamplesBeyondTheMeshThatPlacesTheGridHaveCubesThere)
{
    const files::Folder folder;
    folder.write("a.xyz", "2.05 0.05 0.05\n-3.05 0.05 0.05\n0.05 0.5 0.05\n");
    Scene scene(reading("a.xyz") + R"(,
        "sample": { "type": "Sample@2", "inputs": { "mesh": "read.mesh" } },
        "box": { "type": "Primitive@1", "params": { "shape": "box", "box": { "size": [1, 1, 1] } } },
        "cubes": { "type": "Voxelize@1", "inputs": { "points": "sample.points", "mesh": "box.mesh" },
                   "params": { "size": 0.1 } })",
                folder.path);
    const auto cubes = scene.at<Cubes>("cubes");
    EXPECT_EQ(cubes->cell, (std::vector<geometry::Vec3i>{{-26, 5, 5}, {25, 5, 5}, {5, 9, 5}}));
    EXPECT_LT((cubes->origin - geometry::Vec3::Constant(-0.5)).norm(), 1e-6);
}

// Beside points that lie elsewhere: of the cloud itself, and of samples.
TEST(AnyGeometry, ACloudPlacesTheGrid)
{
    const files::Folder folder;
    folder.write("cloud.xyz", "0 0 0\n1 0 0\n0 1 1\n");
    folder.write("far.xyz", "5.03 0.01 0.02\n");
    for (const char* method : {"surface", "samples"}) {
        Scene scene(reading("cloud.xyz") + fmt::format(R"(,
            "far": {{ "type": "ReadMesh@1", "params": {{ "path": "far.xyz" }} }},
            "sample": {{ "type": "Sample@2", "inputs": {{ "mesh": "far.mesh" }} }},
            "cubes": {{ "type": "Voxelize@1",
                       "inputs": {{ "points": "sample.points", "mesh": "read.mesh" }},
                       "params": {{ "size": 0.3, "method": "{}" }} }})",
                                                       method),
                    folder.path);
        // 4 cubes of 0.3 m about the middle of 1 m.
        EXPECT_LT((scene.at<Cubes>("cubes")->origin - geometry::Vec3::Constant(-0.1)).norm(), 1e-6)
            << method;
    }
}

// Two lines, one closed, in centimetres: a curve each, on a frame of its own. The ring's box is a
// metre wide, its lowest point goes to the ground.
TEST(AnyGeometry, LinesBecomeSkeletons)
{
    const files::Folder folder;
    folder.write("wire.obj", "v 0 50 0\nv 100 50 0\nv 100 150 0\nv 0 150 0\nv 0 50 70\nv 0 90 70\n"
                             "l 1 2 3 4 1\nl 5 6\n");
    Scene scene(reading("wire.obj", R"(, "unit": "cm", "place": "ground")") + R"(,
        "wires": { "type": "Skeletons@1", "inputs": { "lines": "read.lines" }, "params": { "each":
                   { "thickness": 0.1, "stiffness": 10, "radius": 0.25 } } })",
                folder.path);
    const auto layer = scene.at<geometry::ImplicitLayer>("wires");
    ASSERT_EQ(layer->skeletons.size(), 2u);
    EXPECT_EQ(layer->skeletons[0].kind, geometry::SkeletonKind::curve);
    ASSERT_EQ(layer->skeletons[0].points.size(), 5u);
    EXPECT_EQ(layer->skeletons[0].points[0], layer->skeletons[0].points[4]);
    EXPECT_LT((layer->skeletons[0].points[2] - geometry::Vec3(0.5, 1, -0.35)).norm(), 1e-6);
    ASSERT_EQ(layer->skeletons[1].points.size(), 2u);
    EXPECT_EQ(layer->frame, (std::vector<std::uint32_t>{0, 1}));
}

// Two lines of 1 m, 0.1 m thick: tubes of pi / 4 x 0.1^2 x 1 m^3 each, which end at (1, 0, 0).
TEST(AnyGeometry, LinesOfAThicknessBecomeABody)
{
    const files::Folder folder;
    folder.write("wire.obj", "v 0 0 0\nv 100 0 0\nv 100 100 0\nl 1 2 3\n");
    Scene scene(reading("wire.obj", R"(, "line_thickness": 0.1, "unit": "cm")") + R"(,
        "volume": { "type": "Measure@1", "inputs": { "mesh": "read.mesh" },
                    "params": { "what": "volume" } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "read.mesh" },
                   "params": { "method": "solid", "size": 0.05 } },
        "parts": { "type": "ConnectedComponent@1", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "keep": "all" } },
        "count": { "type": "Measure@1", "inputs": { "cubes": "parts.cubes" },
                   "params": { "what": "components" } },
        "mass": { "type": "Measure@1", "inputs": { "cubes": "cubes.cubes" },
                  "params": { "what": "mass" } })",
                folder.path);
    const double tube = std::numbers::pi / 4 * 0.01;
    EXPECT_NEAR(*scene.at<double>("volume"), 2 * tube, 1e-5 * tube);
    EXPECT_EQ(*scene.at<double>("count"), 1);
    // At the bend both ends overlap in a quarter of a joint, which counts once.
    EXPECT_LT(*scene.at<double>("mass"), 2000 * tube);
    EXPECT_GT(*scene.at<double>("mass"), 0.97 * 2000 * tube);
    Scene without(reading("wire.obj"), folder.path);
    EXPECT_TRUE(without.at<TriMesh>("read")->triangles().empty());
    ASSERT_FALSE(without.warnings.empty());
    EXPECT_NE(without.warnings[0].find(
                  "left out 2 lines, which the output 'lines' has: set line_thickness"),
              std::string::npos);
}

// The same corners as a strip (mode 3) and as a loop (mode 2), which closes by the diagonal.
TEST(AnyGeometry, LinesOfGltfBecomeTubes)
{
    const files::Folder folder;
    const auto volume = [&](int mode) {
        folder.write("wire.gltf", R"({ "asset": { "version": "2.0" }, "scene": 0,
            "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": )" +
                                      std::to_string(mode) + R"( }] }],
            "buffers": [{ "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                            "min": [0, 0, 0], "max": [1, 1, 0] }] })");
        Scene scene(reading("wire.gltf", R"(, "line_thickness": 0.1)") + R"(,
            "volume": { "type": "Measure@1", "inputs": { "mesh": "read.mesh" },
                        "params": { "what": "volume" } })",
                    folder.path);
        return *scene.at<double>("volume");
    };
    const double section = std::numbers::pi / 4 * 0.01;
    EXPECT_NEAR(volume(3), 2 * section, 1e-5 * section);
    EXPECT_NEAR(volume(2), (2 + std::numbers::sqrt2) * section, 1e-5 * section);
}

}  // namespace
