// A layered scene is kept on disk: bodies once, states each frame, search trees made anew.

#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/layered_step.hpp"
#include "runtime/cook/evaluator.hpp"
#include "tests/graph/content_shelf.hpp"
#include "tests/runtime/toys.hpp"

#include <gtest/gtest.h>

static_assert(graph::Storable<physics::LayeredScene>);
static_assert(graph::Storable<physics::LayeredPart>);
static_assert(graph::Storable<geometry::ImplicitLayer>);

namespace {

// All of it, shared parts included.
std::string bytes_of(const physics::LayeredScene& scene)
{
    ContentShelf shelf;
    graph::Encoder e = shelf.encoder();
    graph::encode(scene, e);
    for (const std::string& content : shelf.all) e.bytes += content;
    return e.bytes;
}

// A ball with a soft layer falls on a mesh.
const char* const falling = R"({ "aspic": 1, "frames": { "first": 1, "last": 60, "fps": 24 },
  "nodes": {
    "skeleton": { "type": "Skeletons@1", "params": { "skeletons": [
      { "kind": "point", "position": [0, 0.3, 0],
        "contribution": { "thickness": 0.1, "stiffness": 10, "radius": 0.25 } } ] } },
    "ball": { "type": "ImplicitLayer@3", "inputs": { "layer": "skeleton.layer" },
      "params": { "seed_spacing": 0.01, "volume": { "proportional": 10 } } },
    "stone": { "type": "Primitive@1", "params": { "shape": "box" } },
    "hard": { "type": "Collider@1", "inputs": { "mesh": "stone.mesh" },
      "params": { "kind": "mesh", "translate": [0, -0.5, 0] } },
    "motion": { "type": "Layered@1",
      "inputs": { "parts": ["ball.part"], "colliders": ["hard.collider"] } } } })";

struct Cook {
    std::string bytes;
    runtime::Tally tally;
};

// What the node "motion" makes at `frame`, with results kept in `folder`, if any, and no memory.
Cook cook(const graph::Graph& graph, int frame, const std::filesystem::path& folder)
{
    runtime::Caches caches;
    if (!folder.empty()) {
        caches.disk =
            std::make_unique<runtime::DiskCache>(folder, std::uintmax_t{1} << 30, nullptr);
    }
    std::uint32_t motion = 0;
    while (graph.nodes.at(motion).name != "motion") ++motion;
    Cook result;
    const runtime::Cooked cooked =
        runtime::Evaluator(graph, caches, {})
            .cook({{motion, frame}},
                  [&](const runtime::Want&, std::span<const graph::Value> values) {
                      result.bytes = bytes_of(*values[0].as<physics::LayeredScene>());
                  });
    result.tally = cooked.tallies[motion];
    return result;
}

}  // namespace

// What is read back goes on as what was written would have, bit for bit: a ball on a mesh, and a
// layer on cubes beside it.
TEST(LayeredStore, AStoredSceneContinuesBitForBit)
{
    geometry::ImplicitLayer layer;
    layer.skeletons = {{.kind = geometry::SkeletonKind::point, .points = {{0, 0.3, 0}}}};
    layer.contributions = {{.thickness = 0.1, .stiffness = 10, .radius = 0.25}};
    layer.frame = {0};
    physics::LayeredPart ball;
    physics::LayeredBody body =
        physics::make_layered_body(layer, physics::BaseKind::rigid, 1000, 0.04);
    body.control.proportional = 10;
    ball.body = std::make_shared<const physics::LayeredBody>(std::move(body));
    physics::Collider ground;
    ground.kind = physics::Collider::Kind::mesh;
    ground.mesh = std::make_shared<const geometry::TriMesh>(geometry::icosphere(0.2, 2));
    layer.skeletons[0].points = {{0.05, 0.25, 0.05}};
    body = physics::make_layered_body(layer, physics::BaseKind::still, 1, 0.04);
    physics::set_on_cubes(body, geometry::solid_cubes({{0, 2, 0}, {0, 3, 0}}, 0.1));
    physics::LayeredPart coated;
    coated.body = std::make_shared<const physics::LayeredBody>(std::move(body));
    coated.pose.translate(geometry::Vec3(0.1, 0.15, 0));
    physics::LayeredScene scene = physics::start({ball, physics::rigid_part(ground), coated});
    for (int i = 0; i < 5; ++i) scene = physics::advance(scene, scene.parts, {}, 1.0 / 24, 1);
    ASSERT_GT(physics::LayeredMoment(scene).contacts.contacts.size(), 0u);

    ContentShelf shelf;
    graph::Encoder e = shelf.encoder();
    graph::encode(scene, e);
    graph::Decoder d = shelf.decoder(e.bytes);
    physics::LayeredScene back;
    graph::decode(d, back);
    EXPECT_EQ(d.left(), 0u);
    EXPECT_EQ(bytes_of(back), bytes_of(scene));
    EXPECT_EQ(bytes_of(physics::advance(back, back.parts, {}, 1.0 / 24, 1)),
              bytes_of(physics::advance(scene, scene.parts, {}, 1.0 / 24, 1)));
}

TEST(LayeredStore, AnInterruptedCookContinuesFromDiskBitForBit)
{
    const graph::Loaded loaded = graph::load_text(falling, "falling.json", nodes::registry());
    for (const auto& problem : loaded.problems) ADD_FAILURE() << problem.message;
    const std::string straight = cook(loaded.graph, 40, {}).bytes;
    ASSERT_FALSE(straight.empty());
    const toys::Folder folder;
    cook(loaded.graph, 30, folder.path);
    const Cook resumed = cook(loaded.graph, 40, folder.path);
    EXPECT_EQ(resumed.bytes, straight);
    EXPECT_GT(resumed.tally.loads, 0u) << "30 steps of 1500 seeds take longer than 5 ms";
    EXPECT_LT(resumed.tally.runs, 40u);
}

// A part that the cache dropped is written again for the next result that has it.
TEST(LayeredStore, AMissingSharedPartIsStoredAgain)
{
    const toys::Folder folder;
    runtime::DiskCache cache(folder.path, std::uintmax_t{1} << 30, nullptr);
    const auto result = std::make_shared<runtime::Result>();
    result->values = {graph::Value::of(geometry::icosphere(1, 2))};  // it shares its topology
    result->seconds = 1;
    for (const unsigned key : {1u, 2u}) {
        cache.store({key, 0}, result);
        cache.flush();
        runtime::DiskCache another(folder.path, std::uintmax_t{1} << 30, nullptr);
        EXPECT_NE(another.load({key, 0}, *nodes::registry().find("Primitive")), nullptr);
        cache.shrink(0, 0);
        EXPECT_EQ(cache.use().contents, 0u);
    }
}
