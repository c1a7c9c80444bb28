#include "geometry/fields/field_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {

FieldProfile make_profile(const Contribution& contribution, double isovalue, double translation)
{
    const auto [e, k, R, s] = contribution;
    const auto reject = [=, e = e, k = k, R = R, s = s](const char* expected) {
        throw std::invalid_argument(fmt::format(
            "a contribution must decrease with distance: expected {}; got thickness {} m, "
            "stiffness {}, radius {} m, stiffening {}, isovalue {}",
            expected, e, k, R, s, isovalue));
    };
    if (!std::isfinite(e + k + R + s + isovalue)) reject("finite numbers");
    if (!(isovalue > 0)) reject("an isovalue above 0");
    if (!(e > 0)) reject("a thickness above 0");
    if (!(R > e)) reject("a radius of influence above the thickness");
    if (!(k > 0)) reject("a stiffness above 0");
    if (!(s >= 0)) reject("a stiffening of 0 or more");
    if (k * (R - e) > 3 * isovalue * (1 + 1e-12)) {
        reject("stiffness * (radius - thickness) <= 3 * isovalue");
    }
    if (!std::isfinite(translation)) {
        throw std::invalid_argument("the translation of a contribution must be finite");
    }
    FieldProfile p{.e = e, .R = R, .c = isovalue, .k = k};
    p.q = 0.5 * k * s / e;
    p.m = 2 * isovalue - k * (R - e);
    p.inverse = 1 / (R - e);
    return moved(p, translation);
}

FieldProfile moved(const FieldProfile& profile, double by)
{
    FieldProfile p = profile;
    p.e += by;
    p.R += by;
    return p;
}

double steepest(const FieldProfile& p, double from, double to)
{
    // Inside it grows with depth. Outside -f' is a parabola in u: its ends and its top.
    double most = std::max(-profile_at(p, from).slope, -profile_at(p, to).slope);
    if (from < p.e && to >= p.e) most = std::max(most, p.k);
    if (p.m > 0) {
        const double u = (p.c + p.m) / (3 * p.m), r = p.R - u / p.inverse;
        if (u < 1 && r > from && r < to) most = std::max(most, -profile_at(p, r).slope);
    }
    return most;
}

}  // namespace geometry
