#include "graph/document/links.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/sort_nodes.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace graph {

namespace {

// What `name` may be a slip of. Comparing with very many names takes its time, so that not
// every mistake of a large file gets a suggestion.
std::string suggest_node(Loading& loading, const std::string& name, const std::string& asking)
{
    if (loading.names.empty()) {
        for (const Declaration& d : loading.declarations) loading.names.push_back(d.name);
        for (const auto& subgraph : loading.subgraphs) loading.names.push_back(subgraph.first);
        std::sort(loading.names.begin(), loading.names.end());
    }
    loading.compared += loading.names.size();
    if (loading.compared > 2'000'000) return {};
    std::vector<std::string_view> others = loading.names;
    std::erase(others, asking);  // no node is linked to itself
    return suggest(name, others);
}

// "candidates: 'a.mesh' and 'b.mesh'": outputs of a wire type, of other nodes than the asking one.
std::string fitting(Loading& loading, const std::string& type, const std::string& asking)
{
    if (loading.problems.full()) return {};
    if (loading.outputs.empty()) {
        for (const Node& node : loading.graph.nodes) {
            for (std::size_t i = 0; node.type && i < node.type->outputs.size(); ++i) {
                const OutputPort& port = node.type->outputs[i];
                loading.outputs[port.type].push_back(node.name + "." + port.name);
            }
        }
    }
    std::vector<std::string_view> names;
    for (const std::string& output : loading.outputs[type]) {
        if (output.substr(0, output.rfind('.')) != asking) names.push_back(output);
    }
    if (names.empty()) return fmt::format("no other node has an output of type {}", type);
    return "candidates: " + list_names(names, 5);
}

std::optional<std::uint32_t> output_index(const std::vector<std::string_view>& names,
                                          const std::string& name, const std::string& node,
                                          const std::string& type, Problem& p)
{
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<std::uint32_t>(found - names.begin());
    if (name.empty() && names.size() == 1) return 0;
    if (names.empty()) {
        p.message = fmt::format("node '{}' has no outputs", node);
    } else if (name.empty()) {
        p.message = fmt::format("node '{}' has several outputs", node);
        p.expected = "one of " + list_names(names);
    } else {
        p.message = fmt::format("node '{}' ({}) has no output '{}'", node, type, name);
        p.suggestion = suggest(name, names);
    }
    return {};
}

// Fills `p` when there is something to report.
std::optional<Link> resolve(Loading& loading, const Json& json, const std::string& type, Problem& p)
{
    if (!json.text()) {
        p.expected = "a link, \"node.output\"";
        p.found = json.snippet();
        return {};
    }
    const Json* at = &json;
    std::string node, port;
    // A subgraph's output stands for a link inside of it, perhaps to a subgraph again.
    for (;;) {
        const std::string& text = *at->text();
        const std::size_t dot = std::min(text.find('.'), text.size());
        node = at->origin->prefix + text.substr(0, dot);
        port = text.substr(std::min(dot + 1, text.size()));
        const auto stand = loading.subgraphs.find(node);
        if (stand == loading.subgraphs.end()) break;
        std::vector<std::string_view> names;
        for (const auto& output : stand->second) names.emplace_back(output.first);
        if (names.empty() && loading.problems.has_errors()) return {};  // it could not be read
        const auto k = output_index(names, port, node, "a subgraph", p);
        if (!k) return {};
        at = &stand->second[*k].second;
    }
    const auto found = loading.index.find(node);
    if (found == loading.index.end()) {
        p.message = fmt::format("there is no node '{}'", node);
        if (at != &json) p.place = at->place();
        p.suggestion = suggest_node(loading, node, p.node);
        return {};
    }
    const NodeType* source = loading.graph.nodes[found->second].type;
    if (!source) return {};  // its own report is enough
    if (const auto old = loading.renamed.find(found->second); old != loading.renamed.end()) {
        for (const auto& [from, to] : old->second) {
            if (port == from) port = to;
        }
    }
    std::vector<std::string_view> names;
    for (const OutputPort& o : source->outputs) names.emplace_back(o.name);
    const auto output = output_index(names, port, node, source->name, p);
    if (!output) return {};
    if (!type.empty() && source->outputs[*output].type != type) {
        p.expected = fmt::format("a wire of type {}", type);
        p.found = fmt::format("'{}.{}' of type {}", node, source->outputs[*output].name,
                              source->outputs[*output].type);
        p.suggestion = fitting(loading, type, p.node);
        return {};
    }
    return Link{found->second, *output};
}

// Of a node whose type nobody knows: whether its links lead anywhere.
void look_at_links(Loading& loading, const Declaration& d, const Json::Object& inputs)
{
    for (const Member& member : inputs) {
        if (const Json::Array* several = member.value.array()) {
            for (const Json& json : *several) find_link(loading, json, {}, d.name, member.key);
        } else {
            find_link(loading, member.value, {}, d.name, member.key);
        }
    }
}

void link_input(Loading& loading, const Declaration& d, Node& node, const Member& member)
{
    std::size_t port = 0;
    const auto& ports = node.type->inputs;
    while (port < ports.size() && ports[port].name != member.key) ++port;
    if (port == ports.size()) {
        std::vector<std::string_view> names;
        for (const InputPort& p : ports) names.emplace_back(p.name);
        Problem p =
            problem_at(member.key_place(), fmt::format("{} has no such input", node.type->name));
        p.node = d.name;
        p.part = Part::input;
        p.port = member.key;
        p.suggestion = suggest(member.key, names);
        for (const Param& param : node.type->params) {
            if (param.name == member.key) {
                p.suggestion = fmt::format("'{}' is a parameter: set it in \"params\"", member.key);
            }
        }
        loading.problems.add(std::move(p));
        return;
    }
    const auto add = [&](const Json& json) {
        if (const auto link =
                find_link(loading, json, ports[port].type, d.name, ports[port].name)) {
            node.inputs[port].push_back(*link);
        }
    };
    if (ports[port].many && member.value.array()) {
        for (const Json& json : *member.value.array()) add(json);
    } else if (member.value.array()) {
        Problem p = wrong(member.value, "one link, \"node.output\"");
        p.node = d.name;
        p.part = Part::input;
        p.port = ports[port].name;
        loading.problems.add(std::move(p));
    } else {
        add(member.value);
    }
}

}  // namespace

std::optional<Link> find_link(Loading& loading, const Json& json, const std::string& type,
                              const std::string& name, const std::string& port)
{
    Problem p = problem_at(json.place());
    p.node = name;
    p.part = port.empty() ? Part::none : Part::input;
    p.port = port;
    const std::optional<Link> link = resolve(loading, json, type, p);
    if (!p.message.empty() || !p.expected.empty()) loading.problems.add(std::move(p));
    return link;
}

void link_nodes(Loading& loading)
{
    for (std::size_t i = 0; i < loading.declarations.size(); ++i) {
        Node& node = loading.graph.nodes[i];
        const Json* inputs = loading.declarations[i].body.find("inputs");
        if (inputs && !inputs->object()) {
            Problem p = wrong(*inputs, "an object, { \"input\": \"node.output\" }");
            p.node = node.name;
            loading.problems.add(std::move(p));
            continue;
        }
        if (!node.type) {
            if (inputs) look_at_links(loading, loading.declarations[i], *inputs->object());
            continue;
        }
        for (std::size_t k = 0; inputs && k < inputs->object()->size(); ++k) {
            link_input(loading, loading.declarations[i], node, (*inputs->object())[k]);
        }
        for (const InputPort& port : node.type->inputs) {
            if (port.optional || (inputs && inputs->find(port.name))) continue;
            if (loading.reported_unlinked.count(node.name + "." + port.name)) continue;
            Problem p = problem_at(node.place, "this input is required but not linked");
            p.node = node.name;
            p.part = Part::input;
            p.port = port.name;
            p.suggestion = fitting(loading, port.type, node.name);
            loading.problems.add(std::move(p));
        }
    }
}

void sort_or_report_loops(Loading& loading)
{
    for (const auto& cycle : sort_nodes(loading.graph)) {
        std::string text;
        for (std::size_t i = 0; i < cycle.size() && i < 20; ++i) {
            text += loading.graph.nodes[cycle[i]].name + " -> ";
        }
        if (cycle.size() > 20) text += fmt::format("({} more) -> ", cycle.size() - 20);
        Problem p =
            problem_at(loading.graph.nodes[cycle[0]].place,
                       "links must not form a loop: " + text + loading.graph.nodes[cycle[0]].name);
        p.suggestion = "simulations read their own previous frame without a link";
        p.node = loading.graph.nodes[cycle[0]].name;
        loading.problems.add(std::move(p));
    }
}

}  // namespace graph
