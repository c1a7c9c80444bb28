#include "graph/document/subgraph_ports.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/overrides.hpp"
#include "graph/document/read_constants.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace graph {

namespace {

void require_variable(Loading& loading, const Json* declared, const Json& target,
                      const std::string& name)
{
    if (declared && (!declared->object() || declared->find(name))) return;
    Problem p = problem_at(target.place(), fmt::format("the subgraph has no variable '{}'", name));
    p.suggestion = suggest(name, member_names(declared));
    if (p.suggestion.empty()) p.suggestion = "declare it in \"variables\"";
    loading.problems.add(std::move(p));
}

// `target` is "node.port" inside; a null value leaves the inside as it is.
void hand_in_at(Loading& loading, const PortTargets& f, const Json& target, const Json* value,
                bool inputs)
{
    const std::string& text = *target.text();
    const std::size_t dot = text.find('.');
    const std::string node = text.substr(0, dot);
    const std::string port = dot == std::string::npos ? "" : text.substr(dot + 1);
    if (!inputs && node == "variables" && !port.empty()) {
        require_variable(loading, f.declared, target, port);
        if (!value) return;
        if (const auto x = read_number(*value, "a number", loading.problems)) {
            f.variables.insert_or_assign(port, *x);
        }
        return;
    }
    const auto found = f.index.find(node);
    if (found == f.index.end() || port.empty()) {
        Problem p = wrong(target, inputs ? "\"node.input\" inside the subgraph"
                                         : "\"node.parameter\" inside the subgraph");
        std::vector<std::string_view> names;
        for (const auto& [name, i] : f.index) names.emplace_back(name);
        std::sort(names.begin(), names.end());
        if (found == f.index.end()) p.suggestion = suggest(node, names);
        loading.problems.add(std::move(p));
        return;
    }
    if (!value) return;
    Json& body = f.inner[found->second].body;
    if (!inputs) {
        if (auto p = set_param(body, port, *value)) {
            p->place = target.place();
            loading.problems.add(std::move(*p));
        }
        return;
    }
    Json& links = child(body, "inputs", *value);
    if (!links.object()) return;  // said when the inner node is read
    Json* there = links.find(port);
    const bool again = !f.linked.insert(text).second;
    if (there && (there->array() || again)) {
        // A list takes more: links from outside come after those inside.
        if (!there->array()) {
            Json first = *there;
            there->is = Json::Array{std::move(first)};
        }
        if (value->array()) {
            there->array()->insert(there->array()->end(), value->array()->begin(),
                                   value->array()->end());
        } else {
            there->array()->push_back(*value);
        }
    } else {
        put(links, {port, value->begin, *value});
    }
}

void hand_in_port(Loading& loading, const PortTargets& f, const Member& port, const Json* value,
                  bool inputs)
{
    if (!port.value.object()) {
        loading.problems.add(wrong(port.value, "{ \"to\": \"node.port\" }"));
        return;
    }
    static constexpr std::string_view of_inputs[] = {"to", "doc", "optional"};
    static constexpr std::string_view of_params[] = {"to", "doc", "default"};
    refuse_unknown(port.value, inputs ? std::span(of_inputs) : std::span(of_params),
                   inputs ? "a subgraph's input" : "a subgraph's parameter", {}, loading.problems);
    const Json* to = port.value.find("to");
    std::vector<const Json*> targets;
    if (to && to->text()) targets.push_back(to);
    for (std::size_t i = 0; to && to->array() && i < to->array()->size(); ++i) {
        targets.push_back(&(*to->array())[i]);
    }
    if (targets.empty()) {
        loading.problems.add(
            wrong(to ? *to : port.value, "\"to\": \"node.port\", or a list of them"));
        return;
    }
    if (!value && !inputs) value = port.value.find("default");
    if (!value && inputs) {
        const Json* optional = port.value.find("optional");
        const bool* may_miss = optional ? std::get_if<bool>(&optional->is) : nullptr;
        if (!may_miss || !*may_miss) {
            Problem p = problem_at(f.outer.place, "this input is required but not linked");
            p.node = f.outer.name;
            p.part = Part::input;
            p.port = port.key;
            loading.problems.add(std::move(p));
            for (const Json* target : targets) {
                if (target->text())
                    loading.reported_unlinked.insert(f.outer.name + "/" + *target->text());
            }
        }
    }
    for (const Json* target : targets) {
        if (!target->text()) {
            loading.problems.add(wrong(*target, "\"node.port\""));
            continue;
        }
        hand_in_at(loading, f, *target, value, inputs);
    }
}

}  // namespace

void hand_in(Loading& loading, const PortTargets& f, const Json& face, const char* part)
{
    const bool inputs = std::string_view(part) == "inputs";
    const Json* ports = face.find(part);
    const Json* given = f.outer.body.find(part);
    if (ports && !ports->object()) {
        loading.problems.add(wrong(*ports, "an object, { \"name\": { \"to\": \"node.port\" } }"));
        ports = nullptr;
    }
    if (given && !given->object()) {
        Problem p = wrong(*given, "an object {...}");
        p.node = f.outer.name;
        loading.problems.add(std::move(p));
        given = nullptr;
    }
    for (std::size_t i = 0; given && i < given->object()->size(); ++i) {
        const Member& member = (*given->object())[i];
        if (ports && ports->find(member.key)) continue;
        Problem p = problem_at(member.key_place(), fmt::format("the subgraph has no such {}",
                                                               inputs ? "input" : "parameter"));
        p.node = f.outer.name;
        p.part = inputs ? Part::input : Part::parameter;
        p.port = member.key;
        p.suggestion = suggest(member.key, member_names(ports));
        loading.problems.add(std::move(p));
    }
    for (std::size_t i = 0; ports && i < ports->object()->size(); ++i) {
        const Member& port = (*ports->object())[i];
        hand_in_port(loading, f, port, given ? given->find(port.key) : nullptr, inputs);
    }
}

SubgraphOutputs read_outputs(const Json& face, Problems& problems)
{
    SubgraphOutputs outputs;
    const Json* ports = face.find("outputs");
    if (!ports) return outputs;
    if (!ports->object()) {
        problems.add(wrong(*ports, "an object, { \"name\": { \"from\": \"node.output\" } }"));
        return outputs;
    }
    for (const Member& port : *ports->object()) {
        const Json* from = port.value.find("from");
        if (!from || !from->text()) {
            problems.add(wrong(from ? *from : port.value, "{ \"from\": \"node.output\" }"));
            continue;
        }
        static constexpr std::string_view known[] = {"from", "doc"};
        refuse_unknown(port.value, known, "a subgraph's output", {}, problems);
        outputs.emplace_back(port.key, *from);
    }
    return outputs;
}

}  // namespace graph
