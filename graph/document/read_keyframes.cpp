#include "graph/document/read_keyframes.hpp"

#include "graph/document/evaluate.hpp"
#include "graph/document/read_colour.hpp"
#include "graph/document/read_constants.hpp"

#include <fmt/format.h>

namespace graph {

namespace {

bool read_key_value(const ParamReading& reading, const Param& param, const Json& what,
                    std::size_t width, std::array<double, 3>& value)
{
    if (width == 1) {
        const std::optional<double> x = read_plain(reading, param, what, true);
        if (x) value[0] = *x;
        return x.has_value();
    }
    if (param.kind == ParamKind::colour && what.text()) {
        if (const auto rgb = read_colour(*what.text())) return value = *rgb, true;
    }
    if (!what.array() || what.array()->size() != width) {
        complain(reading, what.place(), expectation_of(param), what);
        return false;
    }
    bool good = true;
    for (std::size_t i = 0; i < width; ++i) {
        const std::optional<double> x = read_plain(reading, param, (*what.array())[i]);
        good = good && x;
        if (x) value[i] = *x;
    }
    return good;
}

bool read_key(const ParamReading& reading, const Param& param, const Json& key, std::size_t width,
              Keyframes& keys)
{
    if (!key.array() || key.array()->size() != 2) {
        complain(reading, key.place(), "a key [frame, value]", key);
        return false;
    }
    const Json &when = (*key.array())[0], &what = (*key.array())[1];
    Problem p = param_problem(reading, when.place());
    const std::optional<double> time = read_constant(when, p);
    if (!time) {
        if (p.message.empty()) p.expected = "a frame number";
        reading.context.problems.add(std::move(p));
        return false;
    }
    if (!keys.times.empty() && !(*time > keys.times.back())) {
        complain(reading, when.place(),
                 fmt::format("a frame after {}, the previous key's", keys.times.back()), when);
        return false;
    }
    std::array<double, 3> value{};
    if (!read_key_value(reading, param, what, width, value)) return false;
    keys.times.push_back(*time);
    for (std::size_t i = 0; i < width; ++i) keys.values[i].push_back(value[i]);
    return true;
}

}  // namespace

std::optional<Keyframes> read_keyframes(const ParamReading& reading, const Param& param,
                                        const Json& json, std::size_t width)
{
    Keyframes keys;
    bool good = true;
    const Json* list = nullptr;
    for (const Member& member : *json.object()) {
        if (member.key == "keys") {
            list = &member.value;
        } else if (member.key == "interpolation") {
            const auto i =
                read_word(reading, member.value, {"monotone", "smooth", "linear", "step"});
            good = good && i;
            if (i) keys.between = static_cast<Curve::Between>(*i);
        } else if (member.key == "extend") {
            const auto i = read_word(reading, member.value, {"hold", "cycle"});
            good = good && i;
            if (i) keys.beyond = static_cast<Curve::Beyond>(*i);
        } else if (member.key == "times") {
            const auto i = read_word(reading, member.value, {"frames", "seconds"});
            good = good && i;
            if (i) keys.seconds = *i == 1;
        } else {
            static constexpr std::string_view known[] = {"keys", "interpolation", "extend",
                                                         "times"};
            Problem p = param_problem(reading, member.key_place());
            p.message = fmt::format("keyframes have no '{}'", member.key);
            p.suggestion = suggest(member.key, known);
            reading.context.problems.add(std::move(p));
            good = false;
        }
    }
    if (!list || !list->array() || list->array()->empty()) {
        if (!list && !good) return {};  // said already
        complain(reading, (list ? *list : json).place(),
                 list
                     ? "keys [[frame, value], ...]"
                     : expectation_of(param) + ", or keyframes { \"keys\": [[frame, value], ...] }",
                 list ? *list : json);
        return {};
    }
    for (const Json& key : *list->array())
        good = read_key(reading, param, key, width, keys) && good;
    if (!good) return {};
    return keys;
}

std::optional<std::size_t> read_word(const ParamReading& reading, const Json& json,
                                     const std::vector<std::string_view>& words)
{
    for (std::size_t i = 0; json.text() && i < words.size(); ++i) {
        if (*json.text() == words[i]) return i;
    }
    complain(reading, json.place(), "one of " + list_names(words), json,
             json.text() && !nearest(*json.text(), words).empty() ? suggest(*json.text(), words)
                                                                  : "");
    return {};
}

std::optional<double> add_curve(const ParamReading& reading, const Param& param, const Json& json,
                                int component, std::vector<double> times,
                                std::vector<double> values, const Keyframes& keys)
{
    bool still = true;
    for (const double v : values) still = still && v == values[0];
    if (still) return values[0];
    Animated a = animated(reading, param, json, component);
    auto curve = std::make_shared<const Curve>(
        curve_through(std::move(times), std::move(values), keys.between, keys.beyond));
    if (keys.seconds) {
        a.value = [curve](int, double time) { return curve->at(time); };
    } else {
        a.value = [curve](int frame, double) { return curve->at(frame); };
    }
    reading.node.animated.push_back(std::move(a));
    return {};
}

}  // namespace graph
