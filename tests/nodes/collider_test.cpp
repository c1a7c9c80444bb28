// Collider through graphs.

#include "geometry/mesh/mesh.hpp"
#include "physics/body/collider_contact.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <string>

namespace {

using fixtures::Scene;
using physics::Vec3;

constexpr const char* corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\n"
                                "v 0 1 1\n";
constexpr const char* lid_out = "f 4 8 7 3\n";

std::string reading(const std::string& file)
{
    return R"("box": { "type": "ReadMesh@1", "params": { "path": ")" + file + R"(" } },
        "stop": { "type": "Collider@1", "inputs": { "mesh": "box.mesh" },
                  "params": { "kind": "mesh" } })";
}

// A box with all faces in, and one with its lid alone turned in: both stop as the box does, and say
// so. What bounds a hollow within a solid stays as it is.
TEST(ColliderNode, FacesThatLookInAreTurnedOut)
{
    const files::Folder folder;
    folder.write("in.obj", std::string(corners) + "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\n"
                                                  "f 3 7 8 4\nf 4 8 5 1\n");
    const std::string sides = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 4 1 5 8\n";
    folder.write("lid.obj", std::string(corners) + sides + "f 3 7 8 4\n");
    folder.write("out.obj", std::string(corners) + sides + lid_out);
    for (const auto* file : {"in.obj", "lid.obj", "out.obj"}) {
        Scene scene(reading(file), folder.path);
        const auto made = scene.at<physics::Collider>("stop");
        EXPECT_FALSE(made->sheet) << file;
        const auto posed = physics::pose_collider(*made, 1, 1.0 / 24, 0.1);
        const physics::Touch t = physics::touch(posed, Vec3(0.5, 0.95, 0.6));
        EXPECT_NEAR(t.gap, -0.05, 1e-6) << file;
        EXPECT_NEAR(t.normal.y(), 1, 1e-6) << file;
        const bool turned = std::string(file) != "out.obj";
        ASSERT_EQ(scene.warnings.size(), turned ? 1u : 0u) << file;
        if (!turned) continue;
        EXPECT_NE(scene.warnings[0].find(file[0] == 'i' ? "12 of 12 faces" : "2 of 12 faces"),
                  std::string::npos)
            << scene.warnings[0];
    }
}

TEST(ColliderNode, AnOpenMeshStaysASheet)
{
    const files::Folder folder;
    folder.write("open.obj", std::string(corners) + "f 1 2 3 4\n");
    Scene scene(reading("open.obj"), folder.path);
    EXPECT_TRUE(scene.at<physics::Collider>("stop")->sheet);
    EXPECT_TRUE(scene.warnings.empty());
}

// A box of quads with their backs is solid, and a quad with its back is a sheet: as without them.
TEST(ColliderNode, FacesThatAreThereTwiceStopOnce)
{
    const files::Folder folder;
    const std::string sides = "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 4 1 5 8\n";
    const std::string backs = "f 2 3 4 1\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 8 5 1 4\n";
    const std::string lid_in = "f 3 7 8 4\n";
    folder.write("box.obj", corners + sides + lid_out + backs + lid_in);
    folder.write("sheet.obj", std::string(corners) + lid_out + lid_in);
    folder.write("copied.obj", std::string(corners) + lid_out + lid_out);
    for (const std::string file : {"box.obj", "sheet.obj", "copied.obj"}) {
        Scene scene(reading(file), folder.path);
        const auto made = scene.at<physics::Collider>("stop");
        const bool solid = file == "box.obj";
        EXPECT_EQ(made->sheet, !solid) << file;
        EXPECT_EQ(made->mesh->triangles().size(), solid ? 12u : 2u) << file;
        const auto posed = physics::pose_collider(*made, 1, 1.0 / 24, 0.1);
        const physics::Touch t = physics::touch(posed, Vec3(0.5, 0.95, 0.6));
        EXPECT_NEAR(t.gap, -0.05, 1e-6) << file;
        EXPECT_NEAR(t.normal.y(), 1, 1e-6) << file;
        ASSERT_EQ(scene.warnings.size(), 1u) << file;
        EXPECT_NE(scene.warnings[0].find(solid ? "12 of 24 triangles" : "2 of 4 triangles"),
                  std::string::npos)
            << scene.warnings[0];
    }
}

// Frames start with the sizes of the frame before; what keeps its size says nothing of it.
TEST(ColliderNode, KnowsItsSizeOfTheFrameBefore)
{
    Scene scene(R"("still": { "type": "Collider@1", "params": { "kind": "box" } },
        "box": { "type": "Collider@1", "params": { "kind": "box", "thickness": "=0.01 * frame",
                 "box": { "size": [2, "=frame", 2] } } },
        "ball": { "type": "Collider@1", "params": { "kind": "sphere",
                  "sphere": { "radius": "=frame" } } })");
    for (const auto* node : {"box", "ball"}) {
        EXPECT_FALSE(scene.at<physics::Collider>(node, 1)->size_before) << node;
        EXPECT_FALSE(scene.at<physics::Collider>("still", 3)->size_before);
    }
    const auto box = scene.at<physics::Collider>("box", 3);
    ASSERT_TRUE(box->size_before);
    EXPECT_EQ(box->size_before->half_size, Vec3(1, 1, 1));
    EXPECT_EQ(box->half_size, Vec3(1, 1.5, 1));
    EXPECT_EQ(box->size_before->thickness, 0.02);
    const auto ball = scene.at<physics::Collider>("ball", 3);
    ASSERT_TRUE(ball->size_before);
    EXPECT_EQ(ball->size_before->radius, 2);
}

TEST(ColliderNode, AGroundRisesFromWhereItWas)
{
    Scene scene(R"("ground": { "type": "Ground@1", "params": { "height": "=frame" } })");
    for (const int frame : {1, 3}) {
        const auto ground = scene.at<physics::Collider>("ground", frame);
        EXPECT_EQ(ground->pose.translation().y(), frame);
        EXPECT_EQ(ground->before.translation().y(), std::max(1, frame - 1));
    }
}

std::string cut_anew(const std::string& size_y, const std::string& centre)
{
    return R"("box": { "type": "Primitive@1", "params": { "shape": "box",
                "box": { "size": [2, )" +
           size_y + R"(, 2], "divisions_x": "=frame" }, "centre": )" + centre + R"( } },
        "stop": { "type": "Collider@1", "inputs": { "mesh": "box.mesh" },
                  "params": { "kind": "mesh" } })";
}

// Each frame cuts the box anew: a quarter of the frame after its top was at 0.8, it has gone a
// quarter of its way, be it up or down.
TEST(ColliderNode, AMeshOfOtherTrianglesThatKeepsItsSizeMovesAsAWhole)
{
    constexpr double seconds = 1.0 / 24, part = 0.25;
    for (const double up : {0.1, -0.1}) {  // m a frame
        const std::string y = "0.3 + (frame - 3) * " + std::to_string(up);
        Scene scene(cut_anew("1", "[\"=0.05 * (frame - 3)\", \"=" + y + "\", 0]"));
        EXPECT_EQ(scene.at<physics::Collider>("stop", 1)->mesh_before, nullptr);
        const auto stop = scene.at<physics::Collider>("stop", 4);
        ASSERT_NE(stop->mesh_before, nullptr);
        EXPECT_EQ(stop->mesh_before->topology, stop->mesh->topology);
        const physics::PosedCollider posed = physics::pose_collider(*stop, part, seconds, 0.2);
        for (const double x : {-0.9, 0.1, 0.8}) {
            const physics::Touch t = physics::touch(posed, Vec3(x, 0.77, 0.3));
            EXPECT_NEAR(t.gap, -0.03 - up * part, 1e-6) << x;
            EXPECT_NEAR((t.velocity - Vec3(0.05, up, 0) / seconds).norm(), 0, 1e-5) << x;
            EXPECT_NEAR(t.normal.y(), 1, 1e-6) << x;
        }
    }
}

// The top rises by 0.1 m a frame, and the bottom stays.
TEST(ColliderNode, AMeshOfOtherTrianglesThatGrowsMovesAcrossItsSurface)
{
    constexpr double seconds = 1.0 / 24, part = 0.25;
    Scene scene(cut_anew(R"("=0.5 + 0.1 * frame")", R"([0, "=0.05 * frame", 0])"));
    const auto stop = scene.at<physics::Collider>("stop", 4);  // from 0.55 to 0.65
    const physics::PosedCollider posed = physics::pose_collider(*stop, part, seconds, 0.2);
    for (const double x : {-0.9, 0.1, 0.8}) {
        const physics::Touch t = physics::touch(posed, Vec3(x, 0.55, 0.3));
        EXPECT_NEAR(t.gap, -0.1 * part, 1e-6) << x;
        EXPECT_NEAR(t.velocity.y(), 0.1 / seconds, 1e-5) << x;
        EXPECT_NEAR(t.normal.y(), 1, 1e-6) << x;
    }
}

}  // namespace
