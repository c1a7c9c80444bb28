#include "physics/lattice/matched_regions.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/regions/region_sums.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace physics {

using geometry::Mat3;
using geometry::Vec3;

namespace {

// How the matter of a region is spread about some point: sums of M, M X and M X X^T.
struct Spread {
    double mass;
    Vec3 moment;
    Mat3 about;
};

// B^-1 of a region in lattice steps (packed xx, xy, xz, yy, yz, zz), also where it is flat or a
// line: there it is 0 across.
std::array<float, 6> inverse_of(const Spread& of)
{
    const Mat3 b = of.about - of.moment * of.moment.transpose() / of.mass;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(b);
    Vec3 inverse = eigen.eigenvalues();
    const double largest = inverse.maxCoeff();
    for (double& v : inverse) v = v > 1e-9 * largest ? 1 / v : 0;
    const Mat3 m = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
    return {float(m(0, 0)), float(m(0, 1)), float(m(0, 2)),
            float(m(1, 1)), float(m(1, 2)), float(m(2, 2))};
}

// Calls visit(slot, spread) for the regions of the slots that `which` says, each about its own
// particle. Sums of M X X^T need one more moment than collect() takes, so M X goes in as what is
// summed.
void for_each_spread(const LatticeRegions& regions, std::span<const float> mass,
                     const std::function<Vec3(std::size_t)>& place,
                     const std::function<bool(std::size_t)>& which,
                     const std::function<void(std::size_t, const Spread&)>& visit)
{
    RegionSums<double> sums(regions);
    auto& f = sums.particles;
    // M (X - X_r) (X - X_r)^T summed = moments of M X, less X_r times those of M.
    geometry::parallel_for(regions.particles, 2048, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 p = place(i);
            const double m = double(mass[i]);
            f[i] = {m * p[0], m * p[1], m * p[2], m};
        }
    });
    collect<double>(regions, sums, [&](std::size_t first, std::span<const Quad<double>> slots) {
        for (std::size_t k = 0; 4 * k < slots.size(); ++k) {
            const std::uint32_t r = regions.particle[first + k];
            if (r == none || !which(first + k)) continue;
            const auto* const sum = slots.data() + 4 * k;
            const Vec3 at = place(r);
            Spread out{sum[0][3], Vec3::Zero(), Mat3::Zero()};
            for (std::size_t d = 1; d <= regions.sides(); ++d) {
                const int axis = regions.axes[d - 1];
                out.moment[axis] = sum[d][3];
                out.about.col(axis) = sum[d].head<3>().matrix() - sum[d][3] * at;
            }
            visit(first + k, out);
        }
    });
}

template <class T> RegionVolume<T> volume_of(const Spread& of)
{
    constexpr double flat = 1e-3;  // of the trace; less is more rounding than extent
    const Mat3 b = of.about - of.moment * of.moment.transpose() / of.mass;
    const double size = b.trace();
    Vec3 spread = b.diagonal();
    Mat3 axes = Mat3::Identity();
    if ((b - Mat3(spread.asDiagonal())).cwiseAbs().maxCoeff() > 1e-12 * size) {
        const Eigen::SelfAdjointEigenSolver<Mat3> eigen(b);
        spread = eigen.eigenvalues();
        axes = eigen.eigenvectors();
    }
    if (!(spread.minCoeff() > flat * size)) return {};
    const double third = std::cbrt(spread.prod());
    const Vec3 inverse_root = std::sqrt(third) * spread.cwiseSqrt().cwiseInverse();
    const Mat3 root = axes * inverse_root.asDiagonal() * axes.transpose();
    return {
        {T(root(0, 0)), T(root(0, 1)), T(root(0, 2)), T(root(1, 1)), T(root(1, 2)), T(root(2, 2))},
        T(1 / third)};
}

}  // namespace

template <class T>
void find_twist(const LatticeRegions& regions, std::span<const float> mass,
                const std::function<std::array<double, 2>(std::size_t)>& place,
                const std::function<bool(std::size_t)>& which, std::vector<RegionTwist<T>>& twist)
{
    // Sums of M times 1, x, y and x y, and their moments about the region's own particle: with its
    // place (x0, y0), those of x^2 are moments of M x less x0 times M, and so on.
    RegionSums<double> sums(regions);
    auto& f = sums.particles;
    for (std::size_t i = 0; i < regions.particles; ++i) {
        const double m = double(mass[i]);
        const auto [x, y] = place(i);
        f[i] = {m, m * x, m * y, m * x * y};
    }
    const double loose = 1 - twist_share(regions.half_width);
    twist.resize(regions.slots());
    collect<double>(regions, sums, [&](std::size_t first, std::span<const Quad<double>> slots) {
        for (std::size_t s = first; s < first + slots.size() / 4; ++s) {
            if (regions.particle[s] == none || !which(s)) continue;
            const auto* const q = slots.data() + 4 * (s - first);
            const auto [x0, y0] = place(regions.particle[s]);
            const double xx = q[1][1] - x0 * q[1][0], yy = q[2][2] - y0 * q[2][0];
            const double xxy = q[3][1] - x0 * q[3][0], xyy = q[3][2] - y0 * q[3][0];
            const double xxyy = q[3][3] - x0 * q[3][2] - y0 * q[3][1] + x0 * y0 * q[3][0];
            Mat3 m;
            m << q[0][0], q[1][0], q[2][0], q[1][0], xx, q[3][0], q[2][0], q[3][0], yy;
            const Vec3 right(q[3][0], xxy, xyy);
            const Eigen::LDLT<Mat3> solver(m);
            const Vec3 straight = solver.solve(right);
            const double b = xxyy - straight.dot(right);
            // Regions that are a line, or hold no more than three corners, have no twist.
            const bool twists = solver.vectorD().minCoeff() > 1e-9 * m.trace() &&
                                straight.allFinite() && b > 1e-9 * m.trace();
            twist[s] = {};
            if (twists) twist[s] = {T(straight[1]), T(straight[2]), T(loose / b)};
        }
    });
}
template void find_twist(const LatticeRegions&, std::span<const float>,
                         const std::function<std::array<double, 2>(std::size_t)>&,
                         const std::function<bool(std::size_t)>&, std::vector<RegionTwist<float>>&);
template void find_twist(const LatticeRegions&, std::span<const float>,
                         const std::function<std::array<double, 2>(std::size_t)>&,
                         const std::function<bool(std::size_t)>&,
                         std::vector<RegionTwist<double>>&);

template <class T>
void find_volume(const LatticeRegions& regions, std::span<const float> mass,
                 const std::function<Vec3(std::size_t)>& place,
                 const std::function<bool(std::size_t)>& which,
                 std::vector<RegionVolume<T>>& volume)
{
    volume.resize(regions.slots());
    for_each_spread(regions, mass, place, which,
                    [&](std::size_t s, const Spread& spread) { volume[s] = volume_of<T>(spread); });
}
template void find_volume(const LatticeRegions&, std::span<const float>,
                          const std::function<Vec3(std::size_t)>&,
                          const std::function<bool(std::size_t)>&,
                          std::vector<RegionVolume<float>>&);
template void find_volume(const LatticeRegions&, std::span<const float>,
                          const std::function<Vec3(std::size_t)>&,
                          const std::function<bool(std::size_t)>&,
                          std::vector<RegionVolume<double>>&);

void find_inverse_spread(const LatticeRegions& regions, std::span<const float> mass,
                         const std::function<Vec3(std::size_t)>& place,
                         const std::function<bool(std::size_t)>& which, std::vector<float>& spread)
{
    spread.resize(6 * regions.slots(), 0.0f);
    for_each_spread(regions, mass, place, which, [&](std::size_t s, const Spread& of) {
        const auto packed = inverse_of(of);
        std::copy(packed.begin(), packed.end(), spread.begin() + std::ptrdiff_t(6 * s));
    });
}

void find_rates(MatchedRegions& matched, const std::vector<RegionMatter>& matter, double h)
{
    const LatticeRegions& regions = matched.regions;
    RegionSums<double> sums(regions);
    for (std::size_t i = 0; i < matter.size(); ++i) {
        sums.particles[i] = {matter[i][0], matter[i][1], matter[i][2], matter[i][3]};
    }
    collect<double>(regions, sums, [&](std::size_t first, std::span<const Quad<double>> slots) {
        for (std::size_t s = first; s < first + slots.size() / 4; ++s) {
            if (regions.particle[s] == none) continue;
            const Quad<double>& total = slots[4 * (s - first)];
            const auto rates =
                rates_of({total[0], total[1], total[2], total[3]}, regions.half_width, h);
            matched.rate_sq[s] = rates.rate_sq;
            if (regions.flat) matched.bend_sq[s] = rates.bend_sq;
            if (matched.poisson.empty()) continue;
            matched.poisson[s] = rates.poisson;
            matched.volume_gain[s] = rates.volume_gain;
        }
    });
}

MatchedRegions match_regions(LatticeRegions found, const Lattice& lattice,
                             const std::vector<RegionMatter>& matter, double h, bool with_spread)
{
    MatchedRegions out;
    out.regions = std::move(found);
    const LatticeRegions& regions = out.regions;
    const std::size_t n = lattice.count();
    const std::vector<std::uint32_t> held_by = count_holders(regions);
    out.mass.reserve(n);
    out.held_by.reserve(n);
    out.rate_sq.resize(regions.slots(), 0.0f);
    if (regions.flat) out.bend_sq.resize(regions.slots(), 0.0f);
    for (std::size_t i = 0; i < n; ++i) {
        const auto holders = double(held_by[i]);
        out.mass.push_back(float(matter[i][1] / holders));
        out.held_by.push_back(float(1 / holders));
    }
    find_rates(out, matter, h);
    find_spread(out, lattice, with_spread, [](std::size_t) { return true; });
    return out;
}

void add_volume(MatchedRegions& matched, const Lattice& lattice,
                const std::vector<RegionMatter>& matter, double h)
{
    matched.poisson.resize(matched.regions.slots(), 0.0f);
    matched.volume_gain.resize(matched.regions.slots(), 0.0f);
    find_rates(matched, matter, h);
    find_spread(matched, lattice, false, [](std::size_t) { return true; });
}

// s^2 = E / (rho h^2 m2), with E V and m summed over the region.
RegionRates rates_of(const RegionMatter& matter, int half_width, double h)
{
    const double w = half_width, m2 = mean_square_place(w), m4 = mean_fourth_place(w);
    const double rate_sq = matter[0] / (matter[1] * h * h * m2);
    return {float(rate_sq), float(rate_sq * matter[2] / matter[1] * m2 / (3 * (m4 - m2 * m2))),
            float(matter[2] / matter[0]), float(matter[3] / matter[0])};
}

void find_spread(MatchedRegions& matched, const Lattice& lattice, bool with_spread,
                 const std::function<bool(std::size_t)>& which)
{
    const LatticeRegions& regions = matched.regions;
    const auto at = [&](std::size_t i) { return Vec3(lattice.at[i].cast<double>()); };
    if (with_spread) find_inverse_spread(regions, matched.mass, at, which, matched.inverse_spread);
    if (!matched.poisson.empty()) find_volume(regions, matched.mass, at, which, matched.volume);
    if (!regions.flat) return;
    const auto place = [&](std::size_t i) {
        const Vec3i from_first = lattice.at[i] - lattice.at[0];
        return std::array{double(from_first[regions.axes[0]]), double(from_first[regions.axes[1]])};
    };
    find_twist(regions, matched.mass, place, which, matched.twist);
}

}  // namespace physics
