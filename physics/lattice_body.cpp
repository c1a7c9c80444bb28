#include "geometry/parallel.hpp"
#include "geometry/plane.hpp"
#include "geometry/sets.hpp"
#include "physics/lattice.hpp"
#include "physics/torn_regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace physics {

Lattice corner_lattice(const geometry::Cubes& cubes)
{
    Lattice lattice;
    lattice.at = cubes.corner;
    lattice.next.assign(cubes.corner_count(), {none, none, none});
    for (const auto& corners : cubes.corners) {
        for (unsigned a = 0; a < 8; ++a) {
            for (unsigned d = 0; d < 3; ++d) {
                const std::uint32_t from = corners[a], to = corners[a | 1u << d];
                if (from != to) lattice.next[from][d] = to;
            }
        }
    }
    return lattice;
}

namespace {

template <class... V> std::size_t bytes_in(const V&... v)
{
    return ((v.size() * sizeof(v[0])) + ...);
}

std::size_t bytes_of(const MatchedRegions& m)
{
    std::size_t sum = bytes_in(m.mass, m.held_by, m.rate_sq, m.bend_sq, m.inverse_spread, m.twist,
                               m.regions.particle);
    for (const LatticeLines* along : {&m.regions.x, &m.regions.y, &m.regions.z}) {
        sum += bytes_in(along->lines, along->items, along->dead);
    }
    const LatticeExceptions& e = m.regions.exceptions;
    return sum + bytes_in(m.regions.slabs) +
           bytes_in(e.region, e.at, e.child_at, e.child, e.parent_at, e.parent, e.particle,
                    e.bar_at, e.bar);
}

// B^-1 of a region in lattice steps, from sums of M, M X and M X X^T about any point (packed xx,
// xy, xz, yy, yz, zz), also where it is flat or a line: there it is 0 across.
std::array<float, 6> inverse_spread(double mass, const Vec3& moment, const Mat3& about)
{
    const Mat3 b = about - moment * moment.transpose() / mass;
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(b);
    Vec3 inverse = eigen.eigenvalues();
    const double largest = inverse.maxCoeff();
    for (double& v : inverse) v = v > 1e-9 * largest ? 1 / v : 0;
    const Mat3 m = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
    return {float(m(0, 0)), float(m(0, 1)), float(m(0, 2)),
            float(m(1, 1)), float(m(1, 2)), float(m(2, 2))};
}

// B^-1 of the regions of those slots. Sums of M X X^T need one more moment than collect() takes, so
// M X goes in as what is summed.
void find_inverse_spreads(MatchedRegions& matched, const Lattice& lattice,
                          const std::function<bool(std::size_t)>& which)
{
    const LatticeRegions& regions = matched.regions;
    RegionSums<double> sums(regions);
    auto& f = sums.particles;
    // M (X - X_r) (X - X_r)^T summed = moments of M X, less X_r times those of M.
    for (std::size_t i = 0; i < lattice.count(); ++i) {
        const Vec3 p = lattice.at[i].cast<double>();
        const double m = double(matched.mass[i]);
        f[i] = {m * p[0], m * p[1], m * p[2], m};
    }
    auto& out = matched.inverse_spread;
    out.resize(6 * regions.slots(), 0.0f);
    collect<double>(regions, sums, [&](std::size_t first, std::span<const Quad<double>> slots) {
        for (std::size_t k = 0; 4 * k < slots.size(); ++k) {
            const std::uint32_t r = regions.particle[first + k];
            if (r == none || !which(first + k)) continue;
            const auto* const sum = slots.data() + 4 * k;
            const Vec3 at = lattice.at[r].cast<double>();
            Vec3 moment = Vec3::Zero();
            Mat3 about = Mat3::Zero();
            for (std::size_t d = 1; d <= regions.sides(); ++d) {
                const int axis = regions.axes[d - 1];
                moment[axis] = sum[d][3];
                about.col(axis) = sum[d].head<3>().matrix() - sum[d][3] * at;
            }
            const auto packed = inverse_spread(sum[0][3], moment, about);
            std::copy(packed.begin(), packed.end(), out.begin() + std::ptrdiff_t(6 * (first + k)));
        }
    });
}

// To which linked body each particle belongs; bodies are numbered by their first particles.
std::vector<std::uint32_t> linked_pieces(const Lattice& lattice)
{
    geometry::Sets sets(lattice.count());
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        for (const auto j : lattice.next[i]) {
            if (j != none) sets.join(i, j);
        }
    }
    std::vector<std::uint32_t> piece(lattice.count());
    std::uint32_t pieces = 0;
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        const std::uint32_t first = sets.root(i);
        piece[i] = first == i ? pieces++ : piece[first];
    }
    return piece;
}

// Cubes along the shortest of the pieces that bend rather than shear: they are more than twice as
// long as thick. 0: there is none.
int shortest_slender(const Lattice& lattice, const std::vector<std::uint32_t>& piece)
{
    std::vector<std::pair<Vec3i, Vec3i>> extent;
    for (std::size_t i = 0; i < piece.size(); ++i) {
        if (piece[i] == extent.size()) extent.emplace_back(lattice.at[i], lattice.at[i]);
        auto& [low, high] = extent[piece[i]];
        low = low.cwiseMin(lattice.at[i]);
        high = high.cwiseMax(lattice.at[i]);
    }
    int shortest = 0;
    for (const auto& [low, high] : extent) {
        const Vec3i cubes = high - low;
        const int length = cubes.maxCoeff();
        if (length <= 2 * cubes.minCoeff() || length < 2) continue;
        shortest = shortest == 0 ? length : std::min(shortest, length);
    }
    return shortest;
}

// Particles that lack a neighbour along an axis other than `flat`.
std::vector<std::uint32_t> particles_at_the_side(const Lattice& lattice, int flat)
{
    std::vector<std::uint8_t> neighbours(lattice.count(), 0);
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        for (const auto j : lattice.next[i]) {
            if (j != none) ++neighbours[i], ++neighbours[j];
        }
    }
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        if (flat >= 0 || neighbours[i] < 6) out.push_back(i);
    }
    return out;
}

std::vector<std::array<double, 3>> matter_of(const geometry::Cubes& cubes, const CornerBody& base,
                                             Weighting weighting, bool flat)
{
    std::vector<std::array<double, 3>> matter(cubes.corner_count(), {0, 0, 0});
    const double volume = std::pow(cubes.size, 3);
    std::vector<double> corner_mass(flat ? cubes.corner_count() : 0, 0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        // A plane's fill is its thickness: nothing to round up.
        const double share = flat ? cubes.fill[c] : stiffness_share(cubes, c, weighting);
        for (const auto k : cubes.corners[c]) {
            matter[k][0] += cubes.young[c] * share * volume / 8;
            if (flat) {
                const double nu = cubes.poisson[c];
                matter[k][2] += cubes.mass[c] / 8 * cubes.fill[c] * cubes.fill[c] / (1 - nu * nu);
            }
        }
    }
    for (std::size_t k = 0; k < matter.size(); ++k) matter[k][1] = base.mass[k];
    return matter;
}

// For each linked body, how much stiffer the lattice is in bending than its material: the ratio of
// what a slight bend of its longest axis towards its shortest costs,
//   U = 1/2 sum E V kappa^2 (c^2 + h^2 / 12)   against   -1/2 sum m u . a,
// a the acceleration that the lattice answers the displacement u = kappa (a^2 / 2 e3 - a c e1) with
// (a, c along the principal axes e1, e3 of E V; the h^2 / 12 is what a cube has in itself). By N.
std::vector<double> bending_excess(const geometry::Cubes& cubes, const LatticeBody& body,
                                   const std::vector<std::uint32_t>& piece)
{
    struct Sums {
        double weight = 0;
        Vec3 moment = Vec3::Zero();
        Mat3 spread = Mat3::Zero();
        double expected = 0, got = 0;
        Vec3 centre, e1, e3;
    };
    const std::size_t n = cubes.corner_count();
    const double h = cubes.size;
    std::vector<Sums> sums(n);  // of each body
    std::vector<Vec3> centre(cubes.count());
    std::vector<double> weight(cubes.count());
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        centre[c] = (cubes.cell[c].cast<double>() + Vec3::Constant(0.5)) * h;
        weight[c] = cubes.young[c] * stiffness_share(cubes, c, body.options.weighting) * h * h * h;
        Sums& s = sums[piece[cubes.corners[c][0]]];
        s.weight += weight[c];
        s.moment += weight[c] * centre[c];
        s.spread += weight[c] * centre[c] * centre[c].transpose();
    }
    for (Sums& s : sums) {
        if (s.weight == 0) continue;
        s.centre = s.moment / s.weight;
        const Mat3 about = s.spread / s.weight - s.centre * s.centre.transpose();
        const Eigen::SelfAdjointEigenSolver<Mat3> eigen(about);
        s.e1 = eigen.eigenvectors().col(2);
        s.e3 = eigen.eigenvectors().col(0);
    }
    double largest = 0;
    for (const float r : body.whole.rate_sq) largest = std::max(largest, double(r));
    State state = rest_state(body);
    const double kappa = 1e-7 / h, dt = 1e-3 / std::sqrt(largest);
    std::vector<Vec3> u(n);
    for (std::size_t k = 0; k < n; ++k) {
        const Sums& s = sums[piece[k]];
        const Vec3 p = cubes.corner[k].cast<double>() * h - s.centre;
        const double a = p.dot(s.e1), c = p.dot(s.e3);
        u[k] = kappa * (a * a / 2 * s.e3 - a * c * s.e1);
        state.x[k] += u[k];
    }
    LatticeOptions options = body.options;
    options.stiffness = Stiffness::material;
    options.damping = 0;
    options.tear = 0;
    options.substeps = 1;
    options.precision = Precision::full;
    options.plastic.yield = 0;
    const State after = advance(body, state, {}, dt, options);
    for (std::size_t k = 0; k < n; ++k) {
        sums[piece[k]].got -= 0.5 * body.base.mass[k] * u[k].dot(after.v[k]) / dt;
    }
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        Sums& s = sums[piece[cubes.corners[c][0]]];
        const double away = (centre[c] - s.centre).dot(s.e3);
        s.expected += 0.5 * weight[c] * kappa * kappa * (away * away + h * h / 12);
    }
    std::vector<double> out(n, 1);
    for (std::size_t k = 0; k < n; ++k) {
        const Sums& s = sums[piece[k]];
        const double ratio = s.got / s.expected;
        if (ratio > 1e-3 && ratio < 1e3) out[k] = ratio;
    }
    return out;
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

MatchedRegions match_regions(LatticeRegions found, const Lattice& lattice,
                             const std::vector<std::array<double, 3>>& matter, double h,
                             bool with_spread)
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
    RegionSums<double> sums(regions);
    for (std::size_t i = 0; i < n; ++i) {
        sums.particles[i] = {matter[i][0], matter[i][1], matter[i][2], 0};
    }
    collect<double>(regions, sums, [&](std::size_t first, std::span<const Quad<double>> slots) {
        for (std::size_t s = first; s < first + slots.size() / 4; ++s) {
            if (regions.particle[s] == none) continue;
            const Quad<double>& total = slots[4 * (s - first)];
            const auto rates = rates_of({total[0], total[1], total[2]}, regions.half_width, h);
            out.rate_sq[s] = rates.rate_sq;
            if (regions.flat) out.bend_sq[s] = rates.bend_sq;
        }
    });
    find_spread(out, lattice, with_spread, [](std::size_t) { return true; });
    return out;
}

// s^2 = E / (rho h^2 m2), with E V and m summed over the region.
RegionRates rates_of(const std::array<double, 3>& matter, int half_width, double h)
{
    const double w = half_width, m2 = mean_square_place(w), m4 = mean_fourth_place(w);
    const double rate_sq = matter[0] / (matter[1] * h * h * m2);
    return {float(rate_sq), float(rate_sq * matter[2] / matter[1] * m2 / (3 * (m4 - m2 * m2)))};
}

void find_spread(MatchedRegions& matched, const Lattice& lattice, bool with_spread,
                 const std::function<bool(std::size_t)>& which)
{
    const LatticeRegions& regions = matched.regions;
    if (with_spread) find_inverse_spreads(matched, lattice, which);
    if (!regions.flat) return;
    const auto place = [&](std::size_t i) {
        const Vec3i from_first = lattice.at[i] - lattice.at[0];
        return std::array{double(from_first[regions.axes[0]]), double(from_first[regions.axes[1]])};
    };
    find_twist(regions, matched.mass, place, which, matched.twist);
}

std::size_t LatticeBody::bytes() const
{
    return sizeof *this - sizeof base + base.bytes() + bytes_of(whole) + membrane.bytes() +
           bytes_in(side, piece) + (torn ? torn->bytes() : 0);
}

LatticeBody make_lattice(const geometry::Cubes& cubes, const LatticeOptions& options,
                         const geometry::TriMesh* surface)
{
    LatticeBody body;
    body.options = options;
    body.flat_axis = geometry::flat_axis(cubes);
    if (options.plane == PlaneMotion::in_plane && body.flat_axis < 0) {
        throw std::invalid_argument("motion in the plane needs a plane: link one, or choose plane "
                                    "= space for cubes");
    }
    body.base = make_corner_body(cubes, {}, surface, options.tear > 0);
    Lattice lattice = corner_lattice(cubes);
    const bool flat = body.flat_axis >= 0, plastic = options.plastic.yield > 0;
    auto matter = matter_of(cubes, body.base, options.weighting, flat);
    body.whole = match_regions(find_regions(lattice, options.half_width, body.flat_axis), lattice,
                               matter, cubes.size, plastic);
    if (flat && options.plane == PlaneMotion::space) {
        body.membrane = make_membrane(cubes, body.flat_axis);
    }
    double whole = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double part = cubes.young[c] * stiffness_share(cubes, c, options.weighting);
        body.damping += part * cubes.stiffness_damping[c];
        whole += part;
    }
    body.damping /= whole;
    auto piece = linked_pieces(lattice);
    body.slender = shortest_slender(lattice, piece);
    if (!flat && options.calibrate == Calibration::bending) {
        // Softer by what it bends too stiffly: the mass and all proportions stay.
        const std::vector<double> excess = bending_excess(cubes, body, piece);
        for (std::size_t k = 0; k < matter.size(); ++k) matter[k][0] /= excess[k];
        for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
            const std::uint32_t r = body.whole.regions.particle[s];
            if (r != none) body.whole.rate_sq[s] = float(double(body.whole.rate_sq[s]) / excess[r]);
        }
    }
    if (options.contact.on) {
        body.piece = std::move(piece);
        body.side = particles_at_the_side(lattice, body.flat_axis);
    }
    if (options.tear > 0) {
        body.torn = std::make_shared<TornRegions>(std::move(lattice), std::move(matter), cubes.size,
                                                  plastic);
    }
    return body;
}

State rest_state(const LatticeBody& body)
{
    return rest_state(body.base);
}

}  // namespace physics
