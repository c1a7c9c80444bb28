#include "graph/document/read_numbers.hpp"

#include "graph/document/evaluate.hpp"
#include "graph/document/read_colour.hpp"
#include "graph/document/read_constants.hpp"
#include "graph/document/read_keyframes.hpp"

namespace graph {

namespace {

bool is_curve(const Json& json)
{
    return json.object() != nullptr;
}

ParamValue plain_value(const Param& param, double x)
{
    if (param.kind == ParamKind::integer) return {static_cast<std::int64_t>(x)};
    return {x};
}

// A number that is an expression or a curve: its value if it never changes, else nothing and
// one more entry in node.animated (or a report).
std::optional<double> read_moving(const ParamReading& reading, const Param& param, const Json& json,
                                  int component)
{
    if (is_expression(json)) {
        Problem p = param_problem(reading, json.place());
        std::optional<Expression> e = compile_expression(json, p);
        if (!e) {
            reading.context.problems.add(std::move(p));
            return {};
        }
        if (e->constant) return check(reading, param, *e->constant, json, true);
        Animated a = animated(reading, param, json, component);
        a.value = std::move(e->value);
        reading.node.animated.push_back(std::move(a));
        return {};
    }
    std::optional<Keyframes> keys = read_keyframes(reading, param, json, 1);
    if (!keys) return {};
    return add_curve(reading, param, json, component, std::move(keys->times),
                     std::move(keys->values[0]), *keys);
}

}  // namespace

ParamValue read_number_param(const ParamReading& reading, const Param& param, const Json& json)
{
    const std::optional<double> x = is_expression(json) || is_curve(json)
                                        ? read_moving(reading, param, json, -1)
                                        : read_plain(reading, param, json);
    return x ? plain_value(param, *x) : param.fallback;
}

ParamValue read_vector_param(const ParamReading& reading, const Param& param, const Json& json)
{
    auto value = std::get<std::array<double, 3>>(param.fallback.is);
    if (is_curve(json)) {
        std::optional<Keyframes> keys = read_keyframes(reading, param, json, 3);
        for (std::size_t i = 0; keys && i < 3; ++i) {
            const auto x = add_curve(reading, param, json, static_cast<int>(i), keys->times,
                                     std::move(keys->values[i]), *keys);
            if (x) value[i] = *x;
        }
        return {value};
    }
    if (param.kind == ParamKind::colour && json.text()) {
        if (const auto rgb = read_colour(*json.text())) return {*rgb};
    }
    const Json::Array* items = json.array();
    if (!items || items->size() != 3) {
        complain(reading, json.place(), expectation_of(param), json,
                 is_expression(json) ? "write an expression for each component" : "");
        return {value};
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const Json& item = (*items)[i];
        const std::optional<double> x = is_expression(item) || is_curve(item)
                                            ? read_moving(reading, param, item, static_cast<int>(i))
                                            : read_plain(reading, param, item);
        if (x) value[i] = *x;
    }
    return {value};
}

}  // namespace graph
