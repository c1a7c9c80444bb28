#pragma once

// Parameters that move through keyframes: { "keys": [[frame, value], ...], "interpolation": ... }.

#include "graph/document/curve.hpp"
#include "graph/document/param_reading.hpp"

#include <array>

namespace graph {

// The keys of up to three components.
struct Keyframes {
    std::vector<double> times;
    std::array<std::vector<double>, 3> values;
    bool seconds = false;
    Curve::Between between = Curve::Between::monotone;
    Curve::Beyond beyond = Curve::Beyond::hold;
};

// { "keys": [[frame, value], ...], "interpolation": ..., "extend": ..., "times": ... } for a
// parameter of `width` numbers; null after a report.
std::optional<Keyframes> read_keyframes(const ParamReading& reading, const Param& param,
                                        const Json& json, std::size_t width);

// Adds the curve of the component `values` to Node::animated; its value instead when it never
// changes. `component`: see Animated.
std::optional<double> add_curve(const ParamReading& reading, const Param& param, const Json& json,
                                int component, std::vector<double> times,
                                std::vector<double> values, const Keyframes& keys);

// One of `words`, as its index; null after a report.
std::optional<std::size_t> read_word(const ParamReading& reading, const Json& json,
                                     const std::vector<std::string_view>& words);

}  // namespace graph
