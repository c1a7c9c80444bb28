#include "graph/document/subgraphs.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/declarations.hpp"
#include "graph/document/file_type.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/read_constants.hpp"
#include "graph/document/read_documents.hpp"
#include "graph/document/subgraph_ports.hpp"

#include <charconv>

#include <fmt/format.h>

namespace graph {

namespace fs = std::filesystem;

namespace {

void check_version(Loading& loading, const Declaration& d, const Json& type, const FileType& file,
                   const Json& face)
{
    double version = 1;
    if (const Json* json = face.find("version")) {
        version = read_number(*json, "a whole number of at least 1", loading.problems).value_or(1);
    }
    if (!file.version) return;
    int wanted = 0;
    const char *begin = file.version->data(), *end = begin + file.version->size();
    const auto [stop, error] = std::from_chars(begin, end, wanted);
    Problem p = wrong(type, fmt::format("version {}", version));
    p.node = d.name;
    if (error != std::errc() || stop != end || wanted < 1 || wanted > version) {
        loading.problems.add(std::move(p));
    } else if (wanted < version) {
        p.severity = Severity::warning;
        p.suggestion = "check that the newer version still does the same";
        loading.problems.add(std::move(p));
    }
}

void expand(Loading& loading, Declaration& d, const FileType& file,
            const std::vector<fs::path>& chain)
{
    SubgraphOutputs& outputs = loading.subgraphs[d.name];
    const Json& type = *d.body.find("type");
    static constexpr std::string_view known[] = {"type", "inputs", "params", "doc", "ui"};
    refuse_unknown(d.body, known, "a node", d.name, loading.problems);
    want_text(d.body.find("doc"), d.name, loading.problems);
    Document document;
    document.chain = chain;
    document.prefix = d.name + "/";
    std::shared_ptr<const Source> source =
        find_document(loading, type, file.path, document.chain, d.name);
    if (!source) return;
    const std::string name = source->name();
    std::optional<Json> root = read_document(loading, document, std::move(source));
    if (!root) return;
    const Json* face = root->find("subgraph");
    if (!face || !face->object()) {
        Problem p = problem_at(type.place(), "this document is not a subgraph");
        p.node = d.name;
        p.expected = fmt::format("a \"subgraph\" with inputs, outputs and params in {}", name);
        loading.problems.add(std::move(p));
        return;
    }
    static constexpr std::string_view parts[] = {"version", "inputs", "outputs", "params"};
    refuse_unknown(*face, parts, "a subgraph", {}, loading.problems);
    check_version(loading, d, type, file, *face);

    std::vector<Declaration> inner = declare_nodes(*root, document.prefix, loading.problems);
    PortTargets::Index index;
    for (std::size_t i = 0; i < inner.size(); ++i) {
        index.emplace(inner[i].name.substr(document.prefix.size()), i);
    }
    std::map<std::string, double, std::less<>> given;
    std::set<std::string> linked;
    const Json* const variables = root->find("variables");
    const PortTargets targets{d, inner, index, variables, given, linked};
    hand_in(loading, targets, *face, "params");
    read_variables(loading, document, variables, given);
    hand_in(loading, targets, *face, "inputs");
    outputs = read_outputs(*face, loading.problems);
    expand_subgraphs(loading, std::move(inner), document.chain);
}

}  // namespace

void expand_subgraphs(Loading& loading, std::vector<Declaration> nodes,
                      const std::vector<fs::path>& chain)
{
    for (Declaration& d : nodes) {
        if (loading.declared > loading.options.max_nodes) return;
        if (++loading.declared > loading.options.max_nodes) {
            loading.problems.add(
                problem_at(d.place, fmt::format("more than {} nodes once subgraphs are expanded",
                                                loading.options.max_nodes)));
            return;
        }
        if (const auto type = file_type(d.body.find("type"))) {
            expand(loading, d, *type, chain);
        } else {
            loading.declarations.push_back(std::move(d));
        }
    }
}

}  // namespace graph
