#include "graph/document/count_nodes.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/file_type.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/read_documents.hpp"

#include <fmt/format.h>

namespace graph {

namespace {

namespace fs = std::filesystem;

struct Count {
    Loading& scratch;  // its problems go nowhere
    std::map<fs::path, double> known = {};
};

double nodes_in(Count& count, const Json& body, const std::vector<fs::path>& chain);

// Of the document that a node's type names; the text of a circle counts once.
double nodes_of(Count& count, const Json& type, const std::string& path,
                const std::vector<fs::path>& chain)
{
    Document document;
    document.chain = chain;
    std::shared_ptr<const Source> source = find_document(count.scratch, type, path, document.chain);
    if (!source) return 0;
    const auto [at, is_new] = count.known.try_emplace(document.chain.back(), 0);
    if (!is_new) return at->second;
    const std::optional<Json> root = read_document(count.scratch, document, std::move(source));
    const Json* nodes = root ? root->find("nodes") : nullptr;
    if (!nodes || !nodes->object()) return 0;
    double sum = 0;
    for (const Member& node : *nodes->object()) {
        sum += nodes_in(count, node.value, document.chain);
    }
    return at->second = sum;
}

double nodes_in(Count& count, const Json& body, const std::vector<fs::path>& chain)
{
    const Json* type = body.object() ? body.find("type") : nullptr;
    const auto file = file_type(type);
    return 1 + (file ? nodes_of(count, *type, file->path, chain) : 0);
}

}  // namespace

bool few_enough(Loading& loading, const std::vector<Declaration>& nodes,
                const std::vector<fs::path>& chain)
{
    Loading scratch{loading.registry, loading.options, loading.paths};
    scratch.sources = loading.sources;
    Count count{scratch};
    double sum = 0;
    for (const Declaration& d : nodes) {
        const double in_it = nodes_in(count, d.body, chain);
        sum += in_it;
        if (sum <= static_cast<double>(loading.options.max_nodes)) continue;
        Problem p =
            problem_at(d.place, fmt::format("more than {} nodes once subgraphs are expanded",
                                            loading.options.max_nodes));
        p.node = d.name;
        if (in_it > 1) p.found = fmt::format("{:.3g} in this node", in_it);
        loading.problems.add(std::move(p));
        return false;
    }
    return true;
}

}  // namespace graph
