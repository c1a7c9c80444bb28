#include "graph/document/read_documents.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/parse_json.hpp"
#include "graph/document/shots.hpp"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

namespace graph {

namespace fs = std::filesystem;

namespace {

constexpr int format_version = 1;
constexpr std::size_t most_levels = 16;  // of documents that extend, and of subgraphs

// False when nothing below can make sense.
bool check_head(const Json& root, Problems& problems)
{
    if (!root.object()) {
        problems.add(wrong(root, "a graph document, { \"aspic\": 1, \"nodes\": {...} }"));
        return false;
    }
    const Json* version = root.find("aspic");
    const std::string expected = fmt::format("\"aspic\": {} (the format version)", format_version);
    if (!version) {
        Problem p = problem_at(root.place(), "the format version is missing");
        p.expected = expected;
        problems.add(std::move(p));
    } else if (const auto v = version->number(); !v || *v != format_version) {
        Problem p = wrong(*version, expected);
        if (v && *v > format_version) p.suggestion = "the document is for a newer aspic";
        problems.add(std::move(p));
        if (v && *v > format_version) return false;
    }
    static constexpr std::string_view known[] = {"aspic",    "frames", "variables", "nodes",
                                                 "expect",   "ui",     "doc",       "extends",
                                                 "subgraph", "$schema"};
    refuse_unknown(root, known, "a graph document", {}, problems);
    want_text(root.find("doc"), {}, problems);
    if (!root.find("nodes") && !root.find("extends")) {
        problems.add(problem_at(root.place(), "the member \"nodes\" is missing"));
    }
    return true;
}

}  // namespace

std::optional<std::string> read_file(const fs::path& file, std::size_t max_bytes, Problem& problem)
{
    std::error_code error;
    if (!fs::exists(file, error)) {
        problem.message = "file not found";
        problem.suggestion = suggest_file(fs::absolute(file, error));
        return {};
    }
    if (!fs::is_regular_file(file, error)) {
        problem.message =
            fs::is_directory(file, error) ? "this is a folder, not a file" : "not a regular file";
        return {};
    }
    const auto size = fs::file_size(file, error);
    if (size > max_bytes) {
        problem.message =
            fmt::format("the document is too large: {} bytes, limit {}", size, max_bytes);
        return {};
    }
    std::string text(size, '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(text.data(), static_cast<std::streamsize>(size));
    if (!in) {
        problem.message = "the file cannot be read";
        return {};
    }
    return text;
}

Origin& new_origin(Loading& loading, Document& document, std::shared_ptr<const Source> source)
{
    auto origin = std::make_unique<Origin>();
    origin->source = std::move(source);
    origin->grammar = loading.plain;  // until its variables are known
    origin->prefix = document.prefix;
    document.origins.push_back(origin.get());
    loading.origins.push_back(std::move(origin));
    return *loading.origins.back();
}

std::optional<Json> read_document(Loading& loading, Document& document,
                                  std::shared_ptr<const Source> source)
{
    Origin& origin = new_origin(loading, document, std::move(source));
    origin.layer = -static_cast<int>(document.chain.size());  // a base has one file more ahead
    std::optional<Json> root =
        parse_json(origin, {.depth = loading.options.max_depth}, loading.problems);
    if (!root || !check_head(*root, loading.problems)) return {};
    const Json* base = root->find("extends");
    if (!base) return root;
    if (!base->text()) {
        loading.problems.add(wrong(*base, "the path of the base document"));
        return root;
    }
    std::shared_ptr<const Source> found =
        find_document(loading, *base, *base->text(), document.chain);
    if (!found) return {};
    std::optional<Json> below = read_document(loading, document, std::move(found));
    if (!below) return {};
    lay_shot_over(*below, std::move(*root), loading.problems);
    return below;
}

std::shared_ptr<const Source> find_document(Loading& loading, const Json& json,
                                            const std::string& text, std::vector<fs::path>& chain,
                                            const std::string& node)
{
    const Source& source = *json.origin->source;
    const fs::path full = (source.folder() / text).lexically_normal();
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(full, error);
    Problem p = problem_at(json.place());
    p.node = node;
    if (error || !can_be_a_path(text)) {
        p.message = "not a valid path";
    } else if (!loading.paths.allow_outside && !lies_in(canonical, loading.paths.root)) {
        p.message = fmt::format("this path is outside the project folder {}",
                                loading.paths.root.generic_string());
        p.suggestion = "copy the file into the project, or pass --allow-outside";
    } else if (const auto loop = std::find(chain.begin(), chain.end(), canonical);
               loop != chain.end()) {
        p.message = "these documents form a loop: ";
        for (auto it = loop; it != chain.end(); ++it) {
            p.message += it->filename().generic_string() + " -> ";
        }
        p.message += canonical.filename().generic_string();
    } else if (chain.size() > most_levels) {
        p.message = fmt::format("more than {} levels of nested documents", most_levels);
    } else {
        std::shared_ptr<const Source>& known = loading.sources[canonical];
        if (known) return chain.push_back(canonical), known;
        if (auto content = read_file(full, loading.options.max_bytes, p)) {
            const fs::path name = fs::path(source.name()).parent_path() / text;
            known = std::make_shared<const Source>(name.lexically_normal().generic_string(),
                                                   full.parent_path(), std::move(*content));
            return chain.push_back(canonical), known;
        }
        loading.sources.erase(canonical);
    }
    p.found = json.snippet();
    loading.problems.add(std::move(p));
    return nullptr;
}

}  // namespace graph
