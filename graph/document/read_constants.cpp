#include "graph/document/read_constants.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/evaluate.hpp"

#include <cmath>

#include <fmt/format.h>

namespace graph {

namespace {

// Where byte `position` of an expression stands, when the text has it as it is.
Place place_in(const Json& json, std::size_t position)
{
    if (!json.origin) return {};
    const Source& source = *json.origin->source;
    const bool quoted = json.begin < source.text().size() && source.text()[json.begin] == '"';
    const std::size_t begin = json.begin + (quoted ? 1 : 0);
    const std::string_view raw(source.text().data() + begin, json.end - begin);
    return source.place(raw.starts_with(*json.text()) ? begin + 1 + position : json.begin);
}

}  // namespace

bool is_expression(const Json& json)
{
    return json.text() && json.text()->starts_with('=');
}

std::optional<Expression> compile_expression(const Json& json, Problem& problem)
{
    try {
        return json.origin->grammar->compile(json.text()->substr(1));
    } catch (const ExpressionError& e) {
        problem.place = place_in(json, e.position);
        problem.message = e.what();
        problem.suggestion = e.suggestion;
        return {};
    }
}

std::optional<double> read_constant(const Json& json, Problem& problem)
{
    if (const auto x = json.number()) return x;
    if (!is_expression(json)) {
        problem.found = json.snippet();
        return {};
    }
    const std::optional<Expression> e = compile_expression(json, problem);
    if (!e) return {};
    if (!e->constant) {
        problem.message = "this number must be constant, without frame and time";
        problem.found = json.snippet();
        return {};
    }
    if (!std::isfinite(*e->constant)) {
        problem.message =
            fmt::format("{} gives {}, no finite number", *json.text(), number_text(*e->constant));
        return {};
    }
    return e->constant;
}

std::optional<double> read_number(const Json& json, const std::string& expected, Problems& problems)
{
    Problem p = problem_at(json.place());
    const std::optional<double> x = read_constant(json, p);
    if (!x) {
        if (p.message.empty()) p.expected = expected;
        problems.add(std::move(p));
    }
    return x;
}

std::optional<int> read_frame(const Json& json, Problems& problems)
{
    const std::string expected = "a whole number between -1e9 and 1e9";
    const std::optional<double> x = read_number(json, expected, problems);
    if (!x) return {};
    if (std::fabs(*x) > 1e9 || *x != std::floor(*x)) {
        problems.add(wrong(json, expected));
        return {};
    }
    return static_cast<int>(*x);
}

}  // namespace graph
