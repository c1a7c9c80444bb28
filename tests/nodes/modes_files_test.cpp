// Modes written to a file and played from it, without cubes.

#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace {

using fixtures::Scene;
using geometry::TriMesh;

const std::string beam = R"(
    "beam": { "type": "Primitive@1", "params": { "shape": "beam", "beam":
              { "length": 1, "height": 0.1, "width": 0.1, "divisions": 10 } } })";
const std::string kicked = R"(,
    "play": { "type": "Vibrate@1", "inputs": { "model": "modes.model" }, "params": {
              "gravity": [0, -1, 0],
              "kicks": [{ "frame": 1, "position": [0.5, 0, 0], "impulse": [0, 0.05, 0] }] } })";

TEST(ModesFiles, PlayTheSameMotionWithoutCubes)
{
    const files::Folder folder;
    Scene there(beam + R"(,
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "beam.mesh" },
                   "params": { "method": "solid", "size": 0.1,
                               "matter": { "stiffness_damping": 0.001 } } },
        "held": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" },
                  "params": { "where": "ends", "ends": { "end": "low", "layers": 0 } } },
        "modes": { "type": "Modes@1", "inputs": { "cubes": "cubes.cubes", "mesh": "beam.mesh",
                   "pins": "held.pins" }, "params": { "count": 4 } },
        "out": { "type": "WriteModes@1", "inputs": { "model": "modes.model" } })" +
                    kicked,
                folder.path);
    there.at<graph::WrittenFile>("out");
    Scene back(beam + R"(,
        "modes": { "type": "ReadModes@1", "inputs": { "mesh": "beam.mesh" },
                   "params": { "path": "modes.txt" } })" +
                   kicked,
               folder.path);
    double largest = 0;
    for (const int frame : {1, 2, 5, 9}) {
        const auto want = there.at<TriMesh>("play", frame), found = back.at<TriMesh>("play", frame);
        ASSERT_EQ(want->positions.size(), found->positions.size());
        for (std::size_t v = 0; v < want->positions.size(); ++v) {
            // Frequencies pass through a square root and back: a few units in the last place.
            EXPECT_LT((want->positions[v] - found->positions[v]).norm(), 2e-7f);
            largest = std::max(
                largest,
                double((want->positions[v] - there.at<TriMesh>("beam")->positions[v]).norm()));
        }
        for (std::size_t n = 0; n < want->normals.size(); ++n) {
            EXPECT_LT((want->normals[n] - found->normals[n]).norm(), 0.02f);
        }
    }
    EXPECT_GT(largest, 0.005);
}

// A mode of another program: all vertices move along x by q, modal mass 3 kg, 2 Hz, undamped. An
// impulse J gives q' = J / 3, and q = J / (3 omega) sin(omega t): 6 frames are a quarter of a
// second, sin = 0; 3 frames an eighth, sin = 1.
TEST(ModesFiles, TakeMassesThatAreNotOne)
{
    const files::Folder folder;
    std::string file = "aspic-modes 1 # by hand\nvertices 8\nmodes 1\nmode 2 0 3  3 0 0\n";
    for (int i = 0; i < 8; ++i) file += "1 0 0\n";
    folder.write("hand.txt", file);
    Scene scene(R"("box": { "type": "Primitive@1" },
        "modes": { "type": "ReadModes@1", "inputs": { "mesh": "box.mesh" },
                   "params": { "path": "hand.txt" } },
        "play": { "type": "Vibrate@1", "inputs": { "model": "modes.model" }, "params": {
                  "kicks": [{ "position": [0, 0, 0], "radius": 2, "impulse": [6, 0, 0] }] } },
        "far": { "type": "Measure@1", "inputs": { "mesh": "play.mesh", "rest": "box.mesh" } })",
                folder.path);
    EXPECT_NEAR(*scene.at<double>("far", 4), 2 / (4 * std::numbers::pi), 1e-6);
    EXPECT_NEAR(*scene.at<double>("far", 7), 0, 1e-6);
}

TEST(ModesFiles, WrongFilesAreToldWithTheirLine)
{
    const files::Folder folder;
    const auto told = [&](const std::string& bytes) {
        folder.write("m.txt", bytes);
        return Scene(R"("box": { "type": "Primitive@1" },
            "modes": { "type": "ReadModes@1", "inputs": { "mesh": "box.mesh" },
                       "params": { "path": "m.txt" } })",
                     folder.path)
            .failure_at<physics::ModalModel>("modes");
    };
    const auto says = [&](const std::string& bytes, const std::string& what) {
        const std::string text = told(bytes);
        EXPECT_NE(text.find(what), std::string::npos) << text;
    };
    says("modes", "line 1: expected aspic-modes, found \"modes\"");
    says("aspic-modes 1\nvertices 7\n",
         "expected modes of the 8 vertices of the mesh, found modes of 7");
    says("aspic-modes 1\nvertices 8\nmodes 1\nmode x",
         "line 4: expected a frequency of 0 or more, found \"x\"");
    says("aspic-modes 1\nvertices 8\nmodes 2\nmode 1 0 0 0 0 0", "expected a modal mass above 0");
    says("aspic-modes 1\nvertices 8\nmodes 1\nmode 1 0 1 0 0 0\n1 0 0\n", "found the end");
}

}  // namespace
