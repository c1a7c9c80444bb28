// Bad input from end to end: a file through ReadMesh, Sample, Voxelize, ConnectedComponent, Pin,
// Simulate and Embed gives a clear error or a sane result, never a crash or a frame that is not
// finite.

#include "geometry/mesh/measure.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;
using geometry::Vec3;
using graph::Value;

enum class Pinned { none, low_end, all };
enum class By { samples, surface, solid };

struct Outcome {
    std::string error;       // of the first node that refused; empty when all ran
    std::string refused_by;  // its name
    TriMesh rest, moved;     // the mesh at rest, and after three frames
    Vec3 fallen{0, 0, 0};    // of the first corner of the cubes
};

struct Read {
    Value mesh;         // none when ReadMesh refused the file
    std::string error;  // why
};

Read read(const files::fs::path& path)
{
    NodeRun node("ReadMesh");
    node.param("path").is = path.string();
    try {
        return {node.run(), ""};
    } catch (const std::exception& error) {
        return {{}, error.what()};
    }
}

struct Chain {
    Pinned pinned = Pinned::none;
    By by = By::samples;
    std::string at;  // the node that is running

    // Runs one node and returns its first output.
    Value run(NodeRun& node, int frame = 1)
    {
        at = node.type.name;
        return node.run(frame);
    }

    Outcome operator()(const Value& mesh)
    {
        Outcome out;
        try {
            simulate(mesh, cubes_of(mesh), out);
        } catch (const std::exception& error) {
            out.error = error.what();
            out.refused_by = at;
        }
        return out;
    }
    Outcome operator()(const files::fs::path& path)
    {
        const auto [mesh, error] = read(path);
        return mesh ? (*this)(mesh) : Outcome{error, "ReadMesh", {}, {}};
    }

    Value cubes_of(const Value& mesh)
    {
        NodeRun voxelize("Voxelize");
        voxelize.param("resolution").is = std::int64_t(6);
        if (by == By::samples) {
            NodeRun sample("Sample");
            sample.inputs["mesh"] = {mesh};
            sample.param("count").is = std::int64_t(2000);
            voxelize.inputs["points"] = {run(sample)};
        } else {
            voxelize.inputs["mesh"] = {mesh};
            voxelize.param("method").is = std::string(by == By::solid ? "solid" : "surface");
        }
        NodeRun component("ConnectedComponent");
        component.inputs["cubes"] = {run(voxelize)};
        component.param("keep").is = std::string("largest");
        return run(component);
    }

    void simulate(const Value& mesh, const Value& cubes, Outcome& out)
    {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {cubes};
        if (pinned != Pinned::none) {
            NodeRun pin("Pin");
            pin.inputs["cubes"] = {cubes};
            pin.param("where").is = std::string(pinned == Pinned::all ? "below" : "ends");
            if (pinned == Pinned::all) pin.param("below.height").is = 1e30;
            simulate.inputs["pins"] = {run(pin)};
        }
        Value state;
        for (int frame = 1; frame <= 3; ++frame) {
            simulate.previous = {state};
            state = run(simulate, frame);
        }
        NodeRun embed("Embed");
        embed.inputs = {{"mesh", {mesh}}, {"cubes", {cubes}}, {"state", {state}}};
        out.rest = *mesh.as<TriMesh>();
        out.moved = *run(embed).as<TriMesh>();
        const auto& x = state.as<physics::State>()->x;
        const auto rest = geometry::corner_positions(*cubes.as<geometry::Cubes>());
        if (!x.empty()) out.fallen = x[0] - rest[0];
    }
};

// An error that tells, or a mesh of as many vertices whose every number is finite.
void expect_clear_or_sane(const Outcome& out)
{
    if (!out.error.empty()) {
        EXPECT_GT(out.error.size(), 20u) << out.error;
        EXPECT_EQ(out.error.find("bad_alloc"), std::string::npos) << out.error;
        return;
    }
    EXPECT_EQ(out.moved.positions.size(), out.rest.positions.size());
    EXPECT_TRUE(geometry::all_finite(out.moved));
}

void expect_clear_or_sane_by_all_routes(const files::fs::path& path)
{
    const auto [mesh, error] = read(path);
    if (!mesh) return expect_clear_or_sane({error, "ReadMesh", {}, {}});
    for (const By by : {By::samples, By::surface, By::solid}) {
        for (const Pinned pinned : {Pinned::none, Pinned::low_end, Pinned::all}) {
            SCOPED_TRACE(testing::Message() << "route " << int(by) << ", pinned " << int(pinned));
            Chain chain;
            chain.by = by;
            chain.pinned = pinned;
            expect_clear_or_sane(chain(mesh));
        }
    }
}

const std::string box = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                        "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

TEST(BadInput, ReadMeshRefusesFilesWithoutAMesh)
{
    const files::Folder folder;
    const std::map<std::string, std::string> all{
        {"empty.obj", ""},
        {"comment.obj", "# nothing\n"},
        {"cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"},
        {"cut.stl", "solid"},
        {"cut.glb", "glTF"},
        {"nan.obj", "v nan nan nan\nv nan 0 0\nv 0 nan 0\nf 1 2 3\n"},
        {"range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"},
        {"twice.obj", "v 0 0 0\nv 1 0 0\nf 1 1 2\n"},
    };
    Chain chain;
    for (const auto& [name, text] : all) {
        const Outcome out = chain(folder.write(name, text));
        EXPECT_EQ(out.refused_by, "ReadMesh") << name;
        EXPECT_NE(out.error.find(name), std::string::npos) << out.error;
        expect_clear_or_sane(out);
    }
    EXPECT_NE(chain(folder.path / "missing.obj").error.find("no file"), std::string::npos);
}

TEST(BadInput, DegenerateFacesASingleTriangleAndPoints)
{
    const files::Folder folder;
    for (const char* text : {
             "v 0 0 0\nv 1 0 0\nv 0.5 0 0\nf 1 2 3\n",        // no area
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",          // one triangle
             "v 1 2 3\n",                                     // one point
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n",          // a few points
             "v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n",  // smaller than any cube
         }) {
        SCOPED_TRACE(text);
        expect_clear_or_sane_by_all_routes(folder.write("a.obj", text));
    }
}

TEST(BadInput, ASingleTriangleIsSimulated)
{
    const files::Folder folder;
    Chain chain;
    chain.by = By::surface;
    chain.pinned = Pinned::low_end;
    const Outcome out = chain(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    EXPECT_EQ(out.error, "");
    EXPECT_TRUE(geometry::all_finite(out.moved));
}

TEST(BadInput, NonFiniteVerticesDropOnlyTheirFaces)
{
    const files::Folder folder;
    std::string text = box;
    text.replace(text.find("v 1 1 1"), 7, "v nan 1 1");
    Chain chain;
    const Outcome out = chain(folder.write("a.obj", text));
    EXPECT_EQ(out.error, "");
    EXPECT_TRUE(geometry::all_finite(out.moved));
    expect_clear_or_sane_by_all_routes(folder.path / "a.obj");
}

TEST(BadInput, AVertexFarFromAllOthersIsNamed)
{
    const files::Folder folder;
    const auto told = [&](const std::string& vertex) {
        std::string text = box;
        text.replace(text.find("v 1 1 1"), 7, vertex);
        NodeRun node("ReadMesh");
        node.param("path").is = folder.write("a.obj", text).string();
        node.run();
        std::string all;
        for (const auto& warning : node.warnings) all += warning + "\n";
        return all;
    };
    EXPECT_EQ(told("v 1 1 1"), "");
    EXPECT_EQ(told("v 900 1 1"), "");
    const std::string far = told("v 1e30 1 1");
    EXPECT_NE(far.find("is at (1e+30, 1, 1), 1e+30 m from the middle"), std::string::npos) << far;
}

TEST(BadInput, HugeAndTinyScales)
{
    const files::Folder folder;
    for (const char* scale : {"1e9", "1e-9", "1e30"}) {
        SCOPED_TRACE(scale);
        std::string text;
        for (const char c : box.substr(0, box.find('f'))) {
            text += c == '1' ? std::string(scale) : std::string(1, c);
        }
        expect_clear_or_sane_by_all_routes(folder.write("a.obj", text + box.substr(box.find('f'))));
    }
}

TEST(BadInput, AModelFarFromTheOrigin)
{
    const files::Folder folder;
    std::string text;
    for (const char* v : {"0 0 0", "1 0 0", "0 1 0", "0 0 1"}) {
        text += std::string("v 1000000") + v + "\n";  // x is a million metres off
    }
    expect_clear_or_sane_by_all_routes(
        folder.write("a.obj", text + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"));
}

TEST(BadInput, ABodyWithAllCornersPinnedStaysAtRest)
{
    const files::Folder folder;
    Chain chain;
    chain.pinned = Pinned::all;
    const Outcome out = chain(folder.write("a.obj", box));
    ASSERT_EQ(out.error, "");
    // Embedding adds the interpolated displacement, here zero but for rounding to floats.
    EXPECT_LT(geometry::displacement(out.moved, out.rest).largest, 1e-6);
}

TEST(BadInput, ABodyWithoutPinsFallsFreely)
{
    const files::Folder folder;
    Chain chain;
    const Outcome out = chain(folder.write("a.obj", box));
    ASSERT_EQ(out.error, "");
    // Two frames after the first: t = 1/12 s, -g t^2 / 2 = -0.034 m. Implicit steps overshoot by
    // up to the last one's share, so twice as far at most; and nothing pushes sideways.
    EXPECT_LT(out.fallen.y(), -0.034 * 0.9);
    EXPECT_GT(out.fallen.y(), -0.034 * 2);
    EXPECT_NEAR(out.fallen.x(), 0, 1e-6);
    EXPECT_NEAR(out.fallen.z(), 0, 1e-6);
}

TEST(BadInput, AnEmptySetOfCubes)
{
    const Value none = Value::of(geometry::Cubes{});
    NodeRun component("ConnectedComponent");
    component.inputs["cubes"] = {none};
    Value cubes = none;
    try {
        cubes = component.run();
    } catch (const std::exception& error) {
        EXPECT_GT(std::string(error.what()).size(), 20u) << error.what();
    }
    const files::Folder folder;
    const Value mesh = read(folder.write("a.obj", box)).mesh;
    for (const Pinned pinned : {Pinned::none, Pinned::low_end, Pinned::all}) {
        Chain chain;
        chain.pinned = pinned;
        Outcome out;
        try {
            chain.simulate(mesh, cubes, out);
        } catch (const std::exception& error) {
            out.error = error.what();
        }
        expect_clear_or_sane(out);
    }
}

TEST(BadInput, AnEmptyMeshOnAWire)
{
    const Value mesh = Value::of(TriMesh{});
    for (const By by : {By::samples, By::surface, By::solid}) {
        Chain chain;
        chain.by = by;
        const Outcome out = chain(mesh);
        EXPECT_NE(out.error, "");
        expect_clear_or_sane(out);
    }
}

TEST(BadInput, AScaleBeyondTheRangeOfCoordinatesIsRefused)
{
    NodeRun shape("Primitive"), move("Transform");
    move.inputs["mesh"] = {shape.run()};
    move.param("scale").is = std::array<double, 3>{1e300, 1, 1};
    try {
        move.run();
        FAIL() << "was moved to infinity";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("below 3.4e38 m"), std::string::npos)
            << error.what();
    }
    move.param("scale").is = std::array<double, 3>{1e30, 1, 1};
    EXPECT_TRUE(geometry::all_finite(*move.run().as<TriMesh>()));
}

TEST(BadInput, ANodeThatMakesAMeshOfInfinitePlacesFails)
{
    NodeRun shape("Primitive"), copies("Copies");
    copies.inputs["mesh"] = {shape.run()};
    copies.param("stagger").is = std::array<double, 3>{1e300, 0, 0};
    copies.param("count_y").is = std::int64_t{3};
    try {
        copies.run();
        FAIL() << "copies stand at infinity";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("is not finite: vertex"), std::string::npos)
            << error.what();
    }
}

TEST(BadInput, AModelTooFarAwayForItsCoordinatesIsNamed)
{
    // At 1e7 m floats are 1 m apart: both ends of the cube of 0.8 m become 1e7.
    NodeRun shape("Primitive"), move("Transform"), voxelize("Voxelize");
    move.inputs["mesh"] = {shape.run()};
    move.param("scale").is = std::array<double, 3>{0.8, 0.8, 0.8};
    move.param("translate").is = std::array<double, 3>{1e7, 1e7, 1e7};
    voxelize.inputs["mesh"] = {move.run()};
    voxelize.param("method").is = std::string("solid");
    try {
        voxelize.run();
        FAIL() << "was voxelized";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(
            std::string(error.what()).find("rounded to steps of 1.19 m: move it to the origin"),
            std::string::npos)
            << error.what();
    }
}

TEST(BadInput, APointCloudIsSampledAndVoxelized)
{
    TriMesh cloud;
    for (int i = 0; i < 4; ++i) cloud.positions.emplace_back(float(i) + 0.5f, 0.5f, 0.5f);
    cloud.positions.emplace_back(NAN, 0, 0);
    NodeRun sample("Sample"), voxelize("Voxelize");
    sample.inputs["mesh"] = {Value::of(TriMesh(cloud))};
    const Value points = sample.run();
    EXPECT_EQ(points.as<geometry::Samples>()->positions.size(), 4u);
    voxelize.inputs["points"] = {points};
    voxelize.param("size").is = 1.0;
    voxelize.param("align").is = std::string("origin");
    const auto cubes = voxelize.run().as<geometry::Cubes>();
    EXPECT_EQ(cubes->count(), 4u);
    // Full cubes of 1 m^3, of 1000 kg/m^3; or as heavy together as is said.
    EXPECT_NEAR(geometry::total_mass(*cubes), 4000, 1e-3);
    sample.param("mass").is = std::string("total");
    sample.param("total_mass").is = 7.0;
    voxelize.inputs["points"] = {sample.run()};
    const auto light = voxelize.run().as<geometry::Cubes>();
    EXPECT_NEAR(geometry::total_mass(*light), 7, 1e-5);
}

}  // namespace
