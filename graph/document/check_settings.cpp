#include "graph/document/check_settings.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/frame_path.hpp"
#include "graph/document/load_options.hpp"

#include <fmt/format.h>

#include <set>
#include <utility>

namespace graph {

namespace {

namespace fs = std::filesystem;

// What stands at "block.parameter" below an object; null when it isn't said.
const Json* find_below(const Json* at, std::string_view path)
{
    for (std::size_t begin = 0; at && begin <= path.size();) {
        const std::size_t end = std::min(path.find('.', begin), path.size());
        at = at->object() ? at->find(path.substr(begin, end - begin)) : nullptr;
        begin = end + 1;
    }
    return at;
}

void tell(Loading& loading, std::size_t i, const Fault& fault)
{
    const Declaration& d = loading.declarations[i];
    Problem p = problem_at(d.place, fault.why);
    if (fault.hint) p.severity = Severity::warning;
    p.node = d.name;
    p.port = fault.at;
    p.part = fault.at.empty() ? Part::none : Part::parameter;
    for (const InputPort& port : loading.graph.nodes[i].type->inputs) {
        if (port.name == fault.at) p.part = Part::input;
    }
    const bool input = p.part == Part::input;
    if (const Json* said = find_below(d.body.find(input ? "inputs" : "params"), fault.at)) {
        p.place = said->place();
    }
    loading.problems.add(std::move(p));
}

using Wrong = std::set<std::string, std::less<>>;

// The inputs of a node that are linked, once for each link.
std::vector<std::string_view> linked_of(const Node& node)
{
    std::vector<std::string_view> out;
    for (std::size_t k = 0; k < node.inputs.size(); ++k) {
        out.insert(out.end(), node.inputs[k].size(), node.type->inputs[k].name);
    }
    return out;
}

// All nodes that a node depends on, but those of `wrong`.
std::vector<LinkedNode> upstream_of(const Graph& graph, std::size_t node, const Wrong& wrong)
{
    std::vector<LinkedNode> all;
    std::vector<char> seen(graph.nodes.size(), 0);
    std::vector<std::size_t> ahead{node};
    seen[node] = 1;
    while (!ahead.empty()) {
        const Node& at = graph.nodes[ahead.back()];
        ahead.pop_back();
        LinkedNode known{{}, at.name, at.type, &at.params, linked_of(at)};
        for (std::size_t k = 0; k < at.inputs.size(); ++k) {
            for (const Link& link : at.inputs[k]) {
                const Node& from = graph.nodes[link.node];
                const bool is_new = std::exchange(seen[link.node], char{1}) == 0;
                if (is_new && from.type && wrong.count(from.name) == 0) ahead.push_back(link.node);
            }
        }
        if (&at != &graph.nodes[node]) all.push_back(std::move(known));
    }
    return all;
}

// The text of a parameter, "block.name"; null where there is none.
std::string* text_at(const std::vector<Param>& params, ParamValues& values, std::string_view path)
{
    const std::size_t dot = path.find('.');
    for (std::size_t k = 0; k < params.size() && k < values.size(); ++k) {
        if (params[k].name != path.substr(0, dot)) continue;
        if (dot == path.npos) return std::get_if<std::string>(&values[k].is);
        auto* const block = std::get_if<ParamValues>(&values[k].is);
        return block ? text_at(params[k].children, *block, path.substr(dot + 1)) : nullptr;
    }
    return nullptr;
}

// What is linked to a node of `wrong`, or to one that is not there, is told of that alone: the link
// counts, and the settings there may not be those meant.
void check_node(Loading& loading, std::size_t i, const Wrong& wrong)
{
    Node& node = loading.graph.nodes[i];
    if (!node.type->check) return;
    Setting setting;
    setting.frames = loading.options.written_frames > 0 ? loading.options.written_frames
                                                        : loading.graph.range.count();
    const Json* const inputs = loading.declarations[i].body.find("inputs");
    for (std::size_t k = 0; k < node.inputs.size(); ++k) {
        const auto& name = node.type->inputs[k].name;
        const bool lost = node.inputs[k].empty() && inputs && find_below(inputs, name);
        setting.linked.insert(setting.linked.end(), lost ? 1 : node.inputs[k].size(), name);
        for (const Link& link : node.inputs[k]) {
            const Node& from = loading.graph.nodes[link.node];
            if (!from.type || wrong.count(from.name) > 0) continue;
            setting.sources.push_back({name, from.name, from.type, &from.params, linked_of(from)});
        }
    }
    setting.upstream = [&] { return upstream_of(loading.graph, i, wrong); };
    setting.complete = [&](std::string_view param, const std::string& text) {
        std::string* const at = text_at(node.type->params, node.params, param);
        if (at && at->empty()) *at = text;
    };
    for (const Fault& fault : node.type->check(node.params, setting)) tell(loading, i, fault);
}

// Files that nodes write, by their names at the first and the last frame.
using Written = std::map<fs::path, std::size_t>;

void check_written(Loading& loading, std::size_t i, Written& written)
{
    const Node& node = loading.graph.nodes[i];
    for (std::size_t k = 0; node.type->sink && k < node.params.size(); ++k) {
        const Param& param = node.type->params[k];
        const auto* text = std::get_if<std::string>(&node.params[k].is);
        if (param.kind != ParamKind::path_out || !text || text->empty()) continue;
        const fs::path path = fs::path(*text).lexically_normal();
        if (path.generic_string() == loading.options.reserved) {
            tell(loading, i,
                 {param.name, fmt::format("{} is written by the cook itself: use another path",
                                          path.generic_string())});
        }
        std::optional<std::size_t> other;
        for (const int frame : {loading.graph.range.first, loading.graph.range.last}) {
            const auto [at, is_new] = written.try_emplace(frame_path(path, frame), i);
            if (!is_new && at->second != i) other = at->second;
        }
        if (!other) continue;
        tell(loading, i,
             {param.name, fmt::format("node '{}' writes {} too: give each node a path of its own",
                                      loading.graph.nodes[*other].name, path.generic_string())});
    }
}

}  // namespace

void check_settings(Loading& loading)
{
    if (loading.problems.full()) return;
    const auto wrong = loading.problems.wrong_nodes();
    Written written;
    for (std::size_t i = 0; i < loading.graph.nodes.size(); ++i) {
        const Node& node = loading.graph.nodes[i];
        if (!node.type || wrong.count(node.name) > 0) continue;
        check_node(loading, i, wrong);
        check_written(loading, i, written);
    }
}

}  // namespace graph
