#include "graph/document/make_nodes.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/other_names.hpp"
#include "graph/document/read_params.hpp"
#include "graph/types/registry.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace graph {

namespace {

void refuse_node(Loading& loading, const Declaration& d, Problem p)
{
    p.node = d.name;
    loading.problems.add(std::move(p));
}

// Whether this version can be read: the newest, or one from which upgrade steps lead there.
bool known_version(Loading& loading, Declaration& d, const Json& json, const NodeType& type,
                   int version)
{
    Problem p = problem_at(json.place());
    p.expected = fmt::format("{} of version {}", type.name, type.version);
    p.found = fmt::format("version {}", version);
    if (version > type.version) {
        p.suggestion = "it needs a newer aspic";
        return refuse_node(loading, d, std::move(p)), false;
    }
    std::vector<const Upgrade*> steps;
    for (int v = version; v < type.version; ++v) {
        const auto step = std::find_if(type.upgrades.begin(), type.upgrades.end(),
                                       [&](const Upgrade& u) { return u.from == v; });
        if (step == type.upgrades.end()) {
            p.suggestion = fmt::format("version {} is no longer supported", v);
            return refuse_node(loading, d, std::move(p)), false;
        }
        steps.push_back(&*step);
    }
    const auto node = static_cast<std::uint32_t>(&d - loading.declarations.data());
    for (const Upgrade* step : steps) {
        Problem note =
            problem_at(d.place, fmt::format("{}@{} is read as {}@{}: {}", type.name, step->from,
                                            type.name, step->from + 1, step->note));
        note.severity = Severity::note;
        refuse_node(loading, d, std::move(note));
        if (step->change) step->change(d.body);
        auto& renamed = loading.renamed[node];
        renamed.insert(renamed.end(), step->outputs.begin(), step->outputs.end());
    }
    if (type.short_forms.write_out) type.short_forms.write_out(d.body);
    return true;
}

// "use 'Figure'": the types that other programs call `name`; empty when none are.
std::string types_called(const Registry& registry, const std::string& name)
{
    std::string types;
    for (const auto& [type_name, type] : registry.types()) {
        for (const std::string& synonym : type.synonyms) {
            if (!same_name(synonym, name)) continue;  // "PointDeform", "point_deform"
            types += fmt::format("{}'{}'", types.empty() ? "use " : " or ", type_name);
            break;
        }
    }
    return types;
}

// "Name@version"; null after a report.
const NodeType* type_of(Loading& loading, Declaration& d)
{
    const Json* json = d.body.find("type");
    if (!json || !json->text()) {
        Problem p = json ? wrong(*json, "") : problem_at(d.place);
        p.expected = "\"type\": \"Name@version\"";
        if (!json) p.found = "no type";
        refuse_node(loading, d, std::move(p));
        return nullptr;
    }
    const std::string& text = *json->text();
    const std::size_t at = text.find('@');
    const std::string name = text.substr(0, at);
    const NodeType* type = loading.registry.find(name);
    if (!type) {
        std::vector<std::string_view> names;
        for (const auto& known : loading.registry.types()) names.push_back(known.first);
        Problem p = problem_at(json->place(), fmt::format("unknown node type '{}'", name));
        p.suggestion = advice_on_type(name, loading.registry);
        if (p.suggestion.empty()) p.suggestion = types_called(loading.registry, name);
        if (p.suggestion.empty()) p.suggestion = suggest(name, names);
        if (p.suggestion.empty()) p.suggestion = "`aspic nodes` lists all";
        refuse_node(loading, d, std::move(p));
        return nullptr;
    }
    int version = type->version;
    if (at == std::string::npos) {
        Problem p = problem_at(json->place(), fmt::format("no version given; read as "
                                                          "\"{}@{}\"",
                                                          name, version));
        p.severity = Severity::note;
        refuse_node(loading, d, std::move(p));
    } else {
        const char *begin = text.data() + at + 1, *end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(begin, end, version);
        if (error != std::errc() || stop != end || version < 1) {
            refuse_node(loading, d, wrong(*json, fmt::format("\"{}@{}\"", name, type->version)));
            return nullptr;
        }
    }
    return known_version(loading, d, *json, *type, version) ? type : nullptr;
}

}  // namespace

void make_nodes(Loading& loading)
{
    loading.graph.nodes.resize(loading.declarations.size());
    const ReadContext context{loading.graph.range, loading.paths, loading.problems};
    for (std::size_t i = 0; i < loading.declarations.size(); ++i) {
        Declaration& d = loading.declarations[i];
        Node& node = loading.graph.nodes[i];
        node.name = d.name;
        loading.index.emplace(d.name, static_cast<std::uint32_t>(i));
        node.place = d.place;
        static constexpr std::string_view known[] = {"type", "inputs", "params", "doc", "ui"};
        refuse_unknown(d.body, known, "a node", d.name, loading.problems);
        want_text(d.body.find("doc"), d.name, loading.problems);
        node.type = type_of(loading, d);
        if (!node.type) continue;
        node.inputs.resize(node.type->inputs.size());
        read_params(d.body.find("params"), context, node);
    }
}

}  // namespace graph
