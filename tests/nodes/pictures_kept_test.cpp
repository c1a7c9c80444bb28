// Pictures are kept: cooked again into another folder, they are written and not drawn.

#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"
#include "runtime/cook/evaluator.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>

#include <map>

namespace {

const char* const text = R"({ "aspic": 1, "frames": { "first": 1, "last": 12, "fps": 24 },
  "nodes": {
    "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
    "moved": { "type": "Transform@1", "inputs": { "mesh": "ball" },
               "params": { "translate": ["=0.1 * time", 0, 0] } },
    "picture": { "type": "Render@2", "inputs": { "mesh": "moved", "rest": "ball" },
                 "params": { "width": 32, "height": 24, "quality": "draft" } },
    "frames": { "type": "WriteImage@1", "inputs": { "image": "picture" } } } })";

struct Cooked : runtime::Observer {
    const graph::Graph* graph = nullptr;
    std::map<std::string, int> runs;  // of nodes, by name
    void ran(const runtime::Run& run) override
    {
        if (run.preparation < 0) ++runs[graph->nodes[run.node].name];
    }
};

// As a process of its own would, with the pictures written to `out`.
std::map<std::string, int> runs_into(const files::fs::path& out, const files::fs::path& cache)
{
    const graph::Loaded loaded = graph::load_text(text, out / "graph.json", nodes::registry());
    for (const auto& problem : loaded.problems) ADD_FAILURE() << problem.message;
    runtime::Caches caches;
    caches.disk = std::make_unique<runtime::DiskCache>(cache, std::uintmax_t{1} << 30, nullptr);
    caches.side_files.remember_in(caches.disk.get());
    std::vector<runtime::Want> wants;
    for (std::uint32_t n = 0; n < loaded.graph.nodes.size(); ++n) {
        for (int frame = 1; frame <= 12 && loaded.graph.nodes[n].name == "frames"; ++frame) {
            wants.push_back({n, frame});
        }
    }
    Cooked cooked;
    cooked.graph = &loaded.graph;
    runtime::Options options;
    options.output_folder = out;
    runtime::Evaluator(loaded.graph, caches, options, &cooked)
        .cook(wants, [](const runtime::Want&, std::span<const graph::Value>) {});
    return cooked.runs;
}

TEST(PicturesKept, CookedIntoAnEmptyFolderTheyAreNotDrawnAgain)
{
    const files::Folder folder;
    const auto cache = folder.path / "cache", one = folder.path / "one", two = folder.path / "two";
    const auto first = runs_into(one, cache);
    ASSERT_EQ(first.at("picture"), 12);
    ASSERT_EQ(first.at("frames"), 12);
    EXPECT_EQ(runs_into(two, cache), (std::map<std::string, int>{{"frames", 12}}))
        << "only writing is left to do";
    for (int frame = 1; frame <= 12; ++frame) {
        const std::string name =
            "frames/00" + std::string(frame < 10 ? "0" : "") + std::to_string(frame) + ".png";
        const std::string bytes = files::bytes_of(one / name);
        EXPECT_GT(bytes.size(), 100u);
        EXPECT_TRUE(files::bytes_of(two / name) == bytes) << name;
    }
}

}  // namespace
