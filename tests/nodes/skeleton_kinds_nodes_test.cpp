// Skeletons of every kind through a graph, to the mesh of the surface.

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"
#include "tests/nodes/scene.hpp"

#include <cmath>
#include <numbers>

namespace {

constexpr double pi = std::numbers::pi;

std::string nodes_of(const std::string& skeleton)
{
    return R"("sheet": { "type": "Primitive@1", "params": { "shape": "grid", "grid": { "size_x": 1, "size_z": 0.5 } } },
        "skeletons": { "type": "Skeletons@1", "inputs": { "mesh": "sheet.mesh" }, "params": {
            "skeletons": [ {)" +
           skeleton +
           R"(, "contribution": { "thickness": 0.1, "stiffness": 10, "radius": 0.3 } } ] } },
        "layer": { "type": "ImplicitLayer@3", "inputs": { "layer": "skeletons.layer" },
            "params": { "base": "still", "seed_spacing": 0.05 } },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["layer.part"] } },
        "mesh": { "type": "Polygonize@2", "inputs": { "scene": "bodies.scene" },
            "params": { "cell": 0.02 } })";
}

double volume_of(const std::string& skeleton, std::vector<std::string>& warnings)
{
    fixtures::Scene scene(nodes_of(skeleton));
    const double volume = geometry::enclosed_volume(*scene.at<geometry::TriMesh>("mesh"));
    warnings = scene.warnings;
    return volume;
}

}  // namespace

TEST(SkeletonKindsNodes, MeshesHaveTheVolumeOfTheOffset)
{
    const double e = 0.1, a = 0.3, h = 1;
    const std::vector<std::pair<std::string, double>> cases{
        {R"("kind": "torus", "size": [1.2, 0.3, 1])", 2 * pi * pi * 0.45 * 0.0625},
        {R"("kind": "cylinder", "size": [0.6, 1, 1], "rotate_degrees": [20, 0, 50])",
         pi * a * a * h + 2 * pi * a * (a + h) * e + pi * (h + pi * a) * e * e +
             4 * pi / 3 * e * e * e},
        {R"("kind": "curve", "points": [{ "at": [0, 0, 0] }, { "at": [1, 0, 0] }])",
         pi * e * e + 4 * pi / 3 * e * e * e},
        {R"("kind": "point", "stretch": [1, 3, 2], "stretch_degrees": [20, 0, 50])",
         6 * 4 * pi / 3 * e * e * e},
        {R"("kind": "segment", "points": [{ "at": [0, 0, 0] }, { "at": [1, 0, 0] }],
            "stretch": [1, 2, 1])",
         2 * (pi * e * e + 4 * pi / 3 * e * e * e)},
        {R"("kind": "sheet", "position": [0, 1, 0])",
         2 * e * 0.5 + pi / 2 * e * e * 3 + 4 * pi / 3 * e * e * e},
    };
    for (const auto& [skeleton, volume] : cases) {
        std::vector<std::string> warnings;
        EXPECT_NEAR(volume_of(skeleton, warnings), volume, 0.02 * volume) << skeleton;
        EXPECT_TRUE(warnings.empty()) << skeleton;
    }
    std::vector<std::string> warnings;
    EXPECT_GT(volume_of(R"("kind": "cone", "size": [0.6, 1, 0])", warnings), pi * a * a * h / 3);
}

TEST(SkeletonKindsNodes, AnOpenMeshAsASolidIsWarnedOf)
{
    std::vector<std::string> warnings;
    volume_of(R"("kind": "mesh")", warnings);
    ASSERT_FALSE(warnings.empty());
    EXPECT_NE(warnings[0].find("kind = sheet"), std::string::npos) << warnings[0];
}
