#pragma once

// Documents and cooks of scenes, for tests of several nodes.

#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"
#include "runtime/cook/evaluator.hpp"

#include <gtest/gtest.h>

namespace fixtures {

// A document whose nodes are `nodes`, 24 frames a second. It lies in `folder`, and so does what it
// writes.
class Scene : public runtime::Observer {
public:
    explicit Scene(const std::string& nodes, const std::filesystem::path& folder = {},
                   int last = 240)
        : loaded_(graph::load_text(R"({ "aspic": 1, "frames": { "first": 1, "last": )" +
                                       std::to_string(last) + R"(, "fps": 24 }, "nodes": {)" +
                                       nodes + "} }",
                                   folder / "scene.json", nodes::registry())),
          folder_(folder.empty() ? "." : folder)
    {
        for (const auto& problem : loaded_.problems) ADD_FAILURE() << problem.message;
    }

    // The first output of a node. Throws what it failed at.
    template <class T> std::shared_ptr<const T> at(const std::string& node, int frame = 1)
    {
        const auto& all = loaded_.graph.nodes;
        for (std::uint32_t n = 0; n < all.size(); ++n) {
            if (all[n].name != node) continue;
            std::shared_ptr<const T> got;
            failure_.clear();
            runtime::Options options;
            options.output_folder = folder_;
            runtime::Evaluator(loaded_.graph, caches_, options, this)
                .cook({{n, frame}},
                      [&](const runtime::Want&, std::span<const graph::Value> values) {
                          got = values[0].as<T>();
                      });
            if (!got) throw std::runtime_error(failure_);
            return got;
        }
        throw std::logic_error("no node " + node);
    }

    // What a node fails at; empty where it does not.
    template <class T> std::string failure_at(const std::string& node, int frame = 1)
    {
        try {
            at<T>(node, frame);
        } catch (const std::runtime_error& error) {
            return error.what();
        }
        return {};
    }

    void warned(const runtime::Warning& warning) override { warnings.push_back(warning.text); }
    void failed(const runtime::Failure& failure) override { failure_ = failure.what; }
    std::vector<std::string> warnings;

private:
    std::string failure_;
    graph::Loaded loaded_;
    std::filesystem::path folder_;
    runtime::Caches caches_;
};

}  // namespace fixtures
