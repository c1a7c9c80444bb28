// Two closed pieces, one within the other, whose faces look out both: filled, or a hollow.

#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

namespace {

using fixtures::Scene;

// A ball of 0.5 m, a ball of 0.4 m within it, and a pressure on the inner one.
std::string balloon(const std::string& voxelize)
{
    return fmt::format(R"(
        "o": {{ "type": "Primitive@1", "params": {{ "shape": "sphere",
                "sphere": {{ "radius": 0.5, "subdivisions": 3 }}, "centre": [0, 0, 0] }} }},
        "inner": {{ "type": "Primitive@1", "params": {{ "shape": "sphere", "material": "inner",
                    "sphere": {{ "radius": 0.4, "subdivisions": 3 }} }} }},
        "m": {{ "type": "Merge@1", "inputs": {{ "meshes": ["o", "inner"] }} }},
        "c": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "m" }},
                "params": {{ "method": "solid", "size": 0.1, "matter": {{ "density": 100 }}{} }} }},
        "p": {{ "type": "Pressure@1", "inputs": {{ "cubes": "c", "mesh": "m" }},
                "params": {{ "part": "inner" }} }})",
                       voxelize);
}

// Of the surface that is pressed on, above 0 where it looks out of a ball.
double pressed_volume(Scene& scene)
{
    const auto cubes = scene.at<geometry::Cubes>("c");
    const auto force = scene.at<physics::Force>("p");
    const auto node = [&](std::uint32_t n) {
        geometry::Vec3 at = geometry::Vec3::Zero();
        for (std::size_t i = 0; i < 8; ++i) {
            at += force->surface->weight[n][i] *
                  cubes->corner_position(force->surface->corners[n][i]);
        }
        return at;
    };
    double volume = 0;
    for (const auto& f : force->surface->faces) {
        volume += node(f[0]).dot(node(f[1]).cross(node(f[2]))) / 6;
    }
    return volume;
}

TEST(FilledHollow, IsToldOfWithTheWayToAHollow)
{
    Scene scene(balloon(""));
    scene.at<geometry::Cubes>("c");
    ASSERT_EQ(scene.warnings.size(), 1u);
    for (const char* part :
         {"a closed piece of the mesh (of material \"inner\", 0.8 m across, about "
          "(0, 0, 0)) lies wholly within a larger one",
          "set inside = parity"}) {
        EXPECT_NE(scene.warnings[0].find(part), std::string::npos) << scene.warnings[0];
    }
    EXPECT_GT(pressed_volume(scene), 0) << "as filled";
}

// A bone in flesh is of another matter.
TEST(FilledHollow, IsNoneWhereThePieceIsMeant)
{
    Scene bone(balloon(R"(, "materials": [
        { "match": "material", "name": "inner", "density": 900 } ])"));
    bone.at<geometry::Cubes>("c");
    EXPECT_TRUE(bone.warnings.empty()) << bone.warnings[0];
}

// Pressure takes the hollow as the cubes have it, although its faces look out.
TEST(FilledHollow, IsAHollowByParity)
{
    Scene scene(balloon(R"(, "inside": "parity")"));
    double mass = 0;
    for (const double m : scene.at<geometry::Cubes>("c")->mass) mass += m;
    EXPECT_NEAR(mass, 25.5, 0.5);  // 100 kg/m^3 4/3 pi (0.5^3 - 0.4^3), less what facets cut off
    EXPECT_LT(pressed_volume(scene), -0.24);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
}

}  // namespace
