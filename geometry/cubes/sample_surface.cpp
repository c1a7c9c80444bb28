// Points evenly over a triangle by its square-root parametrization:
//   Osada, Funkhouser, Chazelle, Dobkin. Shape distributions. ACM TOG 21(4), 2002.
// Evenly in two coordinates by the golden ratio (the Fibonacci lattice with random shifts):
//   Niederreiter. Random number generation and quasi-Monte Carlo methods. SIAM 1992.
// Blue noise by throwing darts in order, with a grid to look for conflicts:
//   Cook. Stochastic sampling in computer graphics. ACM TOG 5(1), 1986.
// A saturated pattern covers 0.547 of the plane by discs of half its radius, so N points on area A
// want   r = 2 sqrt(0.547 A / (pi N))   or a little less.

#include "geometry/cubes/sample_surface.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/base/random.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace geometry {
namespace {

constexpr std::size_t samples_a_task = 16384;
constexpr double golden = 0.6180339887498949;  // (sqrt(5) - 1) / 2

double face_area(const TriMesh& mesh, std::size_t t)
{
    const auto& [a, b, c] = mesh.triangles()[t];
    if (std::max({a, b, c}) >= mesh.positions.size()) return 0;
    const Vec3 p = mesh.positions[a].cast<double>();
    const double area =
        0.5 *
        (mesh.positions[b].cast<double>() - p).cross(mesh.positions[c].cast<double>() - p).norm();
    return std::isfinite(area) ? area : 0;
}

// Running sum of the faces' areas: back() is the mesh's.
std::vector<double> running_area(const TriMesh& mesh)
{
    std::vector<double> sums(mesh.triangles().size());
    double sum = 0;
    for (std::size_t t = 0; t < sums.size(); ++t) sums[t] = sum += face_area(mesh, t);
    if (!(sum > 0) || !std::isfinite(sum)) {
        throw std::invalid_argument("the mesh has no area to sample: of its " +
                                    std::to_string(sums.size()) +
                                    " triangles, none has finite corners and an area");
    }
    return sums;
}

double fraction(double x)
{
    return x - std::floor(x);
}

// Positions and triangles of `count` evenly spread points.
void spread(const TriMesh& mesh, const std::vector<double>& area, std::size_t count,
            std::uint64_t seed, Samples& out)
{
    out.positions.resize(count);
    out.triangle.resize(count);
    const Random random(seed);
    const double step = area.back() / static_cast<double>(count);
    const double shift = random.unit(0);
    const double most = std::nextafter(area.back(), 0.0);  // the last faces may have no area
    const auto place = [&](std::size_t begin, std::size_t end) {
        auto t = static_cast<std::size_t>(
            std::upper_bound(area.begin(), area.end(),
                             std::min(static_cast<double>(begin) * step, most)) -
            area.begin());
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint64_t bits = random.bits(i + 1);
            const double jitter = static_cast<double>(bits >> 40) * 0x1p-24;
            const double across = static_cast<double>(bits & 0xffffff) * 0x1p-24;
            const double target = std::min((static_cast<double>(i) + jitter) * step, most);
            while (area[t] <= target) ++t;
            const double before = t > 0 ? area[t - 1] : 0;
            const double along = std::clamp((target - before) / (area[t] - before), 0.0, 1.0);
            // Half a neighbour's distance of jitter across, or the lattice would show.
            const double own = std::max(1.0, (area[t] - before) / step);  // samples
            const double side =
                fraction(shift + static_cast<double>(i) * golden + 0.5 * across / std::sqrt(own));
            const auto r = static_cast<float>(std::sqrt(along));
            const auto s = static_cast<float>(side);
            const auto& [a, b, c] = mesh.triangles()[t];
            const Vec3f &p = mesh.positions[a], &q = mesh.positions[b], &o = mesh.positions[c];
            out.positions[i] = p + r * ((q - p) + s * (o - q));
            out.triangle[i] = static_cast<std::uint32_t>(t);
        }
    };
    parallel_for(count, samples_a_task, place);
}

void weigh(const FaceMatter& matter, double area, const SampleMass& mass, Samples& out)
{
    const std::size_t n = out.positions.size();
    out.matters = matter.matters;
    out.matter.resize(n);
    out.mass.resize(n);
    const double each = area / static_cast<double>(n);  // m^2
    const bool by_area = mass.by == SampleMass::By::surface_density;
    const bool full = !by_area && !(mass.thickness > 0);
    const double thickness = full ? std::sqrt(each) : mass.thickness;
    if (full) out.bulk = 0;
    parallel_for(n, samples_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint16_t m = matter.of(out.triangle[i]);
            out.matter[i] = m;
            out.mass[i] = static_cast<float>(
                each * (by_area ? mass.surface_density : thickness * matter.matters[m].density));
        }
    });
    if (mass.by == SampleMass::By::total) scale_mass(out, mass.total);
}

// Points hashed by cells two radii wide: what is nearer than a radius lies in the eight cells
// around the cell's corner nearest to it.
class DartGrid {
public:
    DartGrid(double radius, std::size_t expected)
        : radius_sq_(static_cast<float>(radius * radius)), inverse_(0.5 / radius)
    {
        std::size_t slots = 64;
        while (slots < 2 * expected) slots *= 2;
        first_.assign(slots, no_index);
        points_.reserve(expected);
        next_.reserve(expected);
    }

    // Whether no point is nearer to p than the radius.
    bool is_free(const Vec3f& p) const { return free_slot(p) != no_slot; }

    // Adds p unless a point is nearer than the radius.
    bool add(const Vec3f& p)
    {
        const std::size_t own = free_slot(p);
        if (own == no_slot) return false;
        next_.push_back(first_[own]);
        first_[own] = static_cast<std::uint32_t>(points_.size());
        points_.push_back(p);
        return true;
    }

private:
    static constexpr std::size_t no_slot = std::numeric_limits<std::size_t>::max();

    // That of p's cell; none where a point is near.
    std::size_t free_slot(const Vec3f& p) const
    {
        std::array<std::array<std::uint64_t, 2>, 3> cell;  // its own, and the one next to it
        for (std::size_t d = 0; d < 3; ++d) {
            const double at = inverse_ * double(p[Eigen::Index(d)]);
            const auto cut = static_cast<std::int64_t>(at);
            const std::int64_t n = cut - (at < double(cut) ? 1 : 0);
            const std::int64_t next = at - double(n) < 0.5 ? n - 1 : n + 1;
            cell[d] = {static_cast<std::uint64_t>(n), static_cast<std::uint64_t>(next)};
        }
        // Cells that share a slot share a list: points of the other are merely tried in vain.
        std::size_t own = no_slot;
        for (const std::uint64_t x : cell[0]) {
            const std::uint64_t of_x = mixed(0, x);
            for (const std::uint64_t y : cell[1]) {
                const std::uint64_t of_xy = mixed(of_x, y);
                for (const std::uint64_t z : cell[2]) {
                    const std::size_t slot = mixed(of_xy, z) & (first_.size() - 1);
                    if (is_near(slot, p)) return no_slot;
                    if (own == no_slot) own = slot;
                }
            }
        }
        return own;
    }

    bool is_near(std::size_t slot, const Vec3f& p) const
    {
        for (std::uint32_t i = first_[slot]; i != no_index; i = next_[i]) {
            if ((points_[i] - p).squaredNorm() < radius_sq_) return true;
        }
        return false;
    }

    static std::uint64_t mixed(std::uint64_t hash, std::uint64_t n)
    {
        hash = (hash + n) * 0x9e3779b97f4a7c15u;
        return hash ^ hash >> 32;
    }

    float radius_sq_;
    double inverse_;
    std::vector<std::uint32_t> first_, next_;  // of a slot; of a point
    std::vector<Vec3f> points_;
};

// The darts that stay, by their places in the order in which they are thrown, up to `most` of them.
// They come in flights: on all threads, those of a flight that those before it leave no room are
// left out, which most are, and the others thrown one after the other.
std::vector<std::uint32_t> throw_darts(const std::vector<Vec3f>& thrown, double radius,
                                       std::size_t most)
{
    constexpr std::size_t flight = 32768, darts_a_task = 2048;
    DartGrid grid(radius, most);
    std::vector<std::uint32_t> stay;
    std::vector<char> free(std::min(flight, thrown.size()));
    for (std::size_t begin = 0; begin < thrown.size() && stay.size() < most; begin += flight) {
        stop_if_asked();
        const std::size_t count = std::min(flight, thrown.size() - begin);
        parallel_for(count, darts_a_task, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) free[i] = grid.is_free(thrown[begin + i]);
        });
        for (std::size_t i = 0; i < count && stay.size() < most; ++i) {
            if (!free[i] || !grid.add(thrown[begin + i])) continue;
            stay.push_back(static_cast<std::uint32_t>(begin + i));
        }
    }
    return stay;
}

// 0 .. n - 1 in the order of random numbers. These are spread evenly: each of some equal ranges of
// them has few, which are sorted by themselves.
std::vector<std::uint32_t> random_order(std::size_t n, const Random& random)
{
    constexpr unsigned bits = 12;
    using Key = std::pair<std::uint64_t, std::uint32_t>;
    std::vector<std::uint32_t> first((1u << bits) + 1, 0);
    for (std::size_t i = 0; i < n; ++i) ++first[(random.bits(i) >> (64 - bits)) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Key> keys(n);
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint64_t key = random.bits(i);
        keys[next[key >> (64 - bits)]++] = {key, i};
    }
    std::vector<std::uint32_t> order(n);
    parallel_for(next.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t range = begin; range < end; ++range) {
            std::sort(keys.begin() + first[range], keys.begin() + first[range + 1]);
            for (std::size_t k = first[range]; k < first[range + 1]; ++k) order[k] = keys[k].second;
        }
    });
    return order;
}

}  // namespace

void scale_mass(Samples& samples, double total)
{
    const double now = ordered_sum(samples.mass.size(), samples_a_task, 0.0,
                                   [&](std::size_t begin, std::size_t end) {
                                       double sum = 0;
                                       for (std::size_t i = begin; i < end; ++i)
                                           sum += double(samples.mass[i]);
                                       return sum;
                                   });
    if (!(now > 0)) return;
    samples.bulk *= now / total;
    samples.total_mass = total;
    for (float& m : samples.mass) m = static_cast<float>(double(m) * (total / now));
}

Samples sample_surface(const TriMesh& mesh, const FaceMatter& matter, std::size_t count,
                       std::uint64_t seed, const SampleMass& mass)
{
    const std::vector<double> area = running_area(mesh);
    Samples out;
    spread(mesh, area, count, seed, out);
    weigh(matter, area.back(), mass, out);
    return out;
}

Samples sample_surface_blue(const TriMesh& mesh, const FaceMatter& matter, std::size_t count,
                            std::uint64_t seed, const SampleMass& mass)
{
    constexpr std::size_t darts_each = 8;
    const std::vector<double> area = running_area(mesh);
    Samples darts;
    spread(mesh, area, darts_each * count, seed, darts);
    const std::vector<std::uint32_t> order = random_order(darts.positions.size(), Random(~seed));
    std::vector<Vec3f> thrown(order.size());
    parallel_for(order.size(), samples_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) thrown[i] = darts.positions[order[i]];
    });

    // The largest radius at which enough darts stay, to a hundredth: a few throws. Numbers go with
    // the inverse square of the radius, so each throw tells nearly where to try next.
    // Measured: of eight darts each, those that stay cover 0.445 of a smooth surface. From a little
    // more, two throws are enough.
    double radius = 2 * std::sqrt(0.447 * area.back() / (std::numbers::pi * double(count)));
    double fits = 0, fails = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> best;
    for (int round = 0; round < 40 && fits < 0.99 * fails; ++round) {
        std::vector<std::uint32_t> stay = throw_darts(thrown, radius, count);
        if (stay.size() == count) {
            fits = radius;
            best = std::move(stay);
            radius = std::isfinite(fails) ? 0.5 * (fits + fails) : 1.01 * radius;
        } else {
            fails = radius;
            const double guess = 0.998 * radius * std::sqrt(double(stay.size()) / double(count));
            radius = fits > 0 ? 0.5 * (fits + fails) : guess;
        }
    }
    for (std::uint32_t& i : best) i = order[i];
    std::sort(best.begin(), best.end());
    Samples out;
    for (const std::uint32_t i : best) {
        out.positions.push_back(darts.positions[i]);
        out.triangle.push_back(darts.triangle[i]);
    }
    weigh(matter, area.back(), mass, out);
    return out;
}

double sampled_area(const TriMesh& mesh)
{
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) sum += face_area(mesh, t);
    return sum;
}

std::size_t count_for_spacing(double area, double spacing)
{
    const double count = std::ceil(area / (spacing * spacing));
    if (!(count < 4e9)) {
        throw std::invalid_argument("samples " + std::to_string(spacing) + " m apart on " +
                                    std::to_string(area) +
                                    " m^2 exceed the limit of 4,000,000,000: use a larger spacing");
    }
    return static_cast<std::size_t>(std::max(count, 1.0));
}

}  // namespace geometry
