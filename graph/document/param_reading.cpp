#include "graph/document/param_reading.hpp"

#include "graph/document/evaluate.hpp"
#include "graph/document/read_constants.hpp"

#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

#include <fmt/format.h>

namespace graph {

std::string path_of(const ParamReading& reading, const std::string& last)
{
    std::string text;
    for (const std::string& name : reading.names) text += (text.empty() ? "" : ".") + name;
    return last.empty() ? text : text + (text.empty() ? "" : ".") + last;
}

Problem param_problem(const ParamReading& reading, Place place, Severity severity)
{
    Problem p;
    p.place = std::move(place);
    p.severity = severity;
    p.node = reading.node.name;
    p.part = Part::parameter;
    p.port = path_of(reading);
    return p;
}

void complain(const ParamReading& reading, Place place, std::string expected, const Json& found,
              std::string help)
{
    Problem p = param_problem(reading, std::move(place));
    if (reading.names.empty()) p.part = Part::none;
    p.expected = std::move(expected);
    p.found = found.snippet();
    p.suggestion = std::move(help);
    reading.context.problems.add(std::move(p));
}

std::optional<double> check(const ParamReading& reading, const Param& param, double x,
                            const Json& json, bool may_round)
{
    const bool whole = param.kind == ParamKind::integer;
    if (whole && may_round) x = std::round(x);
    if (within(x, param.limits) && std::isfinite(x) && (!whole || x == std::floor(x))) return x;
    Problem p = param_problem(reading, json.place());
    p.expected = expectation_of(param);
    p.found = is_expression(json) ? fmt::format("{}, which is {}", json.snippet(), number_text(x))
                                  : json.snippet();
    reading.context.problems.add(std::move(p));
    return {};
}

namespace {

struct UnitName {
    std::string_view name, of;  // how it is written, and the unit that parameters have
    double size;                // in that unit
};
constexpr UnitName known_units[] = {
    {"m", "m", 1},       {"mm", "m", 1e-3},  {"cm", "m", 1e-2},
    {"dm", "m", 0.1},    {"km", "m", 1e3},   {"in", "m", 0.0254},
    {"ft", "m", 0.3048}, {"Pa", "Pa", 1},    {"kPa", "Pa", 1e3},
    {"MPa", "Pa", 1e6},  {"GPa", "Pa", 1e9}, {"s", "s", 1},
    {"ms", "s", 1e-3},   {"kg", "kg", 1},    {"g", "kg", 1e-3},
    {"t", "kg", 1e3},    {"deg", "deg", 1},  {"rad", "deg", 180 / std::numbers::pi},
    {"N", "N", 1},       {"kN", "N", 1e3},
};

// A number with a unit after it: the number that the parameter would take.
std::string if_it_has_a_unit(const std::string& text, const std::string& unit)
{
    double number = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || !std::isfinite(number)) return {};
    std::string name(rest, end);
    std::erase(name, ' ');
    for (const UnitName& known : known_units) {
        if (known.of != unit || known.name != name) continue;
        return fmt::format("write {}, as this is in {}", number_text(number * known.size), unit);
    }
    return {};
}

// A text where a number belongs: perhaps its '=' was forgotten, or a number was put in quotes.
std::string if_it_is_an_expression(const Json& text)
{
    try {
        const Expression e = text.origin->grammar->compile(*text.text());
        const bool number = text.text()->find_first_not_of("0123456789.+-eE ") == std::string::npos;
        if (number && e.constant) return fmt::format("write {} without quotes", *text.text());
        return fmt::format("did you mean \"={}\"?", *text.text());
    } catch (const ExpressionError&) {
        return {};
    }
}

}  // namespace

std::optional<double> read_plain(const ParamReading& reading, const Param& param, const Json& json,
                                 bool may_round)
{
    const bool computed = is_expression(json);
    Problem p = param_problem(reading, json.place());
    std::optional<double> x = read_constant(json, p);
    if (!x) {
        if (p.message.empty()) p.expected = expectation_of(param);
        if (json.text() && !computed) {
            p.suggestion = if_it_has_a_unit(*json.text(), param.limits.unit);
            if (p.suggestion.empty()) p.suggestion = if_it_is_an_expression(json);
        }
        reading.context.problems.add(std::move(p));
        return {};
    }
    return check(reading, param, *x, json, computed || may_round);
}

Animated animated(const ParamReading& reading, const Param& param, const Json& json, int component)
{
    Animated a;
    a.where = reading.where;
    a.component = component;
    a.kind = param.kind;
    a.limits = param.limits;
    a.source = json.text() ? *json.text() : to_text(json);
    a.place = json.place();
    return a;
}

}  // namespace graph
