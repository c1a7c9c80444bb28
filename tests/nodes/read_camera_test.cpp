// Cameras of files: where they stand and look, how they move, and that Render sees by them. The
// files are binary glTF of these tests' own.

#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;
using render::Camera;

template <class T> void append(std::string& bytes, const T& value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string glb(std::string json, const std::string& binary)
{
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string file = "glTF";
    append(file, std::uint32_t{2});
    append(file, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
    append(file, static_cast<std::uint32_t>(json.size()));
    file += "JSON" + json;
    append(file, static_cast<std::uint32_t>(binary.size()));
    file += std::string("BIN\0", 4) + binary;
    return file;
}

// "shot" hangs at a node that goes from (1, 2, 3) to (5, 2, 3) m in a second, is turned by a
// quarter about y, so that it looks towards -x, and sees 0.5 rad high and 1.5 times as wide. "plan"
// looks down from 10 m, in parallel, 6 x 4 m.
std::string two_cameras()
{
    std::string binary;
    for (const float f : {0.0f, 1.0f, 1.0f, 2.0f, 3.0f, 5.0f, 2.0f, 3.0f}) append(binary, f);
    return glb(R"({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 2] }],
        "nodes": [
          { "name": "dolly", "translation": [1, 2, 3], "children": [1] },
          { "name": "shot", "camera": 0, "rotation": [0, 0.70710678, 0, 0.70710678] },
          { "name": "plan", "camera": 1, "translation": [0, 10, 0],
            "rotation": [-0.70710678, 0, 0, 0.70710678] }],
        "cameras": [
          { "type": "perspective", "perspective": { "yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1 } },
          { "type": "orthographic",
            "orthographic": { "xmag": 3, "ymag": 2, "znear": 0.1, "zfar": 100 } }],
        "animations": [{
          "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
          "samplers": [{ "input": 0, "output": 1, "interpolation": "LINEAR" }] }],
        "accessors": [
          { "bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR",
            "min": [0], "max": [1] },
          { "bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteOffset": 0, "byteLength": 8 },
                        { "buffer": 0, "byteOffset": 8, "byteLength": 24 }],
        "buffers": [{ "byteLength": 32 }] })",
               binary);
}

Camera camera_of(const files::Folder& folder, const std::string& name, int frame,
                 const std::string& unit = "auto")
{
    NodeRun read("ReadCamera");
    read.param("path").is = folder.write("cameras.glb", two_cameras()).string();
    read.param("name").is = name;
    read.param("unit").is = unit;
    return *read.run(frame).as<Camera>();
}

TEST(ReadCamera, StandsAndLooksAsTheFileSays)
{
    const files::Folder folder;
    const Camera shot = camera_of(folder, "", 1);
    // Single precision.
    EXPECT_LT((shot.eye - Vec3(1, 2, 3)).norm(), 1e-5);
    EXPECT_LT(((shot.target - shot.eye).normalized() - Vec3(-1, 0, 0)).norm(), 1e-5);
    EXPECT_LT((shot.up - Vec3(0, 1, 0)).norm(), 1e-5);
    EXPECT_NEAR(shot.field_of_view, 0.5, 1e-5);

    const Camera plan = camera_of(folder, "plan", 1);
    EXPECT_LT(((plan.target - plan.eye).normalized() - Vec3(0, -1, 0)).norm(), 1e-5);
    // It has gone back along its view, 2 km: single precision in its direction is left.
    EXPECT_LT(std::hypot(plan.eye.x(), plan.eye.z()), 1e-3);
    EXPECT_LT((plan.up - Vec3(0, 0, -1)).norm(), 1e-5);
    const double height = 2 * std::tan(plan.field_of_view / 2) * (plan.eye - plan.target).norm();
    EXPECT_NEAR(height, 4, 1e-4);
}

// A COLLADA file whose unit is half a metre, with a camera at its middle for each of `optics`:
// named c0, c1 and so on, and its node n0.
std::string collada_cameras(const std::vector<std::string>& optics)
{
    std::string cameras, nodes;
    for (std::size_t i = 0; i < optics.size(); ++i) {
        const std::string number = std::to_string(i);
        // COLLADA asks for no name.
        cameras += std::string(i % 2 ? "<camera" : "<camera name=\"a\"") + " id=\"c" + number +
                   "\"><optics><technique_common>\n" + optics[i] +
                   "</technique_common></optics></camera>\n";
        // The last comes first in the scene: the order tells nothing.
        nodes = "<node id=\"n" + number + "\" name=\"n" + number + "\"><instance_camera url=\"#c" +
                number + "\"/></node>\n" + nodes;
    }
    return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="u" meter="0.5"/><up_axis>Y_UP</up_axis></asset><library_cameras>
)" + cameras +
           "</library_cameras><library_visual_scenes><visual_scene id=\"s\">" + nodes +
           "</visual_scene></library_visual_scenes>"
           "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

std::string perspective(const std::string& says)
{
    return "<perspective>" + says + "<znear>0.1</znear><zfar>100</zfar></perspective>\n";
}

std::string orthographic(const std::string& says)
{
    return "<orthographic>" + says + "<znear>0.1</znear><zfar>100</zfar></orthographic>\n";
}

TEST(ReadCamera, SeesAsHighAsColladaSaysInAnyOfItsWays)
{
    // tan(31 degrees) is 1.5 times tan(21.83 degrees):
    // half the width and half the height of a picture 1.5 or, as Render's, 16 / 9 times as wide.
    const double half = std::atan(std::tan(31 * M_PI / 180) / 1.5) * 180 / M_PI;
    const double high = 2 * half * M_PI / 180;
    const double narrow = 2 * std::atan(std::tan(31 * M_PI / 180) * 9 / 16);
    const std::string x = "<xfov sid=\"x\">62</xfov>";
    const std::string y = "<yfov> " + std::to_string(2 * half) + " </yfov>";
    const std::string aspect = "<aspect_ratio>1.5</aspect_ratio>";
    const std::string wide = "<xmag>6</xmag>", tall = "<ymag>4</ymag>";
    const files::Folder folder;
    const std::string path =
        folder
            .write("cameras.dae", collada_cameras({
                                      perspective(x),
                                      perspective(x + aspect),
                                      perspective("<!-- <xfov>9</xfov> -->" + y),
                                      perspective(y + aspect),
                                      perspective(x + y),
                                      orthographic(wide),
                                      orthographic(wide + aspect),
                                      orthographic(tall),
                                      orthographic(tall + aspect),
                                      orthographic(wide + tall),
                                  }))
            .string();
    const auto read = [&](std::size_t i) {
        NodeRun node("ReadCamera");
        node.param("path").is = path;
        node.param("name").is = "n" + std::to_string(i);
        return *node.run().as<Camera>();
    };
    const std::vector<double> angles{narrow, high, high, high, high};
    // Single precision.
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(read(i).field_of_view, angles[i], 1e-6) << i;
    // Both magnifications are half a picture: 12 x 8 units of half a metre.
    const std::vector<double> heights{6 * 9 / 16.0, 4, 4, 4, 4};
    for (std::size_t i = 0; i < 5; ++i) {
        const Camera camera = read(5 + i);
        const double height =
            2 * std::tan(camera.field_of_view / 2) * (camera.eye - camera.target).norm();
        EXPECT_NEAR(height, heights[i], 1e-4) << i;
    }
}

TEST(ReadCamera, MovesWithItsNodesAndStandsAfterwards)
{
    const files::Folder folder;
    // 24 frames a second: frame 13 is at half a second.
    EXPECT_LT((camera_of(folder, "shot", 13).eye - Vec3(3, 2, 3)).norm(), 1e-4);
    EXPECT_LT((camera_of(folder, "shot", 7).eye - Vec3(2, 2, 3)).norm(), 1e-4);
    EXPECT_LT((camera_of(folder, "shot", 90).eye - Vec3(5, 2, 3)).norm(), 1e-4);
    EXPECT_LT((camera_of(folder, "shot", 13, "cm").eye - Vec3(0.03, 0.02, 0.03)).norm(), 1e-6);
}

TEST(ReadCamera, SaysWhatIsMissing)
{
    const files::Folder folder;
    const auto why = [&](const std::string& name, const std::string& file) {
        NodeRun read("ReadCamera");
        read.param("path").is = folder.write("a.glb", file).string();
        read.param("name").is = name;
        try {
            read.run();
        } catch (const std::runtime_error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(why("wide", two_cameras()).find("no camera \"wide\", but shot, plan"),
              std::string::npos)
        << why("wide", two_cameras());
    const std::string none = glb(
        R"({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
             "nodes": [{ "name": "empty" }] })",
        "");
    EXPECT_NE(why("", none).find("it has no camera"), std::string::npos) << why("", none);
    EXPECT_FALSE(why("", "glTF nonsense").empty());
    EXPECT_EQ(NodeRun("ReadCamera").type.check(NodeRun("ReadCamera").params, {}).size(), 1u);
}

// By the camera of a file as by one that looks from the same place in the same direction.
TEST(ReadCamera, IsWhatRenderSeesBy)
{
    geometry::TriMesh ball = geometry::icosphere(0.5, 3);
    for (auto& p : ball.positions) p += geometry::Vec3f(-4, 2.3f, 3);
    NodeRun render("Render");
    render.inputs["mesh"] = {graph::Value::of(std::move(ball))};
    render.param("width").is = std::int64_t{96};
    render.param("height").is = std::int64_t{64};
    render.param("camera.kind").is = std::string("look_at");
    render.param("camera.eye").is = std::array<double, 3>{1, 2, 3};
    render.param("camera.target").is = std::array<double, 3>{-4, 2, 3};
    render.param("camera.field_of_view").is = 0.5 * 180 / 3.141592653589793;
    const auto wanted = render.run().as<render::Image>()->rgba;
    const files::Folder folder;
    render.inputs["view"] = {graph::Value::of(camera_of(folder, "shot", 1))};
    render.param("camera.kind").is = std::string("fit");
    const auto seen = render.run().as<render::Image>()->rgba;
    // The file's numbers are of single precision: a few steps of a few pixels at edges.
    std::size_t off = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) off += std::abs(seen[i] - wanted[i]) > 2;
    EXPECT_LT(off, seen.size() / 200);
    EXPECT_TRUE(render.warnings.empty());
}

}  // namespace
