#include "physics/lattice/membrane.hpp"

// First the kernels, compiled for each kind of processor: a corner (pull_corner), a link
// (add_corner), a strip of cells (pull_strip_of). Then the membrane's making (find_strips,
// make_membrane), what breaks (torn_corners), and the pull of all strips (MembranePull).

#include "geometry/base/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#ifndef PHYSICS_MEMBRANE_CPP  // once for all targets
#define PHYSICS_MEMBRANE_CPP
namespace physics {
inline constexpr std::size_t most_cells_a_strip = 64;
inline constexpr std::size_t room_a_strip = 96;  // whole vectors, and some more
inline constexpr std::size_t strips_a_task = 16;
}  // namespace physics
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/lattice/membrane.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace membrane_kernel {

namespace hn = hwy::HWY_NAMESPACE;

template <class V> struct Triple {
    V x, y, z;
};
template <class V> HWY_INLINE Triple<V> operator+(const Triple<V>& a, const Triple<V>& b)
{
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class V> HWY_INLINE Triple<V> operator-(const Triple<V>& a, const Triple<V>& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class V> HWY_INLINE Triple<V> times(const V& s, const Triple<V>& a)
{
    return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
template <class V> HWY_INLINE V dot(const Triple<V>& a, const Triple<V>& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class V> HWY_INLINE Triple<V> cross(const Triple<V>& a, const Triple<V>& b)
{
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
            hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

// Of a corner with the links e1 and e2, of squared lengths l1 and l2, what it wants added to them,
// R - F, times `weight`: s e1 + e2 x m + flaw and s e2 + m x e1.
template <class V> struct CornerPull {
    V s;
    Triple<V> m, flaw;
};
template <class D, class V>
HWY_INLINE CornerPull<V> pull_corner(D d, const V& weight, const Triple<V>& e1, const Triple<V>& e2,
                                     const V& l1, const V& l2)
{
    using T = hn::TFromD<D>;
    const V one = hn::Set(d, T(1)), tiny = hn::Set(d, T(1e-18));
    const Triple<V> across = cross(e1, e2);
    const V area = hn::Max(hn::Sqrt(dot(across, across)), tiny);
    const V t = hn::Max(hn::Sqrt(hn::Add(hn::Add(l1, l2), hn::Add(area, area))), tiny);
    // 1 / area and 1 / t for one division.
    const V both = hn::Div(one, hn::Mul(area, t));
    const V weighed = hn::Mul(weight, both);
    // A sheet pressed together exactly in its plane does not know to which side to buckle. As all
    // real ones, this has a flaw, which shows where a corner has lost area.
    const V flaw = hn::Mul(hn::Set(d, T(1e-8)), hn::Max(hn::Sub(one, area), hn::Zero(d)));
    return {hn::Mul(weight, hn::Sub(hn::Mul(area, both), one)), times(weighed, across),
            times(hn::Mul(flaw, hn::Mul(t, weighed)), across)};
}

// (b - a) times `scale`, of `count` numbers, rounded up to eight.
template <class T>
HWY_INLINE void subtract(std::size_t count, const double* a, const double* b, double scale, T* to)
{
    const hn::CappedTag<double, 8> d;
    const hn::Rebind<T, decltype(d)> narrow;
    const auto times = hn::Set(d, scale);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto e = hn::Mul(times, hn::Sub(hn::LoadU(d, b + i), hn::LoadU(d, a + i)));
        if constexpr (sizeof(T) == sizeof(double)) {
            hn::StoreU(e, d, to + i);
        } else {
            hn::StoreU(hn::DemoteTo(narrow, e), narrow, to + i);
        }
    }
}

// Adds a corner's pull to what its links want: along themselves, and across. `rest` is the inverse
// of the cell's rest shape where it has flowed.
template <class V> struct LinkPull {
    V along;
    Triple<V> across;
};
template <bool flowed, class D, class V>
HWY_INLINE void add_corner(D d, const V& weight, const V (&rest)[3], const Triple<V>& e1,
                           const Triple<V>& e2, const V& l1, const V& l2, LinkPull<V>& pull1,
                           LinkPull<V>& pull2)
{
    if constexpr (flowed) {
        const Triple<V> f1 = times(rest[0], e1) + times(rest[1], e2);
        const Triple<V> f2 = times(rest[1], e1) + times(rest[2], e2);
        const auto p = pull_corner(d, weight, f1, f2, dot(f1, f1), dot(f2, f2));
        const Triple<V> q1 = times(p.s, f1) + cross(f2, p.m) + p.flaw;
        const Triple<V> q2 = times(p.s, f2) + cross(p.m, f1);
        pull1.across = pull1.across + times(rest[0], q1) + times(rest[1], q2);
        pull2.across = pull2.across + times(rest[1], q1) + times(rest[2], q2);
    } else {
        const auto p = pull_corner(d, weight, e1, e2, l1, l2);
        pull1.along = hn::Add(pull1.along, p.s);
        pull2.along = hn::Add(pull2.along, p.s);
        pull1.across = pull1.across + cross(e2, p.m) + p.flaw;
        pull2.across = pull2.across + cross(p.m, e1);
    }
}

// Adds what the cells on both sides of each particle pull it by: `near` is of the cell behind it,
// `far` of the one before it, a place on; three rows of numbers of either side of the strip.
template <class T, std::size_t most>
HWY_INLINE void add_up_sides(std::size_t count, T (&near)[6][most], T (&far)[6][most], T* low_pulls,
                             T* high_pulls)
{
    const hn::CappedTag<T, 16> d;
    using V = hn::Vec<decltype(d)>;
    const std::size_t lanes = hn::Lanes(d);
    const V zero = hn::Zero(d);
    for (std::size_t k = 0; k < 6; ++k) far[k][0] = near[k][count] = 0;
    for (std::size_t side = 0; side < 2; ++side) {
        T* const to = side == 0 ? low_pulls : high_pulls;
        for (std::size_t i = 0; i < count + 1; i += lanes) {
            HWY_ALIGN T out[4 * 16];
            V sum[3];
            for (std::size_t k = 0; k < 3; ++k) {
                sum[k] = hn::Add(hn::LoadU(d, near[3 * side + k] + i),
                                 hn::LoadU(d, far[3 * side + k] + i));
            }
            const std::size_t left = count + 1 - i;
            T* const here = left < lanes ? out : to + 4 * i;
            hn::StoreInterleaved4(sum[0], sum[1], sum[2], zero, d, here);
            if (left < lanes) std::copy_n(out, 4 * left, to + 4 * i);
        }
    }
}

// `low` and `high` hold the places of count + 1 particles each, with room for three numbers and
// a vector more. `scale` is one row of `count`, or four rows `stride` apart, of the corners; `rest`
// three rows or null; both with room for a vector more. Pulls, four numbers a particle, go to
// `low_pulls` and `high_pulls`.
template <bool flowed, class T>
HWY_INLINE void pull_strip_of(std::size_t count, const double* low, const double* high,
                              double inverse_h, const T* scale, std::size_t scale_stride,
                              const T* rest, T* low_pulls, T* high_pulls)
{
    constexpr std::size_t most = room_a_strip;
    HWY_ALIGN T along_low[3 * most], along_high[3 * most], across[3 * most];
    subtract(3 * count, low, low + 3, inverse_h, along_low);
    subtract(3 * count, high, high + 3, inverse_h, along_high);
    subtract(3 * count + 3, low, high, inverse_h, across);

    const hn::CappedTag<T, 16> d;
    using V = hn::Vec<decltype(d)>;
    const std::size_t lanes = hn::Lanes(d);
    const auto links = [&](const T* from) HWY_ATTR {
        Triple<V> e;
        hn::LoadInterleaved3(d, from, e.x, e.y, e.z);
        return e;
    };
    // Rows of what the cells pull their particles by: at 0 and v, and one place on, at u and u + v.
    HWY_ALIGN T near[6][most], far[6][most];
    const auto keep = [&](T* row, const Triple<V>& p) HWY_ATTR {
        hn::StoreU(p.x, d, row);
        hn::StoreU(p.y, d, row + most);
        hn::StoreU(p.z, d, row + 2 * most);
    };
    const V zero = hn::Zero(d);
    for (std::size_t i = 0; i < count; i += lanes) {
        const Triple<V> low_u = links(along_low + 3 * i), high_u = links(along_high + 3 * i);
        const Triple<V> near_v = links(across + 3 * i), far_v = links(across + 3 * i + 3);
        const V low_sq = dot(low_u, low_u), high_sq = dot(high_u, high_u);
        const V near_sq = dot(near_v, near_v), far_sq = dot(far_v, far_v);
        V shape[3] = {zero, zero, zero};
        if constexpr (flowed) {
            for (std::size_t k = 0; k < 3; ++k) shape[k] = hn::LoadU(d, rest + k * most + i);
        }
        LinkPull<V> to_low{zero, {zero, zero, zero}}, to_high = to_low, to_near = to_low,
                                                      to_far = to_low;
        const auto weight = [&](std::size_t corner) HWY_ATTR {
            return hn::LoadU(d, scale + corner * scale_stride + i);
        };
        add_corner<flowed>(d, weight(0), shape, low_u, near_v, low_sq, near_sq, to_low, to_near);
        add_corner<flowed>(d, weight(1), shape, low_u, far_v, low_sq, far_sq, to_low, to_far);
        add_corner<flowed>(d, weight(2), shape, high_u, near_v, high_sq, near_sq, to_high, to_near);
        add_corner<flowed>(d, weight(3), shape, high_u, far_v, high_sq, far_sq, to_high, to_far);
        const Triple<V> of_low = to_low.across + times(to_low.along, low_u);
        const Triple<V> of_high = to_high.across + times(to_high.along, high_u);
        const Triple<V> of_near = to_near.across + times(to_near.along, near_v);
        const Triple<V> of_far = to_far.across + times(to_far.along, far_v);
        // Each link is drawn out by its sum: its far end forth, its near end back.
        const Triple<V> none_yet{zero, zero, zero};
        keep(near[0] + i, none_yet - (of_low + of_near));
        keep(far[0] + i + 1, of_low - of_far);
        keep(near[3] + i, of_near - of_high);
        keep(far[3] + i + 1, of_high + of_far);
    }
    add_up_sides(count, near, far, low_pulls, high_pulls);
}

template <class T>
void pull_strip(std::size_t count, const double* low, const double* high, double inverse_h,
                const T* scale, std::size_t stride, const T* rest, T* low_pulls, T* high_pulls)
{
    if (rest) {
        pull_strip_of<true>(count, low, high, inverse_h, scale, stride, rest, low_pulls,
                            high_pulls);
    } else {
        pull_strip_of<false>(count, low, high, inverse_h, scale, stride, rest, low_pulls,
                             high_pulls);
    }
}

}  // namespace membrane_kernel

void pull_strip_float(std::size_t count, const double* low, const double* high, double inverse_h,
                      const float* scale, std::size_t scale_stride, const float* rest,
                      float* low_pulls, float* high_pulls)
{
    membrane_kernel::pull_strip(count, low, high, inverse_h, scale, scale_stride, rest, low_pulls,
                                high_pulls);
}
void pull_strip_double(std::size_t count, const double* low, const double* high, double inverse_h,
                       const double* scale, std::size_t scale_stride, const double* rest,
                       double* low_pulls, double* high_pulls)
{
    membrane_kernel::pull_strip(count, low, high, inverse_h, scale, scale_stride, rest, low_pulls,
                                high_pulls);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(pull_strip_float);
HWY_EXPORT(pull_strip_double);

namespace {

void pull_strip(std::size_t count, const double* low, const double* high, double inverse_h,
                const float* scale, std::size_t scale_stride, const float* rest, float* low_pulls,
                float* high_pulls)
{
    HWY_DYNAMIC_DISPATCH(pull_strip_float)
    (count, low, high, inverse_h, scale, scale_stride, rest, low_pulls, high_pulls);
}
void pull_strip(std::size_t count, const double* low, const double* high, double inverse_h,
                const double* scale, std::size_t scale_stride, const double* rest,
                double* low_pulls, double* high_pulls)
{
    HWY_DYNAMIC_DISPATCH(pull_strip_double)
    (count, low, high, inverse_h, scale, scale_stride, rest, low_pulls, high_pulls);
}

// Cells one after another along u, and where their pulls go.
void find_strips(Membrane& membrane, const std::vector<Membrane::Cell>& cell, std::size_t particles)
{
    std::vector<std::array<std::uint32_t, 4>> pulls(particles,
                                                    {no_cell, no_cell, no_cell, no_cell});
    const auto add = [&](std::uint32_t particle, std::uint32_t row) {
        auto& of = pulls[particle];
        const auto free = std::find(of.begin(), of.end(), no_cell);
        if (free == of.end()) {
            throw std::invalid_argument(fmt::format("expected at most four cells of a plane to "
                                                    "meet at a corner, found more at corner {}",
                                                    particle));
        }
        *free = row;
    };
    for (std::size_t first = 0, end = 0; first < cell.size(); first = end) {
        end = first + 1;
        while (end < cell.size() && end - first < most_cells_a_strip &&
               cell[end][0] == cell[end - 1][1] && cell[end][2] == cell[end - 1][3]) {
            ++end;
        }
        const auto count = std::uint32_t(end - first), row = std::uint32_t(membrane.rows);
        const auto across = [&](std::uint32_t k) -> std::array<std::uint32_t, 2> {
            if (k == count) return {cell[end - 1][1], cell[end - 1][3]};
            return {cell[first + k][0], cell[first + k][2]};
        };
        const auto [low, high] = across(0);
        // Vectors read on past the end of a row.
        bool in_order = std::max(low, high) + count + 4 < particles;
        for (std::uint32_t k = 0; k <= count; ++k) {
            in_order &= across(k) == std::array{low + k, high + k};
            add(across(k)[0], row + k);
            add(across(k)[1], row + count + 1 + k);
        }
        if (in_order) {
            membrane.strip.push_back({std::uint32_t(first), count, row, true, low, high});
        } else {
            const auto at = std::uint32_t(membrane.link.size());
            membrane.strip.push_back({std::uint32_t(first), count, row, false, at, 0});
            for (std::uint32_t k = 0; k <= count; ++k) membrane.link.push_back(across(k));
        }
        membrane.rows += 2 * (count + 1);
    }
    for (std::uint32_t i = 0; i < particles; ++i) {
        auto next = i > 0 ? pulls[i - 1] : pulls[i];
        for (auto& row : next) row += row != no_cell;
        if (i == 0 || pulls[i] != next) membrane.run.push_back({i, pulls[i]});
    }
}

}  // namespace

std::size_t Membrane::bytes() const
{
    return strip.size() * sizeof(strip[0]) + link.size() * sizeof(link[0]) +
           run.size() * sizeof(run[0]) +
           (stiffness.size() + bend.size() + mass.size()) * sizeof(float);
}

Membrane make_membrane(const geometry::Cubes& cubes, int axis)
{
    Membrane out;
    out.h = cubes.size;
    out.axes = {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
    const unsigned u = 1u << out.axes[0], v = 1u << out.axes[1];
    for (auto* of_cells : {&out.stiffness, &out.bend, &out.mass}) of_cells->reserve(cubes.count());
    std::vector<Membrane::Cell> cell;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto& corners = cubes.corners[c];
        cell.push_back({corners[0], corners[u], corners[v], corners[u | v]});
        out.stiffness.push_back(float(cubes.young[c] * cubes.fill[c] * cubes.size));
        const double nu = cubes.poisson[c];
        out.bend.push_back(float(cubes.fill[c] * cubes.fill[c] / (1 - nu * nu)));
        out.mass.push_back(float(cubes.mass[c]));
    }
    find_strips(out, cell, cubes.corner_count());
    return out;
}

std::vector<std::uint8_t> torn_corners(const Membrane& membrane,
                                       std::span<const std::uint32_t> broken)
{
    std::vector<std::uint8_t> torn(membrane.cells(), 0);
    const auto& axes = membrane.axes;
    const auto is_broken = [&](std::uint32_t from, int along) {
        return std::binary_search(broken.begin(), broken.end(), 3 * from + std::uint32_t(along));
    };
    membrane.for_each_cell([&](std::size_t c, const Membrane::Cell& cell) {
        unsigned mask = 0;
        if (is_broken(cell[0], axes[0])) mask |= 0b0011u;  // links are between 0 and u,
        if (is_broken(cell[2], axes[0])) mask |= 0b1100u;  // v and u + v,
        if (is_broken(cell[0], axes[1])) mask |= 0b0101u;  // 0 and v,
        if (is_broken(cell[1], axes[1])) mask |= 0b1010u;  // u and u + v
        torn[c] = std::uint8_t(mask);
    });
    return torn;
}

std::vector<double> sum_at_corners(const Membrane& membrane, std::span<const double> of_cell,
                                   std::size_t particles)
{
    std::vector<double> row(membrane.rows), sum(particles, 0);
    geometry::parallel_for(
        membrane.strip.size(), strips_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) {
                const MembraneStrip& strip = membrane.strip[s];
                const double* const of = of_cell.data() + strip.first;
                double* const low = row.data() + strip.row;
                double* const high = low + strip.count + 1;
                for (std::uint32_t k = 0; k <= strip.count; ++k) {
                    low[k] = (k > 0 ? of[k - 1] : 0) + (k < strip.count ? of[k] : 0);
                    high[k] = low[k];
                }
            }
        });
    const auto& runs = membrane.run;
    geometry::parallel_for(runs.size(), strips_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r) {
            const std::size_t first = runs[r].first;
            const std::size_t past = r + 1 < runs.size() ? runs[r + 1].first : particles;
            for (const std::uint32_t from : runs[r].rows) {
                if (from == no_cell) break;
                for (std::size_t i = first; i < past; ++i) sum[i] += row[from + (i - first)];
            }
        }
    });
    return sum;
}

template <class T>
void MembranePull<T>::pull(const Membrane& membrane, const MembraneState& state,
                           std::span<const T> share, const std::vector<geometry::Vec3>& x)
{
    pulls_.resize(4 * membrane.rows);
    geometry::parallel_for(
        membrane.strip.size(), strips_a_task, [&](std::size_t begin, std::size_t end) {
            constexpr std::size_t most = room_a_strip;
            alignas(64) double low[3 * most] = {}, high[3 * most] = {};
            alignas(64) T scale[4 * most] = {}, rest[3 * most] = {};
            const T quarter = T(membrane.h / 4);
            for (std::size_t s = begin; s < end; ++s) {
                const MembraneStrip& strip = membrane.strip[s];
                const std::size_t first = strip.first, count = strip.count;
                for (std::uint32_t k = 0; k <= count && !strip.in_order; ++k) {
                    const auto [low_one, high_one] = membrane.across(strip, k);
                    // Number by number: three are too few for a call of memmove().
                    for (std::size_t i = 0; i < 3; ++i) {
                        low[3 * k + i] = x[low_one][Eigen::Index(i)];
                        high[3 * k + i] = x[high_one][Eigen::Index(i)];
                    }
                }
                const bool torn = !state.torn.empty();
                for (std::size_t k = 0; k < count; ++k) {
                    const T whole = quarter * share[first + k];
                    if (!torn) {
                        scale[k] = whole;
                        continue;
                    }
                    for (std::size_t i = 0; i < 4; ++i) {
                        scale[i * most + k] = state.torn[first + k] >> i & 1u ? T(0) : whole;
                    }
                }
                for (std::size_t k = 0; k < count && !state.rest.empty(); ++k) {
                    for (std::size_t i = 0; i < 3; ++i) {
                        rest[i * most + k] = T(state.rest[3 * (first + k) + i]);
                    }
                }
                T* const low_pulls = pulls_.data() + 4 * std::size_t(strip.row);
                pull_strip(count, strip.in_order ? x[strip.low].data() : low,
                           strip.in_order ? x[strip.high].data() : high, 1 / membrane.h, scale,
                           torn ? most : 0, state.rest.empty() ? nullptr : rest, low_pulls,
                           low_pulls + 4 * (count + 1));
            }
        });
}

template <class T>
void MembranePull<T>::gather(const Membrane& membrane, std::size_t first, std::size_t count,
                             T* to) const
{
    using Quad = Eigen::Array<T, 4, 1>;
    auto run = std::upper_bound(membrane.run.begin(), membrane.run.end(), first,
                                [](std::size_t i, const MembraneRun& r) { return i < r.first; });
    for (std::size_t i = first, end = first; i < first + count; i = end, ++run) {
        end = run == membrane.run.end() ? first + count
                                        : std::min<std::size_t>(first + count, run->first);
        const MembraneRun& r = *(run - 1);
        const T* from[4];
        std::size_t rows = 0;
        while (rows < 4 && r.rows[rows] != no_cell) {
            from[rows] = pulls_.data() + 4 * (std::size_t(r.rows[rows]) + (i - r.first));
            ++rows;
        }
        for (std::size_t k = 0; k < end - i; ++k) {
            Quad sum = Quad::Zero();
            for (std::size_t p = 0; p < rows; ++p) sum += Eigen::Map<const Quad>(from[p] + 4 * k);
            Eigen::Map<Quad>(to + 4 * (i - first + k)) = sum;
        }
    }
}

template class MembranePull<float>;
template class MembranePull<double>;

}  // namespace physics
#endif
