#include "graph/document/param_reading.hpp"

#include "graph/document/evaluate.hpp"
#include "graph/document/read_constants.hpp"
#include "graph/document/units.hpp"

#include <cmath>

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

// A number with a unit after it: the number that the parameter would take.
std::string if_it_has_a_unit(const std::string& text, const std::string& unit)
{
    const std::optional<double> x = number_in(text, unit);
    if (!x) return {};
    // A conversion is exact but for the last digits.
    const std::string number = fmt::format("{:.12g}", *x);
    return unit.empty() ? fmt::format("write {}", number)
                        : fmt::format("write {}, as this is in {}", number, unit);
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
