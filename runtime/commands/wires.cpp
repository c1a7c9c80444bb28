#include "runtime/commands/wires.hpp"

#include "graph/document/problem.hpp"
#include "runtime/cook/memory_limit.hpp"

#include <fmt/format.h>

#include <new>
#include <stdexcept>

namespace runtime {

graph::Link find_wire(const graph::Graph& graph, const std::string& name)
{
    const std::size_t dot = name.rfind('.');
    const std::string node = name.substr(0, dot);
    std::string slip;
    std::vector<std::string_view> nodes, ports;
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        nodes.push_back(graph.nodes[n].name);
        if (graph.nodes[n].name != node) continue;
        const auto& outputs = graph.nodes[n].type->outputs;
        for (std::uint32_t o = 0; o < outputs.size(); ++o) {
            ports.push_back(outputs[o].name);
            const bool only = dot == std::string::npos && outputs.size() == 1;
            if (only || (dot != std::string::npos && outputs[o].name == name.substr(dot + 1))) {
                return {n, o};
            }
        }
        slip = fmt::format("node '{}' ({}) has no such output", node, graph.nodes[n].type->name);
    }
    const std::string help =
        slip.empty()
            ? graph::suggest(node, nodes)
            : graph::suggest(dot == std::string::npos ? std::string_view()
                                                      : std::string_view(name).substr(dot + 1),
                             ports);
    if (slip.empty()) slip = fmt::format("there is no node '{}'", node);
    throw std::invalid_argument(
        fmt::format("expected an output node.port of {}, found '{}': {}{}{}", graph.file, name,
                    slip, help.empty() ? "" : "; ", help));
}

bool is_picture(const graph::OutputPort& port)
{
    return port.type == "image";
}

std::string first_picture(const graph::Graph& graph)
{
    for (const graph::Node& node : graph.nodes) {
        if (node.type->gather_frames) continue;
        for (const graph::OutputPort& port : node.type->outputs) {
            if (is_picture(port)) return node.name + "." + port.name;
        }
    }
    return {};
}

graph::Loaded load_document(const std::filesystem::path& file, const graph::Registry& registry,
                            const graph::LoadOptions& options)
{
    try {
        return graph::load_file(file, registry, options);
    } catch (const std::bad_alloc&) {
        throw std::runtime_error(file.string() + ": " + out_of_memory());
    }
}

graph::Loaded load_with(const std::filesystem::path& file, const graph::Registry& registry,
                        graph::LoadOptions options, const Settings& settings)
{
    add_settings(options, settings);
    graph::Loaded loaded = load_document(file, registry, options);
    if (loaded.ok()) return loaded;
    std::string what = "the graph could not be loaded";
    for (const graph::Problem& p : loaded.problems) {
        if (p.severity == graph::Severity::error) what.append(1, '\n').append(graph::describe(p));
    }
    throw std::invalid_argument(what);
}

std::vector<std::string> warnings_of(const graph::Loaded& loaded)
{
    std::vector<std::string> texts;
    for (graph::Problem p : loaded.problems) {
        if (p.severity != graph::Severity::warning) continue;
        p.place = {};
        texts.push_back(graph::describe(p).substr(std::string_view("warning: ").size()));
    }
    return texts;
}

std::string csv_quoted(const std::string& text)
{
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"') out += c;
        out += c == '\n' ? ' ' : c;
    }
    out += '"';
    return out;
}

}  // namespace runtime
