#include "graph/document/document.hpp"

#include "graph/document/assemble.hpp"
#include "graph/document/check_json.hpp"
#include "graph/document/check_settings.hpp"
#include "graph/document/expectations.hpp"
#include "graph/document/links.hpp"
#include "graph/document/loading.hpp"
#include "graph/document/make_nodes.hpp"
#include "graph/document/read_documents.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace graph {

namespace fs = std::filesystem;

Loaded load_file(const fs::path& file, const Registry& registry, const LoadOptions& options)
{
    Problem p;
    p.place.file = file.generic_string();
    std::optional<std::string> text = read_file(file, options.max_bytes, p);
    if (text) return load_text(std::move(*text), file, registry, options);
    Loaded loaded;
    loaded.problems.push_back(std::move(p));
    return loaded;
}

Loaded load_text(std::string text, const fs::path& file, const Registry& registry,
                 const LoadOptions& options)
{
    Loaded loaded;
    if (text.size() > options.max_bytes || text.size() >= UINT32_MAX) {
        loaded.problems.push_back(
            problem_at({file.generic_string(), 0, 0},
                       fmt::format("the document is too large: {} bytes, limit {}", text.size(),
                                   std::min<std::size_t>(options.max_bytes, UINT32_MAX - 1))));
        return loaded;
    }
    const fs::path root = options.root.empty() ? project_root(file) : options.root;
    std::error_code error;
    const PathRules paths{fs::weakly_canonical(fs::absolute(root, error), error),
                          options.allow_outside};
    Loading loading{registry, options, paths};
    loading.graph.file = file.generic_string();
    if (!options.allow_outside) loading.graph.root = root;  // of side files too
    assemble(loading, std::move(text), file);
    make_nodes(loading);
    link_nodes(loading);
    check_settings(loading);
    read_expectations(loading);
    sort_or_report_loops(loading);
    const bool failed = loading.problems.has_errors();
    loaded.problems = loading.problems.take();
    if (failed) return loaded;
    loaded.graph = std::move(loading.graph);
    loaded.variables = std::move(loading.variables);
    return loaded;
}

}  // namespace graph
