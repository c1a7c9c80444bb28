// Textures in the cache: stored once, shared when read back, and never older than their file.

#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"
#include "runtime/cook/evaluator.hpp"
#include "tests/geometry/files.hpp"
#include "tests/graph/content_shelf.hpp"

#include <gtest/gtest.h>

static_assert(graph::Storable<geometry::TriMesh>);

namespace {

using geometry::Texture;
using geometry::TriMesh;

std::string picture_of(std::uint8_t red)
{
    geometry::Picture picture{2, 2, {}};
    for (int i = 0; i < 4; ++i) picture.rgba.insert(picture.rgba.end(), {red, 40, 50, 255});
    return geometry::encode_png(picture);
}

const std::string model = "mtllib a.mtl\nusemtl paper\nv 0 0 0\nv 1 0 0\nv 1 1 0\n"
                          "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n";

TEST(TexturesKept, AreStoredOnceAndSharedAgainWhenReadBack)
{
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = {{0, 1, 2}};
    topology->materials = {{"a"}, {"b"}, {"none"}};
    topology->materials[0].texture =
        std::make_shared<const Texture>(Texture::Source{"p.png", picture_of(200)});
    topology->materials[0].use.alpha = geometry::TextureUse::Alpha::cutout;
    topology->materials[1].texture = topology->materials[0].texture;
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.topology = topology;

    ContentShelf shelf;
    graph::Encoder e = shelf.encoder();
    graph::encode(mesh, e);
    graph::Decoder d = shelf.decoder(e.bytes);
    TriMesh back;
    graph::decode(d, back);
    ASSERT_EQ(back.topology->materials.size(), 3u);
    for (std::size_t m = 0; m < 3; ++m) {
        EXPECT_EQ(back.topology->materials[m], topology->materials[m]);
    }
    EXPECT_EQ(back.topology->materials[1].texture->picture().rgba[0], 200);
    EXPECT_EQ(back.topology->materials[2].texture, nullptr);
}

// The red of the texture that a cook of the model gives, with results kept in `cache`.
int red_of(const files::fs::path& project, const files::fs::path& cache,
           const graph::LoadOptions& options = {})
{
    const std::string text = R"({ "aspic": 1, "frames": { "first": 1, "last": 2, "fps": 24 },
      "nodes": { "read": { "type": "ReadMesh@1", "params": { "path": "a.obj" } },
        "turned": { "type": "Transform@1", "inputs": { "mesh": "read.mesh" },
          "params": { "translate": [0, 1, 0] } } } })";
    const graph::Loaded loaded =
        graph::load_text(text, project / "graph.json", nodes::registry(), options);
    for (const auto& problem : loaded.problems) ADD_FAILURE() << problem.message;
    runtime::Caches caches;
    caches.disk = std::make_unique<runtime::DiskCache>(cache, std::uintmax_t{1} << 30, nullptr);
    caches.side_files.remember_in(caches.disk.get());
    std::uint32_t last = 0;
    while (loaded.graph.nodes.at(last).name != "turned") ++last;
    int red = -1;
    runtime::Evaluator(loaded.graph, caches, {})
        .cook({{last, 1}}, [&](const runtime::Want&, std::span<const graph::Value> values) {
            const auto& materials = values[0].as<TriMesh>()->topology->materials;
            if (materials.at(0).texture) red = materials[0].texture->picture().rgba[0];
        });
    return red;
}

TEST(TexturesKept, APictureThatChangesOrComesIsReadAgain)
{
    const files::Folder folder;
    folder.write("a.obj", model);
    folder.write("a.mtl", "newmtl paper\nKd 1 1 1\nmap_Kd maps/p.png\n");
    EXPECT_EQ(red_of(folder.path, folder.path / "cache"), -1) << "it is not there yet";
    folder.write("maps/p.png", picture_of(200));
    EXPECT_EQ(red_of(folder.path, folder.path / "cache"), 200);
    EXPECT_EQ(red_of(folder.path, folder.path / "cache"), 200);
    folder.write("maps/p.png", picture_of(90));
    EXPECT_EQ(red_of(folder.path, folder.path / "cache"), 90);
}

// A picture that lies beside the project is there for those who may read it, whoever cooked before.
TEST(TexturesKept, APictureOutsideIsKeptFromThoseWhoMayNotReadIt)
{
    const files::Folder folder;
    folder.write("project/a.obj", model);
    folder.write("project/a.mtl", "newmtl paper\nKd 1 1 1\nmap_Kd ../p.png\n");
    folder.write("p.png", picture_of(200));
    const auto project = folder.path / "project";
    graph::LoadOptions inside, outside, wider;
    inside.root = project;
    outside.allow_outside = true;
    wider.root = folder.path;
    for (const bool outside_first : {false, true}) {
        const auto cache = folder.path / (outside_first ? "cache" : "other");
        if (outside_first) {
            EXPECT_EQ(red_of(project, cache, outside), 200);
        }
        EXPECT_EQ(red_of(project, cache, inside), -1);
        EXPECT_EQ(red_of(project, cache, outside), 200);
        EXPECT_EQ(red_of(project, cache, wider), 200);
        EXPECT_EQ(red_of(project, cache, inside), -1);
    }
}

}  // namespace
