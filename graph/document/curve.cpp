#include "graph/document/curve.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graph {

namespace {

double sign_of(double x)
{
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

double steffen_slope(double h0, double s0, double h1, double s1)
{
    const double p = (s0 * h1 + s1 * h0) / (h0 + h1);
    return (sign_of(s0) + sign_of(s1)) *
           std::min({std::fabs(s0), std::fabs(s1), 0.5 * std::fabs(p)});
}

// The slope at an end from the parabola through the nearest three keys, held to the same bounds.
double end_slope(double h0, double s0, double h1, double s1)
{
    const double p = s0 * (1 + h0 / (h0 + h1)) - s1 * h0 / (h0 + h1);
    if (p * s0 <= 0) return 0;
    return std::fabs(p) > 2 * std::fabs(s0) ? 2 * s0 : p;
}

std::vector<double> slopes_of(const Curve& c)
{
    const std::size_t n = c.times.size();
    std::vector<double> slopes(n, 0.0);
    if (n < 2) return slopes;
    const auto h = [&](std::size_t i) { return c.times[i + 1] - c.times[i]; };
    const auto s = [&](std::size_t i) { return (c.values[i + 1] - c.values[i]) / h(i); };
    for (std::size_t i = 1; i + 1 < n; ++i) {
        slopes[i] = steffen_slope(h(i - 1), s(i - 1), h(i), s(i));
    }
    if (c.beyond == Curve::Beyond::cycle && c.values.front() == c.values.back()) {
        slopes[0] = slopes[n - 1] = steffen_slope(h(n - 2), s(n - 2), h(0), s(0));
    } else if (n == 2) {
        slopes[0] = slopes[1] = s(0);
    } else {
        slopes[0] = end_slope(h(0), s(0), h(1), s(1));
        slopes[n - 1] = end_slope(h(n - 2), s(n - 2), h(n - 3), s(n - 3));
    }
    return slopes;
}

}  // namespace

double Curve::at(double time) const
{
    const double first = times.front(), last = times.back(), span = last - first;
    // A frame at the time of a key may come out just before it: 3 / 30 s and cycles of 0.1 s are
    // rounded differently. One key far away must not coarsen the others.
    const double rounding = 1e-9 * std::min(span, std::max(1.0, std::fabs(time)));
    if (beyond == Beyond::cycle && span > 0 && (time < first || time + rounding >= last)) {
        time = std::max(first, time - span * std::floor((time - first + rounding) / span));
    }
    if (!(time > first)) return values.front();
    if (time + rounding >= last) return values.back();

    const auto after = std::upper_bound(times.begin(), times.end(), time + rounding);
    const auto i = static_cast<std::size_t>(after - times.begin()) - 1;
    const double h = times[i + 1] - times[i], u = std::max(0.0, (time - times[i]) / h);
    const double a = values[i], b = values[i + 1];
    const double low = std::min(a, b), high = std::max(a, b);
    switch (between) {
    case Between::step:
        return a;
    case Between::linear:
        return std::clamp(a + (b - a) * u, low, high);
    case Between::smooth:
        return std::clamp(a + (b - a) * (u * u * (3 - 2 * u)), low, high);
    case Between::monotone:
        break;
    }
    // Hermite's cubic; the clamp only takes off rounding.
    const double u2 = u * u, u3 = u2 * u;
    const double y = a * (2 * u3 - 3 * u2 + 1) + b * (3 * u2 - 2 * u3) +
                     h * (slopes[i] * (u3 - 2 * u2 + u) + slopes[i + 1] * (u3 - u2));
    return std::clamp(y, low, high);
}

Curve curve_through(std::vector<double> times, std::vector<double> values, Curve::Between between,
                    Curve::Beyond beyond)
{
    if (times.empty() || times.size() != values.size()) {
        throw std::invalid_argument("a curve needs at least one key, and one value per time");
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
        if (!std::isfinite(times[i]) || !std::isfinite(values[i])) {
            throw std::invalid_argument("keys must be finite");
        }
        if (i > 0 && !(times[i] > times[i - 1])) {
            throw std::invalid_argument("the times of keys must increase");
        }
    }
    Curve curve{std::move(times), std::move(values), between, beyond};
    if (between == Curve::Between::monotone) curve.slopes = slopes_of(curve);
    return curve;
}

}  // namespace graph
