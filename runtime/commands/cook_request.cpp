#include "runtime/commands/cook_request.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/wires.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

namespace runtime {

namespace {

namespace fs = std::filesystem;

std::uint32_t find_node(const graph::Graph& graph, const std::string& name)
{
    std::vector<std::string_view> names;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        if (graph.nodes[n].name == name) return static_cast<std::uint32_t>(n);
        names.push_back(graph.nodes[n].name);
    }
    const std::string near = graph::suggest(name, names);
    throw std::invalid_argument(
        fmt::format("{} has no node '{}'{}{}", graph.file, name, near.empty() ? "" : "; ", near));
}

}  // namespace

std::vector<std::uint32_t> chosen_nodes(const graph::Graph& graph, const CookRequest& request)
{
    std::vector<std::uint32_t> nodes;
    if (request.expectations_only) return nodes;
    for (const std::string& name : request.nodes) nodes.push_back(find_node(graph, name));
    if (!nodes.empty()) return nodes;
    std::vector<char> used(graph.nodes.size(), 0);
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        if (graph.nodes[n].type->sink) nodes.push_back(static_cast<std::uint32_t>(n));
        for (const auto& port : graph.nodes[n].inputs) {
            for (const graph::Link& link : port) used[link.node] = 1;
        }
    }
    if (!nodes.empty()) return nodes;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        if (!used[n]) nodes.push_back(static_cast<std::uint32_t>(n));
    }
    return nodes;
}

std::vector<int> chosen_frames(const graph::Graph& graph, const CookRequest& request)
{
    if (request.frames.empty()) {
        std::vector<int> all;
        for (int f = graph.range.first; f <= graph.range.last; ++f) all.push_back(f);
        return all;
    }
    const std::vector<int> frames = parse_frames(request.frames);
    std::vector<int> outside;
    for (const int f : frames) {
        if (f < graph.range.first || f > graph.range.last) outside.push_back(f);
    }
    if (outside.size() < 2) {
        for (const int f : frames) require_frame(graph, f);
        return frames;
    }
    const auto [least, most] = std::minmax_element(outside.begin(), outside.end());
    throw std::invalid_argument(fmt::format(
        "{} has frames {} to {}; {} of the frames that were asked for, {} to {}, are outside",
        graph.file, graph.range.first, graph.range.last, outside.size(), *least, *most));
}

void require_frame(const graph::Graph& graph, int frame)
{
    if (frame >= graph.range.first && frame <= graph.range.last) return;
    throw std::invalid_argument(fmt::format("{} has frames {} to {}; frame {} is outside",
                                            graph.file, graph.range.first, graph.range.last,
                                            frame));
}

fs::path output_folder(const graph::Graph& graph, const CookRequest& request)
{
    const fs::path name = fs::path(graph.file).stem();
    if (request.output_folder.empty()) return fs::path("out") / name;
    return request.files.size() > 1 ? request.output_folder / name
                                    : fs::path(request.output_folder);
}

void make_output_folder(const fs::path& folder)
{
    std::error_code error;
    fs::create_directories(folder, error);
    if (!error) return;
    throw std::invalid_argument(
        fmt::format("the output folder {} can't be created ({}); use --out DIR", folder.string(),
                    error.message()));
}

std::unique_ptr<DiskCache> open_cache(const CookRequest& request, Console& console)
{
    const fs::path folder =
        request.cache.empty() ? DiskCache::default_folder() : fs::path(request.cache);
    if (request.no_disk_cache || folder.empty()) return nullptr;
    return std::make_unique<DiskCache>(
        folder, request.cache_budget,
        [&console](const std::string& text) { console.err << "warning: " + text + "\n"; });
}

graph::LoadOptions load_options(const CookRequest& request)
{
    graph::LoadOptions options;
    options.root = request.root;
    options.allow_outside = request.allow_outside;
    options.reserved = manifest_name;
    if (!request.writes || !request.nodes.empty() || request.expectations_only) {
        options.written_frames = 1;
    } else if (!request.frames.empty()) {
        options.written_frames = static_cast<int>(parse_frames(request.frames).size());
    }
    for (const std::string& set : request.sets) options.sets.push_back(graph::parse_override(set));
    for (const std::string& v : request.variables) options.variables.push_back(parse_variable(v));
    return options;
}

std::optional<graph::Graph> load(const std::string& file, const CookRequest& request,
                                 const graph::Registry& registry, Console& console)
{
    graph::Loaded loaded = load_document(file, registry, load_options(request));
    for (const graph::Problem& problem : loaded.problems) {
        console.err << graph::describe(problem) << "\n";
    }
    if (!loaded.ok()) return std::nullopt;
    return std::move(loaded.graph);
}

}  // namespace runtime
