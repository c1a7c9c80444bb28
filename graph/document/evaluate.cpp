#include "graph/document/evaluate.hpp"

#include <cmath>

#include <fmt/format.h>

namespace graph {

namespace {

// "at least 0 m", "from 0 to 1"; empty without limits. Limits of the storage are nobody's news:
// those of 32 and 64 bits.
std::string range_text(const Limits& limits)
{
    const bool low = limits.min > -2147483648.0;
    const bool high = limits.max < 9e18 && limits.max != 2147483647.0 && limits.max != 4294967295.0;
    const std::string unit = limits.unit.empty() ? "" : " " + limits.unit;
    if (low && high) return fmt::format(" from {} to {}{}", limits.min, limits.max, unit);
    if (low) return fmt::format(" of at least {}{}", limits.min, unit);
    if (high) return fmt::format(" of at most {}{}", limits.max, unit);
    return limits.unit.empty() ? "" : fmt::format(" in {}", limits.unit);
}

ParamValue& target(ParamValues& params, const std::vector<std::uint32_t>& where)
{
    ParamValue* value = &params.at(where.at(0));
    for (std::size_t i = 1; i < where.size(); ++i) {
        value = &std::get<ParamValues>(value->is).at(where[i]);
    }
    return *value;
}

void put(const Animated& a, double x, ParamValue& value)
{
    if (a.component >= 0) {
        std::get<std::array<double, 3>>(value.is)[static_cast<std::size_t>(a.component)] = x;
    } else if (a.kind == ParamKind::integer) {
        value.is = static_cast<std::int64_t>(x);
    } else {
        value.is = x;
    }
}

}  // namespace

std::string number_text(double x)
{
    return std::isnan(x) ? "NaN" : fmt::format("{}", x);
}

std::string expectation_of(const Param& param)
{
    switch (param.kind) {
    case ParamKind::boolean:
        return "true or false";
    case ParamKind::integer:
        return "a whole number" + range_text(param.limits);
    case ParamKind::number:
        return "a number" + range_text(param.limits);
    case ParamKind::vector:
        return "three numbers [x, y, z]" + range_text(param.limits);
    case ParamKind::colour:
        return "a colour, [r, g, b] from 0 to 1 or \"#rrggbb\"";
    case ParamKind::text:
        return "text in quotes";
    case ParamKind::path_in:
        return "the path of a file to read, in quotes";
    case ParamKind::path_out:
        return "the path of a file to write, in quotes";
    case ParamKind::list:
        return "a list [{...}, ...]";
    case ParamKind::block:
        return "an object {...}";
    case ParamKind::choice:
        break;
    }
    const std::vector<std::string_view> names(param.choices.begin(), param.choices.end());
    return "one of " + list_names(names);
}

std::string param_path(const std::vector<Param>& params, const std::vector<std::uint32_t>& where)
{
    std::string path;
    const std::vector<Param>* level = &params;
    for (std::size_t i = 0; i < where.size(); ++i) {
        const Param& p = level->at(where[i]);
        path += (path.empty() ? "" : ".") + p.name;
        if (p.kind == ParamKind::list && i + 1 < where.size()) {
            path += fmt::format(".{}", where[++i]);
        }
        level = &p.children;
    }
    return path;
}

ParamValues evaluate(const Node& node, int frame, double time)
{
    ParamValues params = node.params;
    for (const Animated& a : node.animated) {
        const auto problem = [&] {
            Problem p;
            p.place = a.place;
            p.node = node.name;
            p.part = Part::parameter;
            p.port = param_path(node.type->params, a.where);
            p.message = fmt::format("at frame {}", frame);
            return p;
        };
        if (a.file) {
            try {
                target(params, a.where).is = a.file(frame).generic_string();
            } catch (const std::exception& e) {
                Problem p = problem();
                p.message += fmt::format(": {}", e.what());
                throw Failure(std::move(p));
            }
            continue;
        }
        double x = a.value(frame, time);
        if (a.kind == ParamKind::integer) x = std::round(x);
        if (!std::isfinite(x) || !within(x, a.limits)) {
            Problem p = problem();
            p.expected = "a number" + range_text(a.limits);
            p.found = fmt::format("{} from {}", number_text(x), a.source);
            throw Failure(std::move(p));
        }
        put(a, x, target(params, a.where));
    }
    return params;
}

}  // namespace graph
