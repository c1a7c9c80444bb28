#include "graph/document/assemble.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/count_nodes.hpp"
#include "graph/document/declarations.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/overrides.hpp"
#include "graph/document/read_documents.hpp"
#include "graph/document/subgraphs.hpp"

#include <fmt/format.h>

namespace graph {

namespace fs = std::filesystem;

namespace {

// The main document's variables, with those that the caller gives instead.
void read_given_variables(Loading& loading, Document& document, const Json* json,
                          const std::string& file)
{
    std::map<std::string, double, std::less<>> given;
    for (const auto& [name, value] : loading.options.variables) given.insert_or_assign(name, value);
    loading.variables = read_variables(loading, document, json, given);
    for (const auto& [name, value] : given) {
        Problem p =
            problem_at({file, 0, 0}, fmt::format("the document declares no variable '{}'", name));
        p.suggestion = suggest(name, member_names(json));
        loading.problems.add(std::move(p));
    }
}

// What expressions may use where no variable is known yet: subgraphs hand in values for theirs.
std::shared_ptr<const Grammar> grammar_with(double fps)
{
    auto grammar = std::make_shared<Grammar>();
    grammar->define("fps", fps);
    return grammar;
}

void assemble_nodes(Loading& loading, Json& root, Document& document, const fs::path& file)
{
    loading.graph.range = read_frames(loading, root.find("frames"));
    loading.plain = grammar_with(loading.graph.range.fps);
    read_given_variables(loading, document, root.find("variables"), file.generic_string());
    std::vector<Declaration> nodes = declare_nodes(root, "", loading.problems);
    apply_overrides(loading, nodes, document, OverridesOf::document);
    if (few_enough(loading, nodes, document.chain)) {
        expand_subgraphs(loading, std::move(nodes), document.chain);
    }
    apply_overrides(loading, loading.declarations, document, OverridesOf::subgraphs);
    if (Json* expect = root.find("expect")) loading.expect = std::move(*expect);
}

}  // namespace

void assemble(Loading& loading, std::string text, const fs::path& file)
{
    std::error_code error;
    const fs::path full = fs::absolute(file, error).lexically_normal();
    Document document;
    document.chain.push_back(fs::weakly_canonical(full, error));
    std::optional<Json> root = read_document(
        loading, document,
        std::make_shared<const Source>(file.generic_string(), full.parent_path(), std::move(text)));
    loading.graph.documents.push_back(full);
    if (root) assemble_nodes(loading, *root, document, file);
    // With those of subgraphs, which nodes name.
    for (const auto& [path, source] : loading.sources) loading.graph.documents.push_back(path);
}

}  // namespace graph
