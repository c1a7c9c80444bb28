#include "physics/lattice/lattice_pull.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/lattice/lattice_pull.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace pull_kernel {

namespace hn = hwy::HWY_NAMESPACE;

// Sums are kept for eight particles apart, however many fit a vector, so that they come out alike.
constexpr std::size_t group = 8;

template <class D, class T> HWY_INLINE auto widened(D d, const T* from)
{
    if constexpr (sizeof(T) == sizeof(double)) {
        return hn::LoadU(d, from);
    } else {
        const hn::Rebind<float, D> narrow;
        return hn::PromoteTo(d, hn::LoadU(narrow, from));
    }
}

// Adds the momentum of a vectorful of particles to `sums`, a vector for each number of
// PullMomentum.
template <class V>
HWY_INLINE void add_momentum(const V& mass, const V (&x)[3], const V (&impulse)[3], V* sums)
{
    V moment[3];
    for (std::size_t c = 0; c < 3; ++c) {
        moment[c] = hn::Mul(mass, x[c]);
        sums[c] = hn::Add(sums[c], hn::Mul(mass, impulse[c]));
        sums[6 + c] = hn::Add(sums[6 + c], moment[c]);
    }
    for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
        const V turn = hn::Sub(hn::Mul(moment[a], impulse[b]), hn::Mul(moment[b], impulse[a]));
        sums[3 + c] = hn::Add(sums[3 + c], turn);
    }
    for (std::size_t a = 0, k = 9; a < 3; ++a) {
        for (std::size_t b = a; b < 3; ++b, ++k) {
            sums[k] = hn::Add(sums[k], hn::Mul(moment[a], x[b]));
        }
    }
}

// One vectorful of particles from `i` on; `sums` has a vector for each number of PullMomentum.
template <class T, class D, class V>
HWY_INLINE void pull_some(D d, const PulledParticles<T>& p, std::size_t i, const double* origin,
                          double stiffness, double damping, V* sums)
{
    const hn::Rebind<T, D> dt;
    const hn::Rebind<float, D> df;
    using W = hn::Vec<decltype(dt)>;
    V x[3], v[3], impulse[3];
    hn::LoadInterleaved3(d, p.x + 3 * i, x[0], x[1], x[2]);
    hn::LoadInterleaved3(d, p.v + 3 * i, v[0], v[1], v[2]);
    W goal[4], stretch[4];
    hn::LoadInterleaved4(dt, p.goal + 4 * i, goal[0], goal[1], goal[2], goal[3]);
    if (p.stretch) {
        hn::LoadInterleaved4(dt, p.stretch + 4 * i, stretch[0], stretch[1], stretch[2], stretch[3]);
    }
    hn::Vec<decltype(df)> before[3];
    hn::LoadInterleaved3(df, p.before + 3 * i, before[0], before[1], before[2]);
    const W weight = hn::LoadU(dt, p.weight + i);
    const V mass = hn::LoadU(d, p.mass + i);
    W held_by, inverse_mass;
    if constexpr (sizeof(T) == sizeof(double)) {
        held_by = widened(d, p.held_by + i);
        inverse_mass = hn::Div(hn::Set(d, 1.0), mass);
    } else {
        held_by = hn::LoadU(df, p.held_by + i);
        inverse_mass = hn::DemoteTo(dt, hn::Div(hn::Set(d, 1.0), mass));
    }
    const V stiff = hn::Set(d, stiffness), damped = hn::Set(d, damping);
    for (std::size_t c = 0; c < 3; ++c) {
        x[c] = hn::Sub(x[c], hn::Set(d, origin[c]));
        W place;
        V last;
        if constexpr (sizeof(T) == sizeof(double)) {
            place = x[c];
        } else {
            place = hn::DemoteTo(dt, x[c]);
        }
        W away = hn::Mul(held_by, hn::Sub(goal[c], hn::Mul(weight, place)));
        if (p.stretch) away = hn::Add(away, hn::Mul(inverse_mass, stretch[c]));
        last = hn::PromoteTo(d, before[c]);
        V now;
        if constexpr (sizeof(T) == sizeof(double)) {
            now = away;
            before[c] = hn::DemoteTo(df, away);
        } else {
            now = hn::PromoteTo(d, away);
            before[c] = away;
        }
        impulse[c] = hn::Add(hn::Mul(stiff, now), hn::Mul(damped, hn::Sub(now, last)));
        v[c] = hn::Add(v[c], impulse[c]);
    }
    hn::StoreInterleaved3(v[0], v[1], v[2], d, p.v + 3 * i);
    hn::StoreInterleaved3(before[0], before[1], before[2], df, p.before + 3 * i);
    add_momentum(mass, x, impulse, sums);
}

template <class T>
void pull_all(const PulledParticles<T>& p, const double* origin, double stiffness, double damping,
              double* out)
{
    const hn::CappedTag<double, group> d;
    using V = hn::Vec<decltype(d)>;
    constexpr std::size_t lanes = hn::MaxLanes(decltype(d)()), parts = group / lanes;
    constexpr std::size_t numbers = PullMomentum::numbers;
    V sums[parts][numbers];
    for (auto& part : sums) {
        for (V& s : part) s = hn::Zero(d);
    }
    std::size_t i = 0;
    for (; i + group <= p.count; i += group) {
        for (std::size_t k = 0; k < parts; ++k) {
            pull_some(d, p, i + k * lanes, origin, stiffness, damping, sums[k]);
        }
    }
    if (i < p.count) {
        // The last few beside particles that nothing pulls, at the origin.
        const std::size_t rest = p.count - i;
        double x[3 * group] = {}, v[3 * group] = {}, mass[group] = {};
        float before[3 * group] = {}, held_by[group] = {};
        T goal[4 * group] = {}, weight[group] = {}, stretch[4 * group] = {};
        std::copy_n(p.x + 3 * i, 3 * rest, x);
        std::copy_n(p.v + 3 * i, 3 * rest, v);
        std::copy_n(p.before + 3 * i, 3 * rest, before);
        std::copy_n(p.goal + 4 * i, 4 * rest, goal);
        std::copy_n(p.weight + i, rest, weight);
        std::copy_n(p.held_by + i, rest, held_by);
        std::copy_n(p.mass + i, rest, mass);
        if (p.stretch) std::copy_n(p.stretch + 4 * i, 4 * rest, stretch);
        for (std::size_t k = rest; k < group; ++k) {
            std::copy_n(origin, 3, x + 3 * k);
            mass[k] = 1;
        }
        const PulledParticles<T> few{
            group, x, v, before, goal, weight, held_by, mass, p.stretch ? stretch : nullptr};
        for (std::size_t k = 0; k < parts; ++k) {
            pull_some(d, few, k * lanes, origin, stiffness, damping, sums[k]);
        }
        std::copy_n(v, 3 * rest, p.v + 3 * i);
        std::copy_n(before, 3 * rest, p.before + 3 * i);
    }
    for (std::size_t s = 0; s < numbers; ++s) {
        HWY_ALIGN double apart[group];
        for (std::size_t k = 0; k < parts; ++k) hn::StoreU(sums[k][s], d, apart + k * lanes);
        out[s] = 0;
        for (const double a : apart) out[s] += a;
    }
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE void push_some(D d, const CommonPush& p, double* x, double* v, V (&sums)[3])
{
    V at[3], speed[3], away[3];
    hn::LoadInterleaved3(d, x, at[0], at[1], at[2]);
    hn::LoadInterleaved3(d, v, speed[0], speed[1], speed[2]);
    for (std::size_t c = 0; c < 3; ++c) {
        away[c] = hn::Sub(at[c], hn::Set(d, p.pivot[Eigen::Index(c)]));
    }
    const V dt = hn::Set(d, p.dt);
    for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
        const V turn = hn::Sub(hn::Mul(hn::Set(d, p.spin[Eigen::Index(a)]), away[b]),
                               hn::Mul(hn::Set(d, p.spin[Eigen::Index(b)]), away[a]));
        speed[c] = hn::Add(speed[c], hn::Sub(hn::Set(d, p.push[Eigen::Index(c)]), turn));
        at[c] = hn::Add(at[c], hn::Mul(dt, speed[c]));
        sums[c] = hn::Add(sums[c], at[c]);
    }
    hn::StoreInterleaved3(at[0], at[1], at[2], d, x);
    hn::StoreInterleaved3(speed[0], speed[1], speed[2], d, v);
}

void push_all(const CommonPush& p, std::size_t count, double* x, double* v, double* out)
{
    const hn::CappedTag<double, group> d;
    using V = hn::Vec<decltype(d)>;
    constexpr std::size_t lanes = hn::MaxLanes(decltype(d)()), parts = group / lanes;
    V sums[parts][3];
    for (auto& part : sums) {
        for (V& s : part) s = hn::Zero(d);
    }
    std::size_t i = 0;
    for (; i + group <= count; i += group) {
        for (std::size_t k = 0; k < parts; ++k) {
            const std::size_t at = 3 * (i + k * lanes);
            push_some(d, p, x + at, v + at, sums[k]);
        }
    }
    for (std::size_t c = 0; c < 3; ++c) {
        HWY_ALIGN double apart[group];
        for (std::size_t k = 0; k < parts; ++k) hn::StoreU(sums[k][c], d, apart + k * lanes);
        out[c] = 0;
        for (const double a : apart) out[c] += a;
    }
    for (; i < count; ++i) {
        const hn::CappedTag<double, 1> one;
        hn::Vec<decltype(one)> sum[3] = {hn::Zero(one), hn::Zero(one), hn::Zero(one)};
        push_some(one, p, x + 3 * i, v + 3 * i, sum);
        for (std::size_t c = 0; c < 3; ++c) out[c] += hn::GetLane(sum[c]);
    }
}

}  // namespace pull_kernel

void pull_float(const PulledParticles<float>& p, const double* origin, double stiffness,
                double damping, double* out)
{
    pull_kernel::pull_all(p, origin, stiffness, damping, out);
}
void pull_double(const PulledParticles<double>& p, const double* origin, double stiffness,
                 double damping, double* out)
{
    pull_kernel::pull_all(p, origin, stiffness, damping, out);
}

void push_double(const CommonPush& p, std::size_t count, double* x, double* v, double* out)
{
    pull_kernel::push_all(p, count, x, v, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(pull_float);
HWY_EXPORT(pull_double);
HWY_EXPORT(push_double);

template <>
PullMomentum pull_particles(const PulledParticles<float>& particles, const geometry::Vec3& origin,
                            double stiffness, double damping)
{
    PullMomentum out;
    HWY_DYNAMIC_DISPATCH(pull_float)
    (particles, origin.data(), stiffness, damping, out.sum.data());
    return out;
}
template <>
PullMomentum pull_particles(const PulledParticles<double>& particles, const geometry::Vec3& origin,
                            double stiffness, double damping)
{
    PullMomentum out;
    HWY_DYNAMIC_DISPATCH(pull_double)
    (particles, origin.data(), stiffness, damping, out.sum.data());
    return out;
}

geometry::Vec3 push_together(const CommonPush& push, std::size_t count, double* x, double* v)
{
    geometry::Vec3 sum;
    HWY_DYNAMIC_DISPATCH(push_double)(push, count, x, v, sum.data());
    return sum;
}

}  // namespace physics
#endif
