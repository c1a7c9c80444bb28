#include "graph/document/read_params.hpp"

#include "graph/document/evaluate.hpp"
#include "graph/document/other_names.hpp"
#include "graph/document/read_numbers.hpp"
#include "graph/document/read_paths.hpp"
#include "graph/document/suggest_param.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace graph {

namespace {

// Blocks and lists nest: their elements are structs again. The description bounds the depth.
ParamValues read_struct(ParamReading& reading, const std::vector<Param>& params, const Json* given);
ParamValue read_param(ParamReading& reading, const Param& param, const Json& json);

std::size_t index_of(const std::vector<Param>& params, std::string_view name)
{
    std::size_t i = 0;
    while (i < params.size() && params[i].name != name) ++i;
    return i;
}

bool decides(const Param& p)
{
    return p.kind == ParamKind::choice || p.kind == ParamKind::boolean;
}

std::string text_of(const ParamValue& value)
{
    if (const auto* s = std::get_if<std::string>(&value.is)) return *s;
    if (const auto* b = std::get_if<bool>(&value.is)) return *b ? "true" : "false";
    if (const auto* i = std::get_if<std::int64_t>(&value.is)) return std::to_string(*i);
    return {};
}

// The outermost condition that does not hold, of its own and those of the parameters that it
// depends on; null: it is shown.
const ShownWhen* hidden_by(const std::vector<Param>& params, const ParamValues& values,
                           std::size_t i)
{
    const ShownWhen* by = nullptr;
    for (std::size_t depth = 0; depth <= params.size(); ++depth) {
        const ShownWhen& when = params[i].shown_when;
        const std::size_t k = index_of(params, when.param);
        if (k == params.size()) break;
        const std::string now = text_of(values[k]);
        if (std::find(when.values.begin(), when.values.end(), now) == when.values.end()) {
            by = &when;
        }
        i = k;
    }
    return by;
}

void unknown(const ParamReading& reading, const std::vector<Param>& params, const Json& given,
             const Member& member)
{
    Problem p = param_problem(reading, member.key_place());
    p.port = path_of(reading, member.key);
    p.message = params.empty() && reading.names.empty()
                    ? fmt::format("{} has no parameters", reading.node.type->name)
                : reading.names.empty()
                    ? fmt::format("{} has no such parameter", reading.node.type->name)
                    : fmt::format("'{}' has no such parameter", path_of(reading));
    p.suggestion = suggest_param(reading, params, given, member.key);
    reading.context.problems.add(std::move(p));
}

// Of a value and what is inside of it, what was laid over the rest.
const Json& said_last(const Json& json)
{
    const Json* last = &json;
    const auto look = [&](const Json& inside) {
        const Json& other = said_last(inside);
        if (other.origin->layer > last->origin->layer) last = &other;
    };
    if (json.array()) std::for_each(json.array()->begin(), json.array()->end(), look);
    for (std::size_t i = 0; json.object() && i < json.object()->size(); ++i) {
        look((*json.object())[i].value);
    }
    return *last;
}

// `decided`: the choice that hides it, as it was said; null: by default. A parameter of a base
// document that a choice of the shot hides is no mistake of either.
void hidden(const ParamReading& reading, const Param& param, const Json& given, const ShownWhen& by,
            const Json* decided, const ParamValues& values, const std::vector<Param>& params)
{
    const Json& last = said_last(given);
    if (!decided || decided->origin->layer <= last.origin->layer) {
        const std::size_t k = index_of(params, by.param);
        Problem p = param_problem(reading, last.place(), Severity::warning);
        p.port = path_of(reading, param.name);
        p.message =
            fmt::format("this has no effect while {} is '{}'; it applies when {} is '{}'", by.param,
                        text_of(values[k]), by.param, fmt::join(by.values, "' or '"));
        reading.context.problems.add(std::move(p));
    }
    // It is read all the same: what is wrong with it would come out when it is wanted.
    Problems inside;
    Node scratch;
    scratch.name = reading.node.name;
    scratch.type = reading.node.type;
    const ReadContext context{reading.context.range, reading.context.paths, inside};
    ParamReading apart{context, scratch, {}, reading.names};
    apart.names.push_back(param.name);
    read_param(apart, param, given);
    for (Problem& found : inside.take()) {
        found.severity = std::min(found.severity, Severity::warning);
        reading.context.problems.add(std::move(found));
    }
}

ParamValues read_struct(ParamReading& reading, const std::vector<Param>& params, const Json* given)
{
    ParamValues values;
    values.reserve(params.size());
    for (const Param& p : params) values.push_back(p.fallback);
    if (!given) return values;
    if (!given->object()) {
        complain(reading, given->place(), "an object {...}", *given);
        return values;
    }

    std::vector<const Json*> found(params.size(), nullptr);
    for (const Member& member : *given->object()) {
        const std::size_t i = index_of(params, member.key);
        if (i == params.size()) {
            unknown(reading, params, *given, member);
        } else {
            found[i] = &member.value;
        }
    }
    // Choices first: they decide which of the others are looked at.
    for (const bool deciding : {true, false}) {
        for (std::size_t i = 0; i < params.size(); ++i) {
            if (!found[i] || decides(params[i]) != deciding) continue;
            const ShownWhen* const by = deciding ? nullptr : hidden_by(params, values, i);
            if (by) {
                hidden(reading, params[i], *found[i], *by, given->find(by->param), values, params);
                continue;
            }
            reading.where.push_back(static_cast<std::uint32_t>(i));
            reading.names.push_back(params[i].name);
            values[i] = read_param(reading, params[i], *found[i]);
            reading.names.pop_back();
            reading.where.pop_back();
        }
    }
    for (std::size_t i = 0; i < params.size(); ++i) {
        if (!found[i] || !decides(params[i])) continue;
        if (const ShownWhen* const by = hidden_by(params, values, i)) {
            hidden(reading, params[i], *found[i], *by, given->find(by->param), values, params);
            values[i] = params[i].fallback;
        }
    }
    return values;
}

ParamValue read_choice(const ParamReading& reading, const Param& param, const Json& json)
{
    if (json.text()) {
        for (const std::string& choice : param.choices) {
            if (choice == *json.text()) return {choice};
        }
    }
    const std::vector<std::string_view> names(param.choices.begin(), param.choices.end());
    const bool near = json.text() && (!own_names_of(*json.text(), names).empty() ||
                                      !nearest(*json.text(), names).empty());
    complain(reading, json.place(), expectation_of(param), json,
             near ? suggest(*json.text(), names) : "");
    return param.fallback;
}

ParamValue read_list(ParamReading& reading, const Param& param, const Json& json)
{
    if (!json.array()) {
        complain(reading, json.place(), expectation_of(param), json);
        return param.fallback;
    }
    ParamValues elements;
    for (std::size_t i = 0; i < json.array()->size(); ++i) {
        reading.where.push_back(static_cast<std::uint32_t>(i));
        reading.names.push_back(std::to_string(i));
        const Json& item = (*json.array())[i];
        if (!item.object()) complain(reading, item.place(), "an object {...}", item);
        elements.push_back({read_struct(reading, param.children, item.object() ? &item : nullptr)});
        reading.names.pop_back();
        reading.where.pop_back();
    }
    return {std::move(elements)};
}

// A text where a block belongs: perhaps a choice within it.
std::string choice_within(const Param& param, const Json& json)
{
    for (const Param& child : param.children) {
        const auto& choices = child.choices;
        if (!json.text() ||
            std::find(choices.begin(), choices.end(), *json.text()) == choices.end())
            continue;
        return fmt::format("did you mean {{\"{}\": \"{}\"}}?", child.name, *json.text());
    }
    return {};
}

ParamValue read_param(ParamReading& reading, const Param& param, const Json& json)
{
    switch (param.kind) {
    case ParamKind::boolean:
        if (const bool* b = std::get_if<bool>(&json.is)) return {*b};
        break;
    case ParamKind::integer:
    case ParamKind::number:
        return read_number_param(reading, param, json);
    case ParamKind::vector:
    case ParamKind::colour:
        return read_vector_param(reading, param, json);
    case ParamKind::text:
        if (json.text()) return {*json.text()};
        break;
    case ParamKind::choice:
        return read_choice(reading, param, json);
    case ParamKind::path_in:
        if (json.text()) return read_path_in(reading, param, json);
        break;
    case ParamKind::path_out:
        if (json.text()) return read_path_out(reading, param, json);
        break;
    case ParamKind::list:
        return read_list(reading, param, json);
    case ParamKind::block:
        if (json.object()) return {read_struct(reading, param.children, &json)};
        complain(reading, json.place(), expectation_of(param), json, choice_within(param, json));
        return param.fallback;
    }
    complain(reading, json.place(), expectation_of(param), json);
    return param.fallback;
}

}  // namespace

void read_params(const Json* given, const ReadContext& context, Node& node)
{
    node.animated.clear();
    ParamReading reading{context, node};
    node.params = read_struct(reading, node.type->params, given);
}

}  // namespace graph
