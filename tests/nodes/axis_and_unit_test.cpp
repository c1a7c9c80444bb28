// WriteMesh in another axis and unit: what another program reads, and what ReadMesh reads back.

#include "geometry/io/own_header.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

#include <fstream>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;
using geometry::Vec3f;

// 1 m wide, 2 m high, 3 m deep, away from the origin and asymmetric.
TriMesh brick()
{
    TriMesh mesh = geometry::box({1, 2, 3}, {1, 1, 1});
    for (Vec3f& p : mesh.positions) p += Vec3f(4, 5, 6);
    return mesh;
}

TriMesh written_and_read(const files::fs::path& folder, const std::string& ending,
                         const std::string& up, const std::string& unit, bool stated = true)
{
    NodeRun write("WriteMesh");
    write.output_folder = folder;
    write.inputs["mesh"] = {graph::Value::of(brick())};
    write.param("path").is = files::fs::path("brick." + ending);
    write.param("up").is = up;
    write.param("unit").is = unit;
    write.run();
    NodeRun read("ReadMesh");
    read.param("path").is = (folder / ("brick." + ending)).string();
    if (stated) {
        read.param("up").is = up;
        read.param("unit").is = unit;
    }
    return *read.run().as<TriMesh>();
}

TEST(WriteMesh, InAnotherAxisAndUnitReadsBackAsItWas)
{
    const files::Folder folder;
    const auto expected = geometry::bounds(brick());
    for (const char* ending : {"obj", "ply", "stl"}) {
        for (const char* up : {"y", "z"}) {
            for (const char* unit : {"m", "mm", "inch"}) {
                SCOPED_TRACE(std::string(ending) + " " + up + " " + unit);
                const TriMesh back = written_and_read(folder.path, ending, up, unit);
                const auto box = geometry::bounds(back);
                EXPECT_LT((box.lo - expected.lo).norm(), 1e-5);
                EXPECT_LT((box.hi - expected.hi).norm(), 1e-5);
                // Still seen from outside.
                double volume = 0;
                for (const auto& t : back.triangles()) {
                    const Vec3f &a = back.positions[t[0]], &b = back.positions[t[1]],
                                &c = back.positions[t[2]];
                    volume += double(a.dot(b.cross(c))) / 6;
                }
                EXPECT_NEAR(volume, 6, 1e-3);
            }
        }
    }
}

TEST(WriteMesh, SaysTheAxisAndUnitAndReadMeshReadsThem)
{
    const files::Folder folder;
    const auto expected = geometry::bounds(brick());
    for (const char* ending : {"obj", "ply", "stl"}) {
        const auto box = geometry::bounds(written_and_read(folder.path, ending, "z", "mm", false));
        EXPECT_LT((box.lo - expected.lo).norm(), 1e-5) << ending << box.lo.transpose();
        EXPECT_LT((box.hi - expected.hi).norm(), 1e-5) << ending << box.hi.transpose();
        const std::string head =
            files::bytes_of(folder.path / (std::string("brick.") + ending)).substr(0, 90);
        EXPECT_NE(head.find("Aspic: millimetres, z up"), std::string::npos) << head;
    }
    // What is set counts more than what the file says.
    written_and_read(folder.path, "obj", "z", "mm");
    NodeRun read("ReadMesh");
    read.param("path").is = (folder.path / "brick.obj").string();
    read.param("unit").is = std::string("cm");
    read.param("up").is = std::string("y");
    EXPECT_NEAR(geometry::bounds(*read.run().as<TriMesh>()).hi.z(), 60, 1e-3);
}

TEST(WriteMesh, OnlyWholeHeadersOfOurOwnAreRead)
{
    for (const double unit : {1.0, 0.01, 0.001, 0.0254, 0.3048, 0.05, 1e-12}) {
        const auto back = geometry::frame_of_header("# " + geometry::own_header({unit, true}));
        ASSERT_TRUE(back.has_value()) << geometry::own_header({unit, true});
        EXPECT_EQ(back->unit, unit);
        EXPECT_TRUE(back->z_up);
    }
    for (const char* text : {"", "Aspic: ", "Aspic: metres", "Aspic: metres, x up",
                             "Aspic: miles, y up", "Aspic: units of -1 m, y up",
                             "Aspic: units of inf m, y up", "Aspic: units of  m, y up"}) {
        EXPECT_FALSE(geometry::frame_of_header(text).has_value()) << text;
    }
}

// By hand: in the text of an OBJ, in millimetres and z up, the height is the third number, and what
// was towards +z is towards -y.
TEST(WriteMesh, WritesTheNumbersThatTheAxisAndUnitSay)
{
    const files::Folder folder;
    written_and_read(folder.path, "obj", "z", "mm");
    std::ifstream file(folder.path / "brick.obj");
    Vec3f low(1e9f, 1e9f, 1e9f), high(-low);
    std::string word;
    while (file >> word) {
        if (word == "v") {
            Vec3f p;
            file >> p[0] >> p[1] >> p[2];
            low = low.cwiseMin(p), high = high.cwiseMax(p);
        }
        std::getline(file, word);
    }
    EXPECT_LT((low - Vec3f(3500, -7500, 4000)).norm(), 1e-2f) << low.transpose();
    EXPECT_LT((high - Vec3f(4500, -4500, 6000)).norm(), 1e-2f) << high.transpose();
}

TEST(WriteMesh, RefusesAxesOfFormatsThatHaveTheirOwn)
{
    const files::Folder folder;
    NodeRun write("WriteMesh");
    write.output_folder = folder.path;
    write.inputs["mesh"] = {graph::Value::of(brick())};
    write.param("path").is = files::fs::path("brick.glb");
    write.run();
    write.param("up").is = std::string("z");
    EXPECT_THROW(write.run(), std::invalid_argument);
    const auto faults = write.type.check(write.params, {});
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_EQ(faults[0].at, "up");
}

}  // namespace
