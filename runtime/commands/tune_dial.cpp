#include "runtime/commands/tune_dial.hpp"

#include "runtime/commands/vary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace runtime {
namespace {

std::optional<double> number_of(const graph::Node& node, const graph::ParamValue& value,
                                const std::vector<std::uint32_t>& where, int frame)
{
    for (const graph::Animated& a : node.animated) {
        if (a.where == where && a.value) return a.value(frame, 0);
    }
    if (const auto* number = std::get_if<double>(&value.is)) return *number;
    if (const auto* count = std::get_if<std::int64_t>(&value.is)) return double(*count);
    return std::nullopt;
}

// The numbers among some parameters of a node, blocks included, at a frame.
void add_numbers(const graph::Node& node, const std::vector<graph::Param>& params,
                 const graph::ParamValues& values, std::vector<std::uint32_t> where, int frame,
                 std::vector<std::pair<const graph::Param*, double>>& numbers)
{
    where.push_back(0);
    for (std::size_t i = 0; i < params.size() && i < values.size(); ++i) {
        where.back() = static_cast<std::uint32_t>(i);
        const auto* const nested = std::get_if<graph::ParamValues>(&values[i].is);
        if (nested && params[i].kind == graph::ParamKind::block) {
            add_numbers(node, params[i].children, *nested, where, frame, numbers);
        } else if (const auto number = number_of(node, values[i], where, frame)) {
            numbers.emplace_back(&params[i], *number);
        }
    }
}

// A parameter of a node, and its value in the document.
struct Found {
    const graph::Param* param = nullptr;
    const graph::ParamValue* value = nullptr;
    std::vector<std::uint32_t> where;
};

// "step.substeps" of a node, or what else `path` names; nothing where it has none.
Found find_param(const graph::Node& node, const std::string& path)
{
    const std::vector<graph::Param>* params = &node.type->params;
    const graph::ParamValues* values = &node.params;
    Found found;
    for (std::size_t begin = 0;;) {
        const std::size_t dot = path.find('.', begin);
        const std::string name = path.substr(begin, dot - begin);
        const auto param = std::find_if(params->begin(), params->end(),
                                        [&](const graph::Param& p) { return p.name == name; });
        if (param == params->end()) return {};
        const auto index = static_cast<std::size_t>(param - params->begin());
        found.where.push_back(static_cast<std::uint32_t>(index));
        found.param = &*param;
        found.value = &(*values)[index];
        if (dot == std::string::npos) return found;
        values = std::get_if<graph::ParamValues>(&found.value->is);
        if (!values || param->kind != graph::ParamKind::block) return {};
        params = &param->children;
        begin = dot + 1;
    }
}

// Whether the node has such a choice, and it is `value`.
bool is_set(const graph::Node& node, const std::string& path, std::string_view value)
{
    const Found found = find_param(node, path);
    const auto* text = found.value ? std::get_if<std::string>(&found.value->is) : nullptr;
    return text && *text == value;
}

bool makes_cubes(const graph::NodeType& type)
{
    return std::any_of(type.outputs.begin(), type.outputs.end(),
                       [](const graph::OutputPort& o) { return o.name == "cubes"; });
}

std::optional<Dial> dial_of(const graph::Graph& graph, const graph::Node& node,
                            const std::string& path)
{
    const Found found = find_param(node, path);
    if (!found.value) return std::nullopt;
    const auto number = number_of(node, *found.value, found.where, graph.range.first);
    if (!number) return std::nullopt;
    const bool whole = found.param->kind == graph::ParamKind::integer;
    if (whole && *number == 0) return std::nullopt;  // the node chooses a number itself
    const graph::Limits& limits = found.param->limits;
    return Dial{node.name + "." + path,
                *number,
                whole,
                whole,
                limits.min,
                limits.max,
                makes_cubes(*node.type) ? node.name + ".cubes" : ""};
}

// How much a number that follows a variable tells of what makes it finer: most if it is the
// variable's own, and more if its name says that it is a spacing.
int weight_of(const graph::Param& param, bool own)
{
    if (own) return 3;
    return param.name == "size" || param.name == "substeps" || param.name == "error" ? 2 : 1;
}

constexpr auto size_path = "size", steps_path = "step.substeps", step_error_path = "step.error";
constexpr double most_step_error = 0.5;  // cubes; beyond it an error hardly bounds a motion

// Whether a node that has such a parameter is meant without being named.
bool is_meant(const graph::Node& node, const std::string& path)
{
    if (path == size_path) return node.type->name == "Voxelize";
    if (path != step_error_path) return true;
    return is_set(node, "step.integrator", "implicit_euler") && !is_set(node, "method", "lattice");
}

// What --size or --steps names, or the one node that has such a parameter; nothing where none has.
std::optional<Dial> find_dial(const graph::Graph& graph, const std::string& given,
                              const std::string& path, const std::string& option)
{
    std::vector<Dial> found;
    for (const graph::Node& node : graph.nodes) {
        const bool named = given.starts_with(node.name + ".");
        if (!given.empty() && !named) continue;
        const auto dial = dial_of(graph, node, named ? given.substr(node.name.size() + 1) : path);
        if (dial && (named || is_meant(node, path))) found.push_back(*dial);
    }
    if (found.size() > 1) {
        throw std::invalid_argument(fmt::format("expected one node with '{}', found '{}' and '{}': "
                                                "choose with {} NODE.PARAM",
                                                path, found[0].target, found[1].target, option));
    }
    if (!given.empty() && found.empty()) {
        throw std::invalid_argument(
            fmt::format("expected a number for {}, found no such parameter '{}'", option, given));
    }
    return found.empty() ? std::nullopt : std::optional(found[0]);
}

}  // namespace

// A variable makes cubes or steps finer as it grows where a count grows with it, or a spacing
// shrinks.
Dial following(const graph::Graph& graph, const graph::Graph& other, const std::string& name,
               double value, double factor)
{
    Dial dial{.target = name, .value = value};
    const int frame = graph.range.first;
    int heaviest = 0;
    for (std::size_t n = 0; n < std::min(graph.nodes.size(), other.nodes.size()); ++n) {
        const graph::Node &before = graph.nodes[n], &after = other.nodes[n];
        if (before.type != after.type) continue;
        std::vector<std::pair<const graph::Param*, double>> was, is;
        add_numbers(before, before.type->params, before.params, {}, frame, was);
        add_numbers(after, after.type->params, after.params, {}, frame, is);
        for (std::size_t i = 0; i < std::min(was.size(), is.size()); ++i) {
            if (was[i].second == is[i].second) continue;
            if (dial.cubes.empty() && makes_cubes(*before.type)) {
                dial.cubes = before.name + ".cubes";
            }
            const graph::Param& param = *was[i].first;
            const bool own = was[i].second == value && is[i].second == factor * value;
            const bool whole = param.kind == graph::ParamKind::integer;
            const bool with_it = (is[i].second > was[i].second) == (factor > 1);
            const int weight = weight_of(param, own);
            if (weight > heaviest) dial.grows = false;
            if (weight >= heaviest) dial.grows |= whole == with_it;
            heaviest = std::max(heaviest, weight);
            dial.counts |= whole && with_it && value == std::floor(value);
            if (!own) continue;
            dial.least = std::max(dial.least, param.limits.min);
            dial.most = std::min(dial.most, param.limits.max);
        }
    }
    return dial;
}

std::string node_of(const std::string& wire)
{
    return wire.substr(0, wire.find('.'));
}

bool is_name_of_variable(const std::string& given)
{
    return !given.empty() && is_variable(given);
}

void need_size_by_hand(const graph::Graph& graph, const std::string& node_name)
{
    for (const graph::Node& node : graph.nodes) {
        if (node.name != node_name) continue;
        const Found found = find_param(node, "quality");
        const auto* quality = found.value ? std::get_if<std::string>(&found.value->is) : nullptr;
        if (!quality || *quality == "by_size") continue;
        throw std::invalid_argument(
            fmt::format("'{}' chooses the size of its cubes itself (quality = {}): set quality "
                        "= by_size to tune it",
                        node_name, *quality));
    }
}

bool are_filled(const graph::Graph& graph, const std::string& node_name)
{
    return std::any_of(graph.nodes.begin(), graph.nodes.end(), [&](const graph::Node& node) {
        return node.name == node_name && is_set(node, "method", "solid") &&
               is_set(node, "stiffness", "filled");
    });
}

std::optional<Dial> find_size(const graph::Graph& graph, const std::string& given)
{
    const auto size = find_dial(graph, given, size_path, "--size");
    if (!size) return size;
    const std::string node = size->target.substr(0, size->target.rfind('.'));
    need_size_by_hand(graph, node);
    if (size->value > 0) return size;
    return find_dial(graph, node + ".resolution", "resolution", "--size");
}

std::optional<Dial> find_steps(const graph::Graph& graph, const std::string& given)
{
    const auto steps = find_dial(graph, given, steps_path, "--steps");
    if (steps) return steps;
    auto error = find_dial(graph, given, step_error_path, "--steps");
    if (error) error->most = std::min(error->most, std::max(error->value, most_step_error));
    return error;
}

}  // namespace runtime
