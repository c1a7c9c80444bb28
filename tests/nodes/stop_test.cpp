// A cook that is to end, by Ctrl-C, SIGTERM or --time-limit, does not wait for the node that runs:
// for each type of node a graph in which it has much to do, stopped at several moments.

#include "geometry/base/sanitizers.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <set>
#include <thread>

namespace {

using Clock = std::chrono::steady_clock;

// What is promised is 0.3 s. Twice as long here, once in four tries: memory is shared with other
// tests. Time is that of the cores that work on it where that is less, since other tests may make
// it wait for a core. Sanitizers slow down.
#if defined(ASPIC_ADDRESS_SANITIZER) || defined(ASPIC_THREAD_SANITIZER)
constexpr double soon = 60;  // s
#else
constexpr double soon = 0.6;  // s
#endif

// The node named "t" is stopped at `frame`. All others, and "t" at earlier frames, are cooked
// before.
struct Case {
    std::string name;  // the type of "t", and after '_' what it does
    std::string nodes;
    int frame = 1;
    std::string before = {};  // nodes of a graph that is cooked first, for the files that it writes

    friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

// ---- the graphs ---------------------------------------------------------------------------------

// An icosphere of 20 * 4^n faces.
std::string ball(int n, const std::string& name = "ball")
{
    return fmt::format(R"("{}": {{ "type": "Primitive@1", "params": {{ "shape": "sphere",
        "sphere": {{ "subdivisions": {} }} }} }})",
                       name, n);
}

std::string solid(const std::string& mesh, int resolution, const std::string& name = "v")
{
    return fmt::format(R"("{}": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "{}.mesh" }},
        "params": {{ "method": "solid", "resolution": {} }} }})",
                       name, mesh, resolution);
}

std::string node(const std::string& name, const std::string& type, const std::string& inputs,
                 const std::string& params = "")
{
    return fmt::format(R"("{}": {{ "type": "{}", "inputs": {{ {} }}, "params": {{ {} }} }})", name,
                       type, inputs, params);
}

std::string t(const std::string& type, const std::string& inputs, const std::string& params = "")
{
    return node("t", type, inputs, params);
}

const std::string of_ball = R"("mesh": "ball.mesh")";
const std::string of_cubes = R"("cubes": "v.cubes")";

const std::string two_points = R"("skeletons": [{ "kind": "point", "position": [0, 0, 0] },
    { "kind": "point", "position": [0.5, 0, 0] }])";

// Two points under a layer, as a Layered scene of the first frame.
std::string scene()
{
    return node("k", "Skeletons@1", "", two_points) + "," +
           node("l", "ImplicitLayer@3", R"("layer": "k.layer")", R"("base": "still")") + "," +
           node("s", "Layered@1", R"("parts": ["l.part"])");
}

std::string simulate(const std::string& params = "")
{
    return t("Simulate@3", of_cubes, params);
}

// A thin tilted plate in cubes of two thicknesses.
std::string tilted_plate()
{
    return node("b", "Primitive@1", "", R"("shape": "box", "box": { "size": [1, 1, 0.02] })") +
           "," +
           node("ball", "Transform@1", R"("mesh": "b.mesh")", R"("rotate_degrees": [20, 30, 0])");
}

std::string picture(int width)
{
    return ball(3) + "," +
           node("r", "Render@2", R"("mesh": ["ball.mesh"])",
                fmt::format(R"("width": {0}, "height": {0})", width));
}

const std::vector<Case>& cases()
{
    static const std::vector<Case> all = {
        {"Attributes", ball(8) + "," + t("Attributes@1", of_ball, R"("attributes": [{ "name": "a",
            "value": "sin(x) * cos(y) + sqrt(abs(z)) + x" }])")},
        {"BallMesh", node("b", "Ball@1", "") + "," +
                         t("BallMesh@1", R"("balls": ["b.ball"])", R"("segments": 1000)")},
        {"Collider", ball(8) + "," + t("Collider@1", of_ball, R"("kind": "mesh")")},
        {"Compare",
         picture(2560) + "," +
             t("Compare@1", R"("a": "r.image", "b": "r.image")", R"("mode": "difference")")},
        {"ConnectedComponent",
         ball(5) + "," + solid("ball", 90) + "," + t("ConnectedComponent@1", of_cubes)},
        {"ContactSheet", picture(2048) + "," + t("ContactSheet@1", R"("image": "r.image")"), 9},
        {"Copies",
         ball(5) + "," + t("Copies@1", of_ball, R"("count_x": 20, "count_y": 10, "count_z": 5)")},
        {"CubeMesh", ball(5) + "," + solid("ball", 90) + "," + t("CubeMesh@1", of_cubes)},
        {"Embed", ball(8) + "," + ball(3, "coarse") + "," + solid("coarse", 30) + "," +
                      node("sim", "Simulate@3", of_cubes) + "," +
                      t("Embed@3", of_ball + "," + of_cubes + R"(, "state": "sim.state")")},
        {"ImplicitLayer", node("k", "Skeletons@1", "", two_points) + "," +
                              t("ImplicitLayer@3", R"("layer": "k.layer")",
                                R"("base": "still", "seed_spacing": 0.002)")},
        {"Layered",
         ball(4) + "," + node("k", "Skeletons@1", of_ball, R"("skeletons": [{ "kind": "mesh" }])") +
             "," +
             node("l", "ImplicitLayer@3", R"("layer": "k.layer")",
                  R"("density": 100, "seed_spacing": 0.03)") +
             "," + node("g", "Collider@1", "") + "," +
             t("Layered@1", R"("parts": ["l.part", "l.part"], "colliders": ["g.collider"])",
               R"("substeps": 10000)"),
         2},
        {"LocalMatter",
         ball(5) + "," + solid("ball", 90) + "," + t("LocalMatter@1", of_cubes, R"("properties":
            [{ "property": "young", "value": "1e5 * (1.5 + sin(x)) + 2" }])")},
        {"Measure", ball(8) + "," + t("Measure@1", of_ball, R"("what": "volume")")},
        {"Merge", ball(8) + "," + t("Merge@1", R"("meshes": ["ball.mesh", "ball.mesh"])")},
        {"Modes_matrices_and_factor",
         ball(5) + "," + solid("ball", 32) + "," + t("Modes@1", of_ball + "," + of_cubes)},
        {"Modes_search", ball(5) + "," + solid("ball", 12) + "," +
                             t("Modes@1", of_ball + "," + of_cubes, R"("count": 300)")},
        {"MotionBounds", ball(8) + "," + t("MotionBounds@1", of_ball)},
        {"Onion", ball(8) + "," + t("Onion@1", of_ball)},
        {"Patch", ball(7) + "," +
                      node("moved", "Transform@1", of_ball, R"("translate": [1, 0, 0])") + "," +
                      node("v", "Plane@1", "", R"("size": 0.02)") + "," +
                      node("sim", "Simulate@3", of_cubes, R"("method": "lattice")") + "," +
                      t("Patch@1", R"("mesh": "moved.mesh", "rest": "ball.mesh", "cubes": "v.cubes",
            "state": "sim.state", "carried": "v.mesh")")},
        {"Pin", ball(5) + "," + solid("ball", 90) + "," +
                    t("Pin@1", of_cubes, R"("box": { "centre": [0, -1, 0], "size": [4, 2, 4] })")},
        {"Plane", t("Plane@1", "", R"("size": 0.001)")},
        {"Polygonize", scene() + "," +
                           t("Polygonize@2", R"("scene": "s.scene")",
                             R"("cell": 0.003, "max_triangles": 100000000)")},
        {"Primitive_sphere", ball(9, "t")},
        {"Primitive_grid", t("Primitive@1", "", R"("shape": "grid",
            "grid": { "divisions_x": 2000, "divisions_z": 2000 })")},
        {"ReadMesh_obj", t("ReadMesh@1", "", R"("path": "big.obj")"), 1,
         ball(7) + "," + t("WriteMesh@1", of_ball, R"("path": "big.obj")")},
        {"ReadMesh_ply", t("ReadMesh@1", "", R"("path": "big.ply")"), 1,
         ball(8) + "," + t("WriteMesh@1", of_ball, R"("path": "big.ply")")},
        {"ReadState",
         ball(5) + "," + solid("ball", 90) + "," +
             t("ReadState@1", of_cubes, R"("path": "corners.ply")"),
         1,
         ball(5) + "," + solid("ball", 90) + "," + node("c", "CubeMesh@1", of_cubes) + "," +
             t("WriteMesh@1", R"("mesh": "c.mesh")", R"("path": "corners.ply")")},
        {"Render", ball(8) + "," + t("Render@2", R"("mesh": ["ball.mesh"])")},
        {"Sample_blue",
         ball(5) + "," + t("Sample@2", of_ball, R"("count": 2000000, "pattern": "blue")")},
        {"Sample_even", ball(5) + "," + t("Sample@2", of_ball, R"("count": 20000000)")},
        {"Sample_volume",
         ball(5) + "," + t("Sample@2", of_ball, R"("count": 1000000, "where": "volume")")},
        {"Sheet", ball(8) + "," + t("Sheet@1", of_ball)},
        {"Simulate_one_long_step", ball(5) + "," + solid("ball", 56) + "," + simulate(), 2},
        {"Simulate_bricks",
         ball(4) + "," + solid("ball", 8) + "," + simulate(R"("step": { "substeps": 10000 })"), 2},
        {"Simulate_springs",
         ball(4) + "," + solid("ball", 8) + "," +
             simulate(R"("method": "springs", "step": { "substeps": 10000 })"),
         2},
        {"Simulate_lattice",
         ball(4) + "," + solid("ball", 8) + "," +
             simulate(R"("method": "lattice", "step": { "substeps": 10000 })"),
         2},
        {"Simulate_sheet",
         ball(7) + "," + node("v", "Sheet@1", of_ball) + "," + simulate(R"("method": "shell")"), 2},
        {"Simulate_plane",
         node("v", "Plane@1", "", R"("size": 0.01)") + "," + simulate(R"("method": "shell")"), 2},
        {"Skeletons",
         ball(7) + "," + t("Skeletons@1", of_ball, R"("skeletons": [{ "kind": "mesh" }])")},
        {"Skin", ball(7) + "," + scene() + "," +
                     t("Skin@1", of_ball + R"(, "part": "l.part", "scene": "s.scene")")},
        {"Trail", ball(7) + "," + t("Trail@1", of_ball, R"("of": "vertices", "every": 1)")},
        {"Split", ball(8) + "," + t("Split@1", of_ball, R"("parts": [{ "name": "*" }])")},
        {"Transform", ball(8) + "," + t("Transform@1", of_ball, R"("translate": [1, 0, 0])")},
        {"Vibrate",
         ball(7) + "," + ball(3, "coarse") + "," + solid("coarse", 10) + "," +
             node("m", "Modes@1", of_ball + "," + of_cubes, R"("count": 40)") + "," +
             t("Vibrate@1", R"("model": "m.model")"),
         2},
        {"Voxelize_surface",
         ball(7) + "," + t("Voxelize@1", of_ball, R"("method": "surface", "resolution": 800)")},
        {"Voxelize_many_faces", ball(8) + "," + solid("ball", 120, "t")},
        {"Voxelize_samples",
         ball(5) + "," + node("p", "Sample@2", of_ball, R"("count": 1000000)") + "," +
             t("Voxelize@1", R"("points": ["p.points"])", R"("resolution": 150)")},
        {"Voxelize_calibrated",
         tilted_plate() + "," + t("Voxelize@1", of_ball, R"("method": "solid",
            "size": 0.04, "stiffness": "calibrated")")},
        {"WriteImage_png", picture(2560) + "," + t("WriteImage@1", R"("image": "r.image")")},
        {"WriteImage_exr", ball(3) + "," +
                               node("r", "Render@2", R"("mesh": ["ball.mesh"])",
                                    R"("width": 2560, "height": 2560, "linear": "whole")") +
                               "," +
                               t("WriteImage@1", R"("image": "r.image")", R"("path": "####.exr")")},
        {"WriteMesh_obj", ball(7) + "," + t("WriteMesh@1", of_ball, R"("path": "a.obj")")},
        {"WriteMesh_glb", ball(8) + "," + t("WriteMesh@1", of_ball, R"("path": "a.glb")")},
        {"WriteMesh_ply", ball(8) + "," + t("WriteMesh@1", of_ball, R"("path": "a.ply")")},
    };
    return all;
}

// What the work of these is bound by is no size of a mesh, of cubes or of a picture.
const std::set<std::string> small = {
    "Ball",       "Before",    "Carried", "Carry",     "Figure",     "Force",
    "Gusts",      "Joint",     "Ground",  "Pose",      "Pressure",   "Reach",
    "ReadCamera", "ReadModes", "Springs", "ReadScene", "WriteModes", "WriteScene",
    "ReadVolume",  // waits for aspic-openvdb, and
    "WriteVideo"   // for ffmpeg, see RunProgram.*
};

// ---- what is measured ---------------------------------------------------------------------------

runtime::Want want(const graph::Graph& graph, const std::string& name, int frame)
{
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        if (graph.nodes[n].name == name) return {n, frame};
    }
    throw std::logic_error("no node " + name);
}

graph::Loaded load(const std::string& nodes, int last, const files::fs::path& folder)
{
    graph::Loaded loaded =
        graph::load_text(R"({ "aspic": 1, "frames": { "first": 1, "fps": 24, "last": )" +
                             std::to_string(last) + R"( }, "nodes": {)" + nodes + "} }",
                         folder / "scene.json", nodes::registry());
    for (const auto& problem : loaded.problems) ADD_FAILURE() << problem.message;
    return loaded;
}

std::string type_of(const Case& c)
{
    return c.name.substr(0, c.name.find('_'));
}

class NodeStop : public testing::TestWithParam<Case>, public runtime::Observer {
public:
    void failed(const runtime::Failure& failure) override { ADD_FAILURE() << failure.what; }
};

TEST_P(NodeStop, EndsSoon)
{
    const Case& now = GetParam();
    const files::Folder folder;
    runtime::Options options;
    options.output_folder = folder.path;
    if (!now.before.empty()) {
        const graph::Loaded first = load(now.before, 1, folder.path);
        runtime::Caches caches;
        runtime::Evaluator(first.graph, caches, options, this).cook({want(first.graph, "t", 1)});
    }
    const graph::Loaded loaded = load(now.nodes, now.frame, folder.path);
    EXPECT_EQ(loaded.graph.nodes[want(loaded.graph, "t", 1).node].type->name, type_of(now));
    runtime::Caches caches;  // 1 GiB: holds the inputs of every case
    std::vector<runtime::Want> inputs;
    for (const graph::Node& n : loaded.graph.nodes) {
        if (n.name != "t")
            inputs.push_back(want(loaded.graph, n.name, now.frame));
        else if (now.frame > 1)
            inputs.push_back(want(loaded.graph, "t", now.frame - 1));
    }
    if (!inputs.empty()) runtime::Evaluator(loaded.graph, caches, options, this).cook(inputs);

    const auto seconds_late = [&](double before) {
        std::stop_source source;
        options.stop = source.get_token();
        Clock::time_point asked;
        std::clock_t used = 0;
        std::jthread other([&](const std::stop_token& over) {
            const auto until = Clock::now() + std::chrono::duration<double>(before);
            while (Clock::now() < until && !over.stop_requested()) {
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
            if (over.stop_requested()) return;
            asked = Clock::now();
            used = std::clock();
            source.request_stop();
        });
        runtime::Evaluator(loaded.graph, caches, options, this)
            .cook({want(loaded.graph, "t", now.frame)});
        const Clock::time_point ended = Clock::now();
        const std::clock_t used_then = std::clock();
        other.request_stop();
        other.join();
        if (!source.stop_requested()) return -1.0;  // all was done before
        const double took = std::chrono::duration<double>(ended - asked).count();
        const double worked = double(used_then - used) / CLOCKS_PER_SEC;
        return std::min(took, worked);
    };
    for (const double before : {0.05, 0.2, 0.5}) {
        double late = seconds_late(before);
        for (int again = 0; again < 3 && late > soon; ++again) late = seconds_late(before);
        EXPECT_LT(late, soon) << "stopped after " << before << " s";
        if (late < 0) break;
    }
}

INSTANTIATE_TEST_SUITE_P(Stop, NodeStop, testing::ValuesIn(cases()),
                         [](const auto& info) { return info.param.name; });

TEST(Stop, IsMeasuredOfEveryTypeOfNode)
{
    std::set<std::string> measured = small;
    for (const Case& c : cases()) measured.insert(type_of(c));
    for (const auto& entry : nodes::registry().types()) {
        EXPECT_TRUE(measured.count(entry.first)) << "give " << entry.first << " a case";
    }
}

}  // namespace
