// Trails: whose paths they are, how far they reach back, and how they fade.

#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "render/trail.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;
using geometry::Vec3f;

// On a circle of 2 m about the z axis, a tenth of it a frame.
Vec3f on_circle(int frame)
{
    const double angle = 2 * std::numbers::pi * frame / 10;
    return {float(2 * std::cos(angle)), float(2 * std::sin(angle)), 0};
}

TriMesh ball_at(const Vec3f& place)
{
    TriMesh mesh = geometry::icosphere(0.3, 1);
    for (auto& p : mesh.positions) p += place;
    return mesh;
}

// Both outputs of a Trail of `mesh_of(frame)` in frame `last`, which saw all frames from 1 on.
template <class Mesh> std::vector<graph::Value> followed(NodeRun& trail, int last, Mesh mesh_of)
{
    std::vector<graph::Value> out;
    trail.previous.assign(1, graph::Value());
    for (int f = 1; f <= last; ++f) {
        trail.inputs["mesh"] = {graph::Value::of(mesh_of(f))};
        out = trail.outputs(f);
        trail.previous = {out.at(1)};
    }
    return out;
}

const std::vector<float>& attribute(const TriMesh& mesh, const std::string& name)
{
    for (const auto& a : mesh.attributes) {
        if (a.name == name) return a.values;
    }
    throw std::logic_error("no attribute " + name);
}

double distance_to(const Vec3f& p, const Vec3f& a, const Vec3f& b)
{
    const Vec3f along = b - a;
    const float t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0f, 1.0f);
    return double((p - a - t * along).norm());
}

// A ball at 3 m/s of the scene, of which 1/240 s pass in a frame of 1/24 s: ten times slow motion.
TEST(Trail, TellsAgesAndSpeedsInTheTimeOfTheScene)
{
    NodeRun trail("Trail");
    trail.param("frames").is = std::int64_t{4};
    trail.param("width").is = 0.01;
    for (const double pace : {0.0, 1.0 / 240}) {
        trail.pace = pace;
        const double second = pace > 0 ? pace : 1.0 / 24;
        const auto out =
            followed(trail, 6, [&](int f) { return ball_at(Vec3f(float(3 * second * f), 0, 0)); });
        const auto points = out[1].as<TriMesh>(), tube = out[0].as<TriMesh>();
        EXPECT_FLOAT_EQ(attribute(*points, "age").front(), float(4 * second));
        // Distances of places whose means are off by a few rounding errors of single precision,
        // 1e-7 m of 0.0125 m.
        for (const float speed : attribute(*tube, "speed")) EXPECT_NEAR(speed, 3, 1e-3);
        EXPECT_FLOAT_EQ(
            *std::max_element(attribute(*tube, "age").begin(), attribute(*tube, "age").end()),
            float(4 * second));
    }
}

TEST(Trail, FollowsAKnownPathForItsLastFrames)
{
    NodeRun trail("Trail");
    trail.param("frames").is = std::int64_t{4};
    trail.param("width").is = 0.1;
    trail.param("taper").is = 0.5;
    const auto out = followed(trail, 9, [](int f) { return ball_at(on_circle(f)); });
    const auto points = out[1].as<TriMesh>();
    ASSERT_EQ(points->positions.size(), 5u);
    for (int k = 0; k < 5; ++k) {
        // The mean of 42 vertices, in single precision: a few rounding errors of 2 m.
        EXPECT_LT((points->positions[std::size_t(k)] - on_circle(5 + k)).norm(), 1e-6f);
        EXPECT_FLOAT_EQ(attribute(*points, "age")[std::size_t(k)], float(4 - k) / 24);
    }
    // Each vertex of a ring lies half the width from the path there; the oldest has lost half.
    const auto tube = out[0].as<TriMesh>();
    ASSERT_EQ(tube->positions.size(), 5 * 8 + 2u);
    const auto& ages = attribute(*tube, "age");
    for (std::size_t v = 1; v + 1 < tube->positions.size(); ++v) {
        const int frame = 9 - int(std::lround(24 * double(ages[v])));
        const double r = 0.05 * (1 - 0.5 * (9 - frame) / 4.0);
        EXPECT_NEAR(double((tube->positions[v] - on_circle(frame)).norm()), r, 1e-6);
        double nearest = 1e9;
        for (int f = 5; f < 9; ++f) {
            nearest =
                std::min(nearest, distance_to(tube->positions[v], on_circle(f), on_circle(f + 1)));
        }
        EXPECT_GT(nearest, 0.8 * r);
        // Chords of 36 degrees, 24 a second.
        EXPECT_NEAR(double(attribute(*tube, "speed")[v]), 4 * std::sin(std::numbers::pi / 10) * 24,
                    1e-3);
    }
    // Closed: each edge has two faces, once each way.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : tube->triangles()) {
        for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, uses] : edges) {
        EXPECT_EQ(uses, 1);
        EXPECT_TRUE(edges.contains({edge.second, edge.first}));
    }
}

TEST(Trail, FadesWithAge)
{
    NodeRun trail("Trail");
    trail.param("frames").is = std::int64_t{8};
    trail.param("colour").is = std::array<double, 3>{1, 0, 0};
    trail.param("pale").is = std::array<double, 3>{0, 0, 1};
    trail.param("fade").is = 1.0;
    trail.param("opacity").is = 0.2;
    const auto tube = followed(trail, 9,
                               [](int f) {
                                   return ball_at({float(f), 0, 0});
                               })[0]
                          .as<TriMesh>();
    float blue = -1, opacity = 2;
    for (std::size_t f = 0; f < 8 * 16; ++f) {  // from the newest on
        const auto& material = tube->topology->materials[tube->topology->material[f]];
        EXPECT_GE(material.colour[2], blue);
        EXPECT_LE(material.opacity, opacity);
        blue = material.colour[2], opacity = material.opacity;
    }
    EXPECT_GT(blue, 0.8f);
    EXPECT_LT(opacity, 0.3f);
}

TEST(Trail, KnowsPiecesVerticesAndParts)
{
    const auto two = [](int f) {
        const TriMesh a = ball_at({float(f), 0, 0}), b = ball_at({0, float(f), 5});
        TriMesh both = geometry::merge(std::array{&a, &b});
        auto topology = *both.topology;
        topology.groups = {"a", "b"};
        topology.group.assign(topology.triangles.size(), 0);
        std::fill(topology.group.begin() + std::ptrdiff_t(a.triangles().size()),
                  topology.group.end(), std::uint16_t{1});
        both.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
        return both;
    };
    NodeRun trail("Trail");
    trail.param("of").is = std::string("pieces");
    const auto pieces = followed(trail, 3, two)[1].as<TriMesh>();
    ASSERT_EQ(pieces->positions.size(), 6u);
    EXPECT_LT((pieces->positions[4] - Vec3f(3, 0, 0)).norm(), 1e-6f);
    EXPECT_LT((pieces->positions[5] - Vec3f(0, 3, 5)).norm(), 1e-6f);

    trail.param("of").is = std::string("vertices");
    trail.param("every").is = std::int64_t{10};
    trail.param("part").is = std::string("b");
    const auto vertices = followed(trail, 3, two)[1].as<TriMesh>();
    ASSERT_EQ(vertices->positions.size(), 3 * 5u);  // 42 vertices: 0, 10, 20, 30, 40
    const TriMesh now = two(3);
    EXPECT_EQ(vertices->positions[11], now.positions[42 + 10]);

    trail.param("part").is = std::string("c");
    try {
        followed(trail, 1, two);
        ADD_FAILURE() << "a part that is not there was taken";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("the mesh has a, b"), std::string::npos)
            << error.what();
    }
}

// A metre a frame for two frames, five frames of rest, and a metre again: 24 m/s throughout.
TEST(Trail, ARestTakesNothingFromTheSpeedAroundIt)
{
    TriMesh points;
    for (const float x : {0.0f, 1.0f, 2.0f, 2.0f, 2.0f, 2.0f, 2.0f, 2.0f, 3.0f}) {
        const Vec3f place[] = {{x, 0, 0}};
        const TriMesh before = points;
        points = render::remember(before.positions.empty() ? nullptr : &before, place, 20, 1 / 24.0,
                                  0.1f);
    }
    const TriMesh tubes = render::trail_tubes(points, {});
    ASSERT_FALSE(tubes.positions.empty());
    for (const float speed : attribute(tubes, "speed")) EXPECT_NEAR(speed, 24, 0.01);
}

TEST(Trail, OfWhatStandsStillOrChangesIsNotDrawn)
{
    NodeRun trail("Trail");
    const auto still = followed(trail, 5, [](int) { return ball_at({1, 2, 3}); });
    EXPECT_TRUE(still[0].as<TriMesh>()->triangles().empty());
    EXPECT_EQ(still[1].as<TriMesh>()->positions.size(), 5u);
    // Another number of points: anew.
    trail.param("of").is = std::string("vertices");
    trail.param("every").is = std::int64_t{1};
    const auto torn = followed(trail, 5, [](int f) {
        return f < 4 ? geometry::icosphere(1, 1) : geometry::icosphere(1, 2);
    });
    EXPECT_EQ(torn[1].as<TriMesh>()->positions.size(), 2 * 162u);
}

TEST(Trail, AGraphGrowsItFrameByFrame)
{
    const files::Folder folder;
    fixtures::Scene scene(R"(
        "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
        "moved": { "type": "Transform@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "translate": { "keys": [[1, [0, 0, 0]], [11, [10, 0, 0]]] } } },
        "t": { "type": "Trail@1", "inputs": { "mesh": "moved.mesh" },
               "params": { "frames": 4 } })",
                          folder.path, 11);
    EXPECT_TRUE(scene.at<TriMesh>("t", 1)->positions.empty());
    EXPECT_EQ(scene.at<TriMesh>("t", 3)->positions.size(), 3 * 8 + 2u);
    EXPECT_EQ(scene.at<TriMesh>("t", 9)->positions.size(), 5 * 8 + 2u);
}

}  // namespace
