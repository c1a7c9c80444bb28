// What every cook would fail at is told when the document is read: validate says it, and cook
// doesn't begin.

#include "graph/document/document.hpp"
#include "nodes/registry.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

// The problems of these nodes, one a line, without their places.
std::string told(const std::string& nodes, const graph::LoadOptions& options = {})
{
    const std::string text =
        R"({ "aspic": 1, "frames": { "last": 24 }, "nodes": {
        "ball": { "type": "Primitive@1" }, )" +
        nodes + " } }";
    std::string out;
    for (const auto& problem :
         graph::load_text(text, "/tmp/told_before.json", nodes::registry(), options).problems) {
        const std::string line = graph::describe(problem);
        out += line.substr(std::min(line.find(": error: ") + 9, line.size())) + "\n";
    }
    return out;
}

std::string writer(const std::string& type, const std::string& params)
{
    const std::string of = type == "WriteMesh" ? R"("mesh": "ball.mesh")" : R"("image": "r.image")";
    const std::string drawn =
        type == "WriteMesh" ? "" : R"("r": { "type": "Render@2", "inputs": { "mesh": "ball" } }, )";
    return drawn +
           fmt::format(R"("w": {{ "type": "{}@1", "inputs": {{ {} }}, "params": {{ {} }} }})", type,
                       of, params);
}

TEST(ToldBefore, BodiesBeyondThoseThatAreLinked)
{
    EXPECT_EQ(
        told(
            R"("c": { "type": "Voxelize@1", "inputs": { "mesh": "ball" }, "params": { "method": "surface" } },
        "s": { "type": "Simulate@3", "inputs": { "cubes": "c.cubes" },
               "params": { "bodies": [{}, {}] } })"),
        "node 's', parameter 'bodies': `bodies` has 2 entries for 1 links of `cubes`: remove "
        "those beyond, as entry i is about link i\n");
}

TEST(ToldBefore, ARangeOfColoursThatRunsDown)
{
    const auto render = [](const std::string& range) {
        return told(fmt::format(R"("r": {{ "type": "Render@2", "inputs": {{ "mesh": "ball" }},
            "params": {{ "colour": {{ "by": "attribute", "attribute": "heat", {} }} }} }})",
                                range));
    };
    EXPECT_EQ(render(R"("range": "fixed", "low": 20, "high": 5)"),
              "node 'r', parameter 'colour.low': a `fixed` range runs from `low` up to `high`, "
              "found 20 and 5: set `high` above `low`\n");
    EXPECT_EQ(render(R"("range": "fixed", "low": 5, "high": 20)"), "");
    EXPECT_EQ(render(R"("range": "fixed", "low": 5, "high": "=20 + frame")"), "");
}

// A soft ball that a simulation moves, drawn as `render` says.
std::string falling_ball(const std::string& links, const std::string& sim,
                         const std::string& render)
{
    return fmt::format(R"(
    "floor": {{ "type": "Ground@1" }},
    "c": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "ball" }},
            "params": {{ "method": "solid", "size": 0.2 }} }},
    "s": {{ "type": "Simulate@3", "inputs": {{ "cubes": "c.cubes" {} }}, "params": {{ {} }} }},
    "e": {{ "type": "Embed@3", "inputs": {{ "mesh": "ball", "cubes": "c", "state": "s" }} }},
    "r": {{ "type": "Render@2", "inputs": {{ "mesh": "e.mesh" {} }})",
                       links, sim, render) +
           " }";
}

TEST(ToldBefore, AFloorOnWhichNothingLands)
{
    constexpr const char* at = R"(, "rest": "ball" }, "params": { "ground": { "kind": "at" } )";
    const std::string text = told(falling_ball("", "", at));
    EXPECT_NE(text.find("a floor is drawn, on which nothing lands: 's' has gravity"), text.npos)
        << text;
    EXPECT_EQ(told(falling_ball(R"(, "colliders": "floor")", "", at)), "");
    EXPECT_EQ(told(falling_ball("", R"("gravity": [0, 0, 0])", at)), "");
    EXPECT_EQ(told(falling_ball("", "", R"(, "rest": "ball" )")), "") << "under what is drawn";
}

TEST(ToldBefore, ACameraThatFollowsWhatASimulationMoves)
{
    const auto render = [](const std::string& links, const std::string& camera) {
        return told(falling_ball(
            "", "", links + R"( }, "params": { "camera": { "kind": ")" + camera + R"(" } )"));
    };
    for (const char* kind : {"turntable", "fit"}) {
        const std::string text = render("", kind);
        EXPECT_NE(text.find("scale changes as 's' moves that"), text.npos) << text;
        EXPECT_NE(text.find("MotionBounds to 'shot'"), text.npos) << text;
        EXPECT_EQ(render(R"(, "rest": "ball")", kind), "");
    }
    // The camera stands, and the floor falls with what lies over it.
    const std::string falls = render("", "look_at");
    EXPECT_NE(falls.find("the floor lies under what is drawn at each frame"), falls.npos) << falls;
    EXPECT_EQ(render(R"(, "rest": "ball")", "look_at"), "");
    EXPECT_EQ(render(R"(, "colliders": "floor")", "look_at"), "");
    EXPECT_EQ(told(falling_ball("", "", R"( }, "params": { "camera": { "kind": "look_at" },
                                           "ground": { "kind": "none" } )")),
              "");
    // What nothing moves, and a single picture.
    EXPECT_EQ(told(R"("r": { "type": "Render@2", "inputs": { "mesh": "ball" } })"), "");
    graph::LoadOptions one;
    one.written_frames = 1;
    EXPECT_EQ(told(falling_ball("", "", ""), one), "");
}

TEST(ToldBefore, PathsOfFilesToWrite)
{
    const std::string where = "node 'w', parameter 'path': ";
    EXPECT_EQ(told(writer("WriteImage", R"("path": "a.####.jpg")")),
              where + "expected a path that ends in .png or .exr, found a.####.jpg\n");
    EXPECT_EQ(told(writer("ContactSheet", R"("path": "sheet.txt")")),
              where + "expected a path that ends in .png, found sheet.txt\n");
    EXPECT_EQ(told(writer("WriteMesh", R"("path": "a.####.abc")")),
              where + "expected a path that ends in .obj or .ply or .stl or .glb or .gltf or .dae "
                      "or .fbx or .x3d, found a.####.abc\n");
    EXPECT_EQ(told(writer("WriteMesh", R"("path": "")")),
              where + "expected the path of a file, found \"\"\n");
    EXPECT_EQ(told(writer("WriteImage", R"("path": "frames/")")),
              where + "expected the path of a file, found \"frames/\"\n");
    EXPECT_NE(told(writer("WriteMesh", R"("path": "a.####.pc2")")).find("a path without #"),
              std::string::npos);
    EXPECT_EQ(told(R"("w": { "type": "ReadMesh@1" })"),
              where + "expected the path of a mesh file, found none\n");
    EXPECT_EQ(told(writer("WriteImage", R"("path": "A.####.PNG")")), "");
    EXPECT_EQ(told(writer("WriteMesh", R"("path": "a.####.abc", "format": "ply")")), "");
    EXPECT_EQ(told(writer("WriteMesh", R"("path": "a.pc2")")), "");
}

TEST(ToldBefore, PicturesWithoutTheLightThatAnExrHolds)
{
    const auto written = [](const std::string& linear, const std::string& path) {
        return R"("r": { "type": "Render@2", "inputs": { "mesh": "ball" }, "params": { "linear": ")" +
               linear + R"(" } }, "w": { "type": "WriteImage@1", "inputs": { "image": "r" }, )" +
               R"("params": { "path": ")" + path + R"(" } })";
    };
    const std::string why = "node 'w', parameter 'path': an .exr file holds linear light, and the "
                            "picture of '";
    EXPECT_EQ(told(written("none", "A.####.EXR")),
              why + "r' has none: set its 'linear' to whole or cut_out, or end the path in .png\n");
    EXPECT_EQ(told(written("none", "a.####.png")), "");
    EXPECT_EQ(told(written("whole", "a.####.exr")), "");
    EXPECT_EQ(told(written("cut_out", "A.####.EXR")), "");
    EXPECT_EQ(told(R"("r": { "type": "Render@2", "inputs": { "mesh": "ball" } },
                      "s": { "type": "ContactSheet@1", "inputs": { "image": "r" } },
                      "w": { "type": "WriteImage@1", "inputs": { "image": "s.image" },
                             "params": { "path": "a.####.exr" } })"),
              why + "s' has none: end the path in .png\n");
    EXPECT_EQ(told(written("whole", "a.####.exr") +
                   R"(, "v": { "type": "WriteVideo@1", "inputs": { "frames": "w" } })"),
              "node 'v', input 'frames': a video takes PNG files, and 'w' writes EXR: link a "
              "WriteImage whose path ends in .png\n");
}

// A mistake in a node, or in its type, is told once: not again at each node that is linked to it.
TEST(ToldBefore, NothingMoreOfNodesThatAreLinkedToAWrongOne)
{
    EXPECT_EQ(told(R"("r": { "type": "Render@2", "inputs": { "mesh": "ball" },
                             "params": { "linear": "cutout" } },
                      "w": { "type": "WriteImage@1", "inputs": { "image": "r.image" },
                             "params": { "path": "a.####.exr" } })"),
              "node 'r', parameter 'linear': expected one of 'none', 'whole' and 'cut_out', found "
              "\"cutout\"; did you mean 'cut_out'?\n");
    EXPECT_EQ(told(R"("b": { "type": "Sphere@1" },
                      "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "b.mesh" },
                                 "params": { "method": "solid" } })"),
              "node 'b': unknown node type 'Sphere'; use 'Primitive'\n");
    EXPECT_NE(told(R"("cubes": { "type": "Voxelize@1", "params": { "method": "solid" } })"), "");
}

TEST(ToldBefore, OneFileForSeveralFrames)
{
    const std::string one = writer("WriteMesh", R"("path": "a.obj")");
    EXPECT_EQ(told(one), "node 'w', parameter 'path': a.obj is a single file, but this cook writes "
                         "24 frames; use a.####.obj for one file per frame, or cook one frame "
                         "(--frames N)\n");
    graph::LoadOptions frame_by_frame;
    frame_by_frame.written_frames = 1;
    EXPECT_EQ(told(one, frame_by_frame), "");
}

TEST(ToldBefore, TwoNodesThatWriteOneFile)
{
    const std::string two = R"(
        "a": { "type": "WriteMesh@1", "inputs": { "mesh": "ball" }, "params": { "path": "x.##.obj" } },
        "b": { "type": "WriteMesh@1", "inputs": { "mesh": "ball" }, "params": { "path": "y/../x.##.obj" } })";
    EXPECT_EQ(told(two), "node 'b', parameter 'path': node 'a' writes x.##.obj too: give each node "
                         "a path of its own\n");
    graph::LoadOptions options;
    options.reserved = "manifest.json";
    EXPECT_EQ(
        told(writer("WriteMesh", R"("path": "./manifest.json", "format": "pc2")"), options),
        "node 'w', parameter 'path': manifest.json is written by the cook itself: use another "
        "path\n");
}

TEST(ToldBefore, InputsThatAChoiceNeeds)
{
    const std::string cubes = R"("cubes": { "type": "Voxelize@1", "inputs": { "mesh": "ball" },
                                 "params": { "method": "solid" } }, )";
    const auto needs = [](const std::string& text, const std::string& input) {
        return text.find("needs the input '" + input + "'") != std::string::npos &&
               text.find('\n') == text.size() - 1;
    };
    EXPECT_TRUE(
        needs(told(R"("c": { "type": "Voxelize@1", "inputs": { "mesh": "ball" } })"), "points"));
    EXPECT_TRUE(
        needs(told(R"("c": { "type": "Voxelize@1", "params": { "method": "surface" } })"), "mesh"));
    EXPECT_TRUE(
        needs(told(R"("c": { "type": "Collider@1", "params": { "kind": "mesh" } })"), "mesh"));
    EXPECT_TRUE(needs(told(cubes + R"("c": { "type": "Pin@1", "inputs": { "cubes": "cubes" },
                                   "params": { "where": "material" } })"),
                      "mesh"));
    EXPECT_TRUE(
        needs(told(R"("c": { "type": "Plane@1", "params": { "outline": "mesh" } })"), "mesh"));
    EXPECT_TRUE(
        needs(told(R"("c": { "type": "Measure@1", "inputs": { "mesh": "ball" } })"), "rest"));
    EXPECT_TRUE(needs(told(R"("c": { "type": "Skeletons@1",
                           "params": { "skeletons": [{ "kind": "mesh" }] } })"),
                      "mesh"));
    EXPECT_EQ(
        told(R"("c": { "type": "Render@2" })"),
        "node 'c': there is nothing to draw: link a mesh, layers, cubes, points, pins, forces "
        "or colliders\n");
    EXPECT_EQ(told(cubes + R"("b": { "type": "Ball@1" },
                   "sim": { "type": "Simulate@3",
                            "inputs": { "cubes": "cubes", "balls": ["b.ball"] } })"),
              "node 'sim', input 'balls': rigid balls need method = lattice: change the method, or "
              "unlink the input 'balls'\n");
}

}  // namespace
