// What bodies of several closed parts weigh, as solids and as samples of their volume.

#include "geometry/cubes/samples.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

namespace {

using fixtures::Scene;

// Two boxes, the second of 3000 kg/m^3, and what they weigh as cubes and as samples in cubes.
std::string two_boxes(const std::string& first, const std::string& second, double size)
{
    const std::string matter = R"("matter": { "density": 1000 }, "materials": [
        { "match": "colour", "colour": [1, 0, 0], "tolerance": 0.1, "density": 3000 } ])";
    return fmt::format(R"(
        "a": {{ "type": "Primitive@1", "params": {{ "shape": "box", "colour": [0, 1, 0], {} }} }},
        "b": {{ "type": "Primitive@1", "params": {{ "shape": "box", "colour": [1, 0, 0], {} }} }},
        "both": {{ "type": "Merge@1", "inputs": {{ "meshes": ["a.mesh", "b.mesh"] }} }},
        "solid": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "both.mesh" }},
                    "params": {{ "method": "solid", "size": {}, {} }} }},
        "points": {{ "type": "Sample@2", "inputs": {{ "mesh": "both.mesh" }},
                     "params": {{ "where": "volume", "count": 40000, {} }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "points": "points.points" }},
                    "params": {{ "method": "samples", "size": 0.1 }} }},
        "as_solid": {{ "type": "Measure@1", "inputs": {{ "cubes": "solid.cubes" }},
                       "params": {{ "what": "mass" }} }},
        "as_samples": {{ "type": "Measure@1", "inputs": {{ "cubes": "cubes.cubes" }},
                         "params": {{ "what": "mass" }} }})",
                       first, second, size, matter, matter);
}

// 1000 (1 - 0.4^3) + 3000 0.4^3 kg.
TEST(MatterByPart, ABoneInFleshWeighsWhatItShould)
{
    for (const double size : {0.1, 0.07}) {
        Scene scene(two_boxes(R"("box": { "size": [1, 1, 1] })",
                              R"("box": { "size": [0.4, 0.4, 0.4] })", size));
        EXPECT_NEAR(*scene.at<double>("as_solid"), 1128, size == 0.1 ? 1e-3 : 0.02 * 1128);
        EXPECT_NEAR(*scene.at<double>("as_samples"), 1128, 0.005 * 1128);
    }
}

// Each sample has the matter of the box that it lies in, however near it is to the other.
TEST(MatterByPart, BoxesThatTouchWeighWhatTheyShould)
{
    Scene scene(two_boxes(R"("box": { "size": [0.5, 1, 1] }, "centre": [0.25, 0.5, 0.5])",
                          R"("box": { "size": [0.5, 1, 1] }, "centre": [0.75, 0.5, 0.5])", 0.11));
    EXPECT_NEAR(*scene.at<double>("as_solid"), 2000, 0.005 * 2000);
    EXPECT_NEAR(*scene.at<double>("as_samples"), 2000, 0.005 * 2000);
    const auto points = scene.at<geometry::Samples>("points");
    for (std::size_t i = 0; i < points->positions.size(); ++i) {
        const float x = points->positions[i].x();
        if (std::abs(x - 0.5f) < 1e-4f) continue;
        EXPECT_EQ(points->matters[points->matter[i]].density, x < 0.5f ? 1000 : 3000) << x;
    }
}

TEST(MatterByPart, ARuleThatMatchesNothingIsNamedByWhatItLooksFor)
{
    Scene scene(R"(
        "a": { "type": "Primitive@1", "params": { "shape": "box", "colour": [0, 1, 0] } },
        "c": { "type": "Voxelize@1", "inputs": { "mesh": "a" },
               "params": { "method": "solid", "materials": [
            { "match": "colour", "colour": [1, 0, 0.25], "tolerance": 0.2, "density": 3000 },
            { "match": "material", "name": "ir*", "density": 3000 } ] } })");
    scene.at<geometry::Cubes>("c");
    ASSERT_EQ(scene.warnings.size(), 2u);
    EXPECT_EQ(scene.warnings[0],
              "materials[0] (colour [1, 0, 0.25], tolerance 0.2) matches no face of the mesh");
    EXPECT_EQ(scene.warnings[1], "materials[1] (\"ir*\") matches no face of the mesh");
}

}  // namespace
