// The corners of cubes written to files, and their motion read back: what stands in for Simulate.

#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

namespace {

using fixtures::Scene;
using geometry::TriMesh;

const std::string bar = R"(
    "bar": { "type": "Primitive@1", "params": { "shape": "beam", "beam":
             { "length": 1, "height": 0.2, "width": 0.2, "divisions": 10 } } },
    "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "bar.mesh" },
               "params": { "method": "solid", "size": 0.1 } })";
const std::string simulated = bar + R"(,
    "pin": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" },
             "params": { "where": "ends", "ends": { "end": "low" } } },
    "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes", "pins": ["pin.pins"] } },
    "shape": { "type": "Embed@3", "inputs": { "mesh": "bar.mesh", "cubes": "cubes.cubes",
                                              "state": "sim.state" } },
    "cage": { "type": "CubeMesh@1", "inputs": { "cubes": "cubes.cubes", "state": "sim.state" } })";

std::string written(const std::string& path)
{
    return simulated + fmt::format(R"(, "out": {{ "type": "WriteMesh@1",
        "inputs": {{ "mesh": "cage.mesh" }}, "params": {{ "path": "{}" }} }})",
                                   path);
}

std::string read_back(const std::string& path)
{
    return bar + fmt::format(R"(,
    "read": {{ "type": "ReadState@1", "inputs": {{ "cubes": "cubes.cubes" }},
               "params": {{ "path": "{}" }} }},
    "shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "bar.mesh", "cubes": "cubes.cubes",
                                               "state": "read.state" }} }},
    "speed": {{ "type": "Measure@1", "inputs": {{ "state": "read.state" }},
                "params": {{ "what": "speed_max" }} }})",
                             path);
}

// Positions of up to 1 m pass through single precision: half a unit in the last place is 6e-8 m.
TEST(StateFiles, AMotionThatIsWrittenAndReadGivesTheSameMesh)
{
    for (const std::string path : {"c.####.ply", "c.####.obj", "c.pc2"}) {
        SCOPED_TRACE(path);
        const files::Folder folder;
        Scene there(written(path), folder.path);
        for (const int frame : {1, 2, 3}) there.at<graph::WrittenFile>("out", frame);
        Scene back(read_back(path), folder.path);
        for (const int frame : {1, 2, 3}) {
            const auto want = there.at<TriMesh>("shape", frame);
            const auto found = back.at<TriMesh>("shape", frame);
            ASSERT_EQ(want->positions.size(), found->positions.size());
            for (std::size_t v = 0; v < want->positions.size(); ++v) {
                EXPECT_LT((want->positions[v] - found->positions[v]).norm(), 3e-7f) << v;
            }
        }
        // The bar is falling in both.
        EXPECT_LT(back.at<TriMesh>("shape", 3)->positions.back().y(),
                  back.at<TriMesh>("shape", 1)->positions.back().y() - 0.005f);
    }
}

TEST(StateFiles, VelocitiesAreDisplacementsOverAFrame)
{
    // All corners move by 0.1 m a frame along x, written as text: 2.4 m/s at 24 frames a second.
    const files::Folder folder;
    Scene model(bar);
    const auto cubes = model.at<geometry::Cubes>("cubes");
    for (const int frame : {1, 2}) {
        std::string text;
        for (const auto& p : corner_positions(*cubes)) {
            text += fmt::format("{} {} {}\n", p.x() + 0.1 * frame, p.y(), p.z());
        }
        folder.write(fmt::format("c.{}.xyz", frame), text);
    }
    Scene back(read_back("c.#.xyz"), folder.path);
    EXPECT_EQ(*back.at<double>("speed", 1), 0);
    EXPECT_NEAR(*back.at<double>("speed", 2), 2.4, 1e-4);
}

TEST(StateFiles, WrongFilesAreToldWithWhatWasExpectedAndFound)
{
    const files::Folder folder;
    folder.write("few.xyz", "0 0 0\n1 0 0\n");
    EXPECT_NE(Scene(read_back("few.xyz"), folder.path)
                  .failure_at<physics::State>("read")
                  .find("expected 99 points, one for each corner of the cubes, found 2"),
              std::string::npos);
    folder.write("word.xyz", "0 0 0\n0 zero 0\n");
    EXPECT_NE(Scene(read_back("word.xyz"), folder.path)
                  .failure_at<physics::State>("read")
                  .find("expected x, y and z in line 2, found \"0 zero 0\""),
              std::string::npos);
    Scene there(written("c.pc2"), folder.path);
    there.at<graph::WrittenFile>("out", 1);
    there.at<graph::WrittenFile>("out", 3);
    Scene back(read_back("c.pc2"), folder.path);
    EXPECT_NE(back.failure_at<physics::State>("read", 2).find("its frame 2 was never written"),
              std::string::npos);
    std::string corners;
    for (int i = 0; i < 99; ++i) corners += fmt::format("{} 0 0\n", i);
    folder.write("s.0001.xyz", corners);
    Scene gap(read_back("s.####.xyz"), folder.path);
    EXPECT_NE(gap.failure_at<physics::State>("read", 5).find("from frame 1 to 1"),
              std::string::npos);
}

// Corners 11 x 3 x 3; outer squares 2 (10 x 2 + 10 x 2 + 2 x 2) of two triangles each.
TEST(StateFiles, CubeMeshIsClosedAndHasEveryCorner)
{
    Scene scene(bar + R"(, "cage": { "type": "CubeMesh@1", "inputs": { "cubes": "cubes.cubes" } },
        "volume": { "type": "Measure@1", "inputs": { "mesh": "cage.mesh" },
                    "params": { "what": "volume" } })");
    const auto cage = scene.at<TriMesh>("cage");
    EXPECT_EQ(cage->positions.size(), 99u);
    EXPECT_EQ(cage->triangles().size(), 176u);
    EXPECT_NEAR(*scene.at<double>("volume"), 0.04, 1e-8);
    for (const auto& a : cage->attributes) {
        if (a.name != "density") continue;
        for (const float x : a.values) EXPECT_NEAR(x, 1000.f, 0.01f);
    }
}

}  // namespace
