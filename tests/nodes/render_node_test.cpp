// What Render says of a picture that can show nothing.

#include "geometry/mesh/primitive.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

namespace {

using fixtures::NodeRun;
using geometry::Vec3f;

TEST(RenderNode, WarnsOfAnEmptyPicture)
{
    const geometry::TriMesh rest = geometry::grid(1, 1, 2, 2);
    const auto warnings = [&](const Vec3f& moved, const char* camera) {
        geometry::TriMesh mesh = rest;
        for (Vec3f& p : mesh.positions) p += moved;
        NodeRun render("Render");
        render.inputs["rest"] = {graph::Value::of(geometry::TriMesh(rest))};
        render.inputs["mesh"] = {graph::Value::of(std::move(mesh))};
        render.param("width").is = std::int64_t{32};
        render.param("height").is = std::int64_t{32};
        render.param("camera.kind").is = std::string(camera);
        render.param("camera.eye").is = std::array<double, 3>{0, 0, 9};
        render.param("camera.target").is = std::array<double, 3>{0, 0, 0};
        render.run();
        return render.warnings;
    };
    for (const char* camera : {"fit", "look_at"}) {
        EXPECT_TRUE(warnings({0, 0, 0}, camera).empty()) << camera;
        const auto gone = warnings({0, -40, 0}, camera);
        ASSERT_EQ(gone.size(), 1u) << camera;
        EXPECT_NE(gone[0].find("nothing that is linked lies in the picture"), std::string::npos);
    }
    EXPECT_NE(warnings({0, -40, 0}, "look_at")[0].find("camera.target"), std::string::npos);
}

}  // namespace
