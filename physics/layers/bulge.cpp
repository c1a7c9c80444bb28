#include "physics/layers/bulge.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

using geometry::Field;
using geometry::FieldProfile;
using geometry::Foot;

std::pair<double, double> bulge_at(const BulgeShape& shape, double t)
{
    const auto [a, w, k, rigid] = shape;
    if (!(a > 0 && t > 0 && t < w)) return {0, 0};
    const double x1 = std::min(0.5 * w, 3 * a / k);
    if (t >= x1) {
        const double v = (t - x1) / (w - x1);
        return {a * (1 - v) * (1 - v) * (1 + 2 * v), -6 * a / (w - x1) * v * (1 - v)};
    }
    const double u = t / x1;
    if (rigid) {
        const double root = std::sqrt(u * (2 - u));
        return {a * root, a / x1 * (1 - u) / std::max(root, 1e-6)};
    }
    return {k * x1 * u * (1 - u) * (1 - u) + a * u * u * (3 - 2 * u),
            k * (1 - u) * (1 - 3 * u) + 6 * a / x1 * u * (1 - u)};
}

double Bulges::highest() const
{
    double most = 0;
    if (width > 0) {
        for (const double a : height) most = std::max(most, a);
    }
    return most;
}

namespace {

// u in 0..1 at which a contribution outside its surface is u^2 (c + m (1 - u)) = f.
double share_of_radius(const FieldProfile& p, double f)
{
    double inside = 1, outside = 0, u = std::sqrt(std::clamp(f / p.c, 0.0, 1.0));
    for (int i = 0; i < 60; ++i) {
        const double excess = u * u * (p.c + p.m * (1 - u)) - f;
        (excess > 0 ? inside : outside) = u;
        double next = u - excess / (u * (2 * p.c + p.m * (2 - 3 * u)));
        if (!(next >= outside && next <= inside)) next = 0.5 * (inside + outside);
        if (std::abs(next - u) <= 1e-15) return next;
        u = next;
    }
    return u;
}

// A and t by the field of one profile: values and their derivatives by f.
struct ByField {
    double A = 0, A_slope = 0, t = 0, t_slope = 0;
};

BulgeShape shape_of(const FieldProfile& p, double a, double w, double own_slope, bool rigid)
{
    if (rigid) return {a, w, own_slope, true};
    const auto [f, slope] = geometry::profile_at(p, p.e + 0.5 * w);
    return {std::min(a, p.c - f + slope * w / 6), w, p.k, false};
}

ByField by_field(const FieldProfile& p, const BulgeShape& shape, double f)
{
    const double u = share_of_radius(p, f);
    const double t = (1 - u) / p.inverse;
    const double t_slope = -1 / (p.inverse * u * (2 * p.c + p.m * (2 - 3 * u)));
    const auto [A, slope] = bulge_at(shape, t);
    return {A, slope * t_slope, t, t_slope};
}

bool alike(const FieldProfile& a, const FieldProfile& b)
{
    return a.k == b.k && a.inverse == b.inverse;
}

}  // namespace

BulgeValue bulge_at(const Meeting& meeting, const Party& other, const Bulges& bulges, const Vec3& p,
                    double f, const Vec3& gradient)
{
    const Field& field = meeting.field(other);
    const bool rigid = meeting.bodies[other.body].matter.rigid;
    const double a = bulges.against(other.body), w = bulges.width;
    BulgeValue value;
    const auto shape = [&](std::uint32_t s) {
        return shape_of(field.profile[s], a, w, bulges.slope, rigid);
    };
    if (!(f > 1e-8 * field.isovalue)) {  // out of the field's reach
        value.t = std::numeric_limits<double>::infinity();
        std::uint32_t nearest = geometry::no_skeleton;
        for (const std::uint32_t s : other.skeletons) {
            const Foot foot = geometry::foot(field, s, p);
            if (!(foot.r - field.profile[s].e < value.t)) continue;
            value.t = foot.r - field.profile[s].e;
            value.t_gradient = foot.n;
            nearest = s;
        }
        if (nearest == geometry::no_skeleton) return value;
        const auto [A, slope] = bulge_at(shape(nearest), value.t);
        value.A = A;
        value.gradient = slope * value.t_gradient;
        return value;
    }
    const FieldProfile& first = field.profile[other.skeletons[0]];
    const bool one = std::all_of(other.skeletons.begin(), other.skeletons.end(),
                                 [&](std::uint32_t s) { return alike(first, field.profile[s]); });
    if (one) {
        const ByField by = by_field(first, shape(other.skeletons[0]), f);
        return {by.A, by.A_slope * gradient, by.t, by.t_slope * gradient};
    }
    double weight = 0;
    Vec3 weight_gradient = Vec3::Zero();
    for (const std::uint32_t s : other.skeletons) {
        const Foot foot = geometry::foot(field, s, p);
        const auto [own, slope] = geometry::profile_at(field.profile[s], foot.r);
        if (!(own > 0)) continue;
        const ByField by = by_field(field.profile[s], shape(s), f);
        const Vec3 w_gradient = 2 * own * slope * foot.n;
        value.A += own * own * by.A;
        value.gradient += own * own * by.A_slope * gradient + by.A * w_gradient;
        value.t += own * own * by.t;
        value.t_gradient += own * own * by.t_slope * gradient + by.t * w_gradient;
        weight += own * own;
        weight_gradient += w_gradient;
    }
    if (!(weight > 0)) return {0, Vec3::Zero(), w, Vec3::Zero()};
    value.A /= weight;
    value.t /= weight;
    value.gradient = (value.gradient - value.A * weight_gradient) / weight;
    value.t_gradient = (value.t_gradient - value.t * weight_gradient) / weight;
    return value;
}

void BulgeSum::add(const BulgeValue& value)
{
    if (!(value.t < width_)) return;
    const double t = std::max(value.t, 1e-9 * width_);
    const double excess = width_ * width_ / (t * t) - 1;
    const double weight = excess * excess;
    const Vec3 gradient = -4 * excess * width_ * width_ / (t * t * t) * value.t_gradient;
    weight_ += weight;
    weight_gradient_ += gradient;
    sum_ += weight * value.A;
    sum_gradient_ += weight * value.gradient + value.A * gradient;
}

std::pair<double, Vec3> BulgeSum::total() const
{
    if (!(weight_ > 0)) return {0, Vec3::Zero()};
    const double A = sum_ / weight_;
    return {A, (sum_gradient_ - A * weight_gradient_) / weight_};
}

}  // namespace physics
