#include "graph/tools/difference.hpp"

#include "graph/document/evaluate.hpp"
#include "graph/tools/reference.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include <fmt/format.h>

namespace graph {

namespace {

// Every plain value of a node by its path: "gas.burners", "boxes.0.height".
void add_values(const std::vector<Param>& params, const ParamValues& values,
                const std::string& prefix, Texts& out)
{
    for (std::size_t i = 0; i < params.size(); ++i) {
        const std::string path = prefix + params[i].name;
        if (params[i].kind == ParamKind::block) {
            add_values(params[i].children, std::get<ParamValues>(values[i].is), path + ".", out);
        } else if (params[i].kind == ParamKind::list) {
            const auto& elements = std::get<ParamValues>(values[i].is);
            out[path] = fmt::format("{} elements", elements.size());
            for (std::size_t k = 0; k < elements.size(); ++k) {
                add_values(params[i].children, std::get<ParamValues>(elements[k].is),
                           fmt::format("{}.{}.", path, k), out);
            }
        } else {
            out[path] = value_text(values[i]);
        }
    }
}

std::array<std::string, 3> components(const ParamValues& params,
                                      const std::vector<std::uint32_t>& where)
{
    const ParamValue* value = &params.at(where[0]);
    for (std::size_t i = 1; i < where.size(); ++i) {
        value = &std::get<ParamValues>(value->is).at(where[i]);
    }
    const auto& v = std::get<std::array<double, 3>>(value->is);
    return {fmt::format("{}", v[0]), fmt::format("{}", v[1]), fmt::format("{}", v[2])};
}

void add_paths(const std::vector<Param>& params, const ParamValues& values,
               const std::string& prefix, std::map<std::string, std::filesystem::path>& out)
{
    for (std::size_t i = 0; i < params.size(); ++i) {
        const std::string path = prefix + params[i].name;
        const auto* nested = std::get_if<ParamValues>(&values[i].is);
        if (params[i].kind == ParamKind::path_in) {
            const std::string& file = std::get<std::string>(values[i].is);
            if (!file.empty()) out[path] = file;
        } else if (params[i].kind == ParamKind::block) {
            add_paths(params[i].children, *nested, path + ".", out);
        } else if (params[i].kind == ParamKind::list) {
            for (std::size_t k = 0; k < nested->size(); ++k) {
                add_paths(params[i].children, std::get<ParamValues>((*nested)[k].is),
                          fmt::format("{}.{}.", path, k), out);
            }
        }
    }
}

}  // namespace

Texts values_of(const Node& node)
{
    Texts out;
    add_values(node.type->params, node.params, "", out);
    std::map<std::string, std::array<std::string, 3>> moving;  // components of vectors
    for (const Animated& a : node.animated) {
        const std::string path = param_path(node.type->params, a.where);
        if (a.component < 0) {
            out[path] = a.source;
        } else {
            auto [at, added] = moving.try_emplace(path);
            if (added) at->second = components(node.params, a.where);
            at->second[static_cast<std::size_t>(a.component)] = a.source;
        }
    }
    for (const auto& [path, c] : moving) {
        // Keyframes of a whole vector are the source of each component that moves.
        const auto curve = std::find_if(c.begin(), c.end(),
                                        [](const std::string& s) { return s.starts_with('{'); });
        out[path] = curve != c.end() ? *curve : fmt::format("[{}]", fmt::join(c, ", "));
    }
    return out;
}

std::map<std::string, std::filesystem::path> files_of(const Node& node)
{
    std::map<std::string, std::filesystem::path> out;
    add_paths(node.type->params, node.params, "", out);
    for (const Animated& a : node.animated) {
        if (a.file) out.erase(param_path(node.type->params, a.where));
    }
    return out;
}

std::vector<std::filesystem::path> files_at(const Node& node, int frame)
{
    std::vector<std::filesystem::path> out;
    for (const Animated& a : node.animated) {
        if (!a.file) continue;
        try {
            out.push_back(a.file(frame));
        } catch (const std::exception&) {
            // Cooking that frame says what is wrong.
        }
    }
    return out;
}

Texts links_of(const Graph& graph, const Node& node)
{
    Texts out;
    for (std::size_t i = 0; i < node.inputs.size(); ++i) {
        std::string text;
        for (const Link& link : node.inputs[i]) {
            const Node& source = graph.nodes[link.node];
            text += fmt::format("{}{}.{}", text.empty() ? "" : ", ", source.name,
                                source.type->outputs[link.output].name);
        }
        out[node.type->inputs[i].name] = text.empty() ? "nothing" : text;
    }
    return out;
}

namespace {

std::string type_text(const Node& node)
{
    return fmt::format("{}@{}", node.type->name, node.type->version);
}

std::string range_text(const FrameRange& r)
{
    return fmt::format("{} to {} at {} fps", r.first, r.last, r.fps);
}

// Lines for keys whose texts differ; `join` stands between the node's name and the key.
void compare(const std::string& node, const char* join, const Texts& a, const Texts& b,
             std::vector<std::string>& lines)
{
    std::set<std::string> keys;
    for (const auto& entry : a) keys.insert(entry.first);
    for (const auto& entry : b) keys.insert(entry.first);
    for (const std::string& key : keys) {
        const auto in_a = a.find(key), in_b = b.find(key);
        const std::string was = in_a == a.end() ? "nothing" : in_a->second;
        const std::string is = in_b == b.end() ? "nothing" : in_b->second;
        if (was != is) lines.push_back(fmt::format("~ {}{}{}: {} -> {}", node, join, key, was, is));
    }
}

// What an expectation says, for comparison.
std::string expectation_text(const Graph& graph, const Expectation& e)
{
    const Node& node = graph.nodes[e.value.node];
    return fmt::format("{}.{} from {} to {} at {}", node.name,
                       node.type->outputs[e.value.output].name, e.min, e.max,
                       e.frames.size() > 8 ? fmt::format("{} frames", e.frames.size())
                                           : fmt::format("{}", fmt::join(e.frames, ", ")));
}

std::string escaped(const std::string& text)
{
    std::string out;
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out;
}

}  // namespace

std::vector<std::string> difference(const Graph& a, const Graph& b)
{
    std::vector<std::string> lines;
    if (a.range != b.range) {
        lines.push_back(fmt::format("frames: {} -> {}", range_text(a.range), range_text(b.range)));
    }
    std::map<std::string, std::pair<const Node*, const Node*>> nodes;
    for (const Node& node : a.nodes) nodes[node.name].first = &node;
    for (const Node& node : b.nodes) nodes[node.name].second = &node;
    for (const auto& [name, both] : nodes) {
        const auto& [was, is] = both;
        if (!is) {
            lines.push_back(fmt::format("- {} ({})", name, type_text(*was)));
        } else if (!was) {
            lines.push_back(fmt::format("+ {} ({})", name, type_text(*is)));
        } else {
            if (was->type->name != is->type->name) {
                lines.push_back(
                    fmt::format("~ {}: {} -> {}", name, type_text(*was), type_text(*is)));
            }
            compare(name, " <- ", links_of(a, *was), links_of(b, *is), lines);
            compare(name, ".", values_of(*was), values_of(*is), lines);
        }
    }
    std::set<std::string> was, is;
    for (const Expectation& e : a.expectations) was.insert(expectation_text(a, e));
    for (const Expectation& e : b.expectations) is.insert(expectation_text(b, e));
    for (const std::string& e : was) {
        if (!is.count(e)) lines.push_back("- expects " + e);
    }
    for (const std::string& e : is) {
        if (!was.count(e)) lines.push_back("+ expects " + e);
    }
    return lines;
}

std::string dot_text(const Graph& graph)
{
    std::string text = "digraph {\n  rankdir=LR\n  node [shape=box, style=rounded, "
                       "fontname=\"sans-serif\"]\n  edge [fontname=\"sans-serif\", fontsize=10]\n";
    for (const Node& node : graph.nodes) {
        text +=
            fmt::format("  \"{}\" [label=\"{}\\n{}\"{}]\n", escaped(node.name), escaped(node.name),
                        escaped(type_text(node)), node.type->sink ? ", peripheries=2" : "");
    }
    for (const Node& node : graph.nodes) {
        for (std::size_t i = 0; i < node.inputs.size(); ++i) {
            for (const Link& link : node.inputs[i]) {
                const Node& source = graph.nodes[link.node];
                text += fmt::format("  \"{}\" -> \"{}\" [label=\"{}\", tooltip=\"{} to {}\"]\n",
                                    escaped(source.name), escaped(node.name),
                                    escaped(node.type->inputs[i].type),
                                    escaped(source.type->outputs[link.output].name),
                                    escaped(node.type->inputs[i].name));
            }
        }
    }
    return text + "}\n";
}

}  // namespace graph
