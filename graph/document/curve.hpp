#pragma once

// Keyframes: a number over time, through given points.
//
//   M. Steffen. A simple method for monotonic interpolation in one dimension. Astronomy and
//   Astrophysics 239, 1990.
//     h_i = t_(i+1) - t_i    s_i = (y_(i+1) - y_i) / h_i
//     p_i = (s_(i-1) h_i + s_i h_(i-1)) / (h_(i-1) + h_i)
//     y'_i = (sign s_(i-1) + sign s_i) min(|s_(i-1)|, |s_i|, |p_i| / 2)
// The curve never leaves the range of the two keys around it, so that keys in range are a curve in
// range, and moving a key changes nothing beyond the second key to either side.

#include <optional>
#include <string>
#include <vector>

namespace graph {

struct Curve {
    enum class Between { monotone, smooth, linear, step };  // smooth: flat at every key
    enum class Beyond { hold, cycle };

    std::vector<double> times, values;  // times rise; at least one key
    Between between = Between::monotone;
    Beyond beyond = Beyond::hold;
    std::vector<double> slopes = {};  // at the keys; only for monotone

    double at(double time) const;
};

// Throws std::invalid_argument unless there are as many times as values, at least one, all finite,
// and the times rise.
Curve curve_through(std::vector<double> times, std::vector<double> values,
                    Curve::Between = Curve::Between::monotone, Curve::Beyond = Curve::Beyond::hold);

}  // namespace graph
