// Any bytes as a graph document: problems, never a crash, and what loads can be evaluated,
// compared and formatted.

#include "graph/document/evaluate.hpp"
#include "graph/tools/difference.hpp"
#include "graph/tools/format.hpp"
#include "tests/graph/toys.hpp"

#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const std::string text(reinterpret_cast<const char*>(data), size);
    graph::LoadOptions options;
    options.max_frames = 1000;
    const graph::Loaded loaded = toys::load(text, options);
    for (const graph::Problem& p : loaded.problems) {
        if (describe(p).empty()) std::abort();
    }
    for (const graph::Node& node : loaded.graph.nodes) {
        try {
            static_cast<void>(graph::evaluate(node, 7, 0.25));
        } catch (const graph::Failure&) {
        }
    }
    graph::Problems problems;
    const auto formatted = graph::format_document(text, "toy.json", problems);
    if (formatted && loaded.ok()) {
        const graph::Loaded again = toys::load(*formatted, options);
        if (!again.ok() || !graph::difference(loaded.graph, again.graph).empty()) std::abort();
    }
    return 0;
}
