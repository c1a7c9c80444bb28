// Layered scenes written to files and read back: what stands in for Layered.

#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

namespace {

using fixtures::Scene;

const std::string camera = R"("params": { "width": 32, "height": 24, "quality": "draft" })";

// Two soft balls, one on the other, that bulge and keep their volumes, on the ground.
const std::string live = R"(
    "one": { "type": "Skeletons@1", "params": { "skeletons": [
      { "kind": "point", "position": [0, 0.11, 0],
        "contribution": { "thickness": 0.1, "stiffness": 10, "radius": 0.25 } } ] } },
    "low": { "type": "ImplicitLayer@3", "inputs": { "layer": "one.layer" },
      "params": { "seed_spacing": 0.06, "volume": { "proportional": 10 },
                  "colour": [0.8, 0.2, 0.1],
                  "matter": { "bulge_width": 0.04, "bulge_height": 0.5 } } },
    "high": { "type": "ImplicitLayer@3", "inputs": { "layer": "one.layer" },
      "params": { "seed_spacing": 0.06, "translate": [0.05, 0.17, 0],
                  "matter": { "bulge_width": 0.04, "bulge_height": 0.5 } } },
    "hard": { "type": "Ground@1", "params": { "height": 0 } },
    "motion": { "type": "Layered@1",
      "inputs": { "parts": ["low.part", "high.part"], "colliders": ["hard.collider"] } },
    "out": { "type": "WriteScene@1", "inputs": { "scene": "motion.scene" },
             "params": { "path": "balls.####.layers" } },
    "picture": { "type": "Render@2", "inputs": { "layers": "motion.scene" }, )" +
                         camera + "}";

std::string read_back(const std::string& path)
{
    return fmt::format(R"("motion": {{ "type": "ReadScene@1", "params": {{ "path": "{}" }} }},
        "cubes": {{ "type": "Carried@1", "inputs": {{ "scene": "motion.scene" }} }},
        "picture": {{ "type": "Render@2", "inputs": {{ "layers": "motion.scene" }}, {} }})",
                       path, camera);
}

TEST(SceneFiles, PicturesAreThoseOfTheLiveCook)
{
    const files::Folder folder;
    Scene there(live, folder.path);
    there.at<graph::WrittenFile>("out", 2);
    Scene back(read_back("balls.####.layers"), folder.path);
    const auto want = there.at<render::Image>("picture", 2);
    EXPECT_EQ(back.at<render::Image>("picture", 2)->rgba, want->rgba);
    const std::size_t middle = std::size_t{4} * (12 * 32 + 16);
    EXPECT_NE(want->rgba.at(middle), want->rgba.at(0)) << "balls before the backdrop";
    std::size_t bodies = 0;
    for (const auto& file : std::filesystem::directory_iterator(folder.path / "balls.bodies")) {
        bodies += file.path().extension() == ".body" ? 1 : 0;
    }
    EXPECT_EQ(bodies, 2u) << "both balls are of one kind";
}

TEST(SceneFiles, WhatIsMissingOrForeignIsTold)
{
    const files::Folder folder;
    Scene(live, folder.path).at<graph::WrittenFile>("out", 1);
    Scene back(read_back("balls.####.layers"), folder.path);
    EXPECT_NE(back.failure_at<physics::State>("cubes").find("link the scene of Layered"),
              std::string::npos);
    folder.write("other.layers", "o cube\nv 0 0 0\n");
    EXPECT_NE(Scene(read_back("other.layers"), folder.path)
                  .failure_at<physics::LayeredScene>("motion")
                  .find("other.layers: expected a file that begins with \"aspic-scene 1\", found "
                        "\"o cube.v 0 0 0.\""),
              std::string::npos);
    std::filesystem::remove_all(folder.path / "balls.bodies");
    EXPECT_NE(Scene(read_back("balls.####.layers"), folder.path)
                  .failure_at<physics::LayeredScene>("motion")
                  .find("copy the folder of bodies together with the frames"),
              std::string::npos);
}

}  // namespace
