#include "geometry/cubes/plane.hpp"
#include "physics/lattice/bend_ratio.hpp"
#include "physics/lattice/bending_excess.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/lattice/torn_regions.hpp"
#include "physics/regions/find_regions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

namespace physics {

namespace {

// Particles further apart along a body than this touch each other.
constexpr int links_that_fold = 5;

// Cubes along the shortest of the pieces that bend rather than shear, which are more than twice as
// long as thick, and of the others. 0: there is none.
struct Lengths {
    int slender = 0, compact = 0;
};

Lengths shortest_lengths(const Lattice& lattice, const std::vector<std::uint32_t>& piece)
{
    std::vector<std::pair<Vec3i, Vec3i>> extent;
    for (std::size_t i = 0; i < piece.size(); ++i) {
        if (piece[i] == extent.size()) extent.emplace_back(lattice.at[i], lattice.at[i]);
        auto& [low, high] = extent[piece[i]];
        low = low.cwiseMin(lattice.at[i]);
        high = high.cwiseMax(lattice.at[i]);
    }
    Lengths shortest;
    for (const auto& [low, high] : extent) {
        const Vec3i cubes = high - low;
        const int length = cubes.maxCoeff();
        if (length < 2) continue;
        int& kind = length > 2 * cubes.minCoeff() ? shortest.slender : shortest.compact;
        kind = kind == 0 ? length : std::min(kind, length);
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

// Larger ratios act as this one.
constexpr double most_poisson = 0.495;

// The stiffness of cube c is divided by ratio[c], where there is one.
std::vector<RegionMatter> matter_of(const geometry::Cubes& cubes, const CornerBody& base,
                                    Weighting weighting, bool flat,
                                    const std::vector<double>& ratio = {})
{
    std::vector<RegionMatter> matter(cubes.corner_count(), {0, 0, 0, 0});
    const double volume = std::pow(cubes.size, 3);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        // A plane's fill is its thickness: nothing to round up.
        const double share = flat ? cubes.fill[c] : stiffness_share(cubes, c, weighting);
        for (const auto k : cubes.corners[c]) {
            const double less = ratio.empty() ? 1 : ratio[c], nu = cubes.poisson[c];
            const double stiff = cubes.young[c] * share * volume / 8 / less;
            matter[k][0] += stiff;
            matter[k][2] += flat ? cubes.mass[c] / 8 * cubes.fill[c] * cubes.fill[c] / (1 - nu * nu)
                                 : stiff * std::clamp(nu, 0.0, most_poisson);
        }
    }
    for (std::size_t k = 0; k < matter.size(); ++k) matter[k][1] = base.mass[k];
    return matter;
}

// By N, of what a particle's piece has in all, with weights matter[k][0].
std::vector<double> mean_of_pieces(const std::vector<RegionMatter>& matter,
                                   const std::vector<std::uint32_t>& piece,
                                   const std::function<double(std::size_t)>& of)
{
    std::vector<double> sum(matter.size(), 0), weight(matter.size(), 0), out(matter.size());
    for (std::size_t k = 0; k < matter.size(); ++k) {
        sum[piece[k]] += matter[k][0] * of(k);
        weight[piece[k]] += matter[k][0];
    }
    for (std::size_t k = 0; k < matter.size(); ++k) out[k] = sum[piece[k]] / weight[piece[k]];
    return out;
}

// Makes rates and gains such that the body has the material's E, whatever of nu steps can bear. A
// bend resists x k of what rotations resist, x its excess at nu = 0, and with volume phi k lambda /
// mu / 2 more while its sides are held, phi nu k where they are free: a region sees no more than
// the mean of its strains. So E = k (x + phi nu); x = phi = 1 is right for stretch.
void calibrate(const geometry::Cubes& cubes, const std::vector<std::uint32_t>& piece,
               const Lattice& lattice, std::vector<RegionMatter>& matter, LatticeBody& body)
{
    const bool bends = body.options.calibrate == Calibration::bending;
    const auto nu_of = [&](std::size_t k) { return matter[k][2] / matter[k][0]; };
    body.poisson =
        std::min(*std::max_element(cubes.poisson.begin(), cubes.poisson.end()), most_poisson);
    if (!bends && body.poisson <= 0) return;
    std::vector<double> excess(matter.size(), 1), gain(matter.size(), 1);
    if (bends) excess = bending_excess(cubes, body, piece);
    if (body.poisson > 0) {
        add_volume(body.whole, lattice, matter, cubes.size);
        if (bends) {
            const std::vector<double> with_volume = bending_excess(cubes, body, piece);
            const auto lambda = mean_of_pieces(
                matter, piece, [&](std::size_t k) { return nu_of(k) / (1 - 2 * nu_of(k)); });
            for (std::size_t k = 0; k < gain.size(); ++k) {
                const double more = with_volume[k] - excess[k];
                gain[k] = lambda[k] > 0 ? std::clamp(more / lambda[k], 0.0, 1.0) : 1;
            }
        }
    }
    for (std::size_t k = 0; k < matter.size(); ++k) {
        const double nu = nu_of(k), x = excess[k];
        // Between what a full region and one of a thin bar gives of 1 + nu.
        body.soft_stretch = std::max(body.soft_stretch, (x + gain[k] * nu) / (1 + nu / 2));
        matter[k][0] /= x;
        matter[k][2] /= x;
        matter[k][3] = matter[k][0] * gain[k] / x;
    }
    find_rates(body.whole, matter, cubes.size);
}

// Stretch by the material's E, and bends within regions by the E / n of bend_ratio.hpp.
void set_bends_apart(const geometry::Cubes& cubes, const Lattice& lattice,
                     std::vector<RegionMatter>& matter, LatticeBody& body)
{
    body.poisson =
        std::min(*std::max_element(cubes.poisson.begin(), cubes.poisson.end()), most_poisson);
    const std::vector<float> whole = body.whole.rate_sq;
    const std::vector<double> ratio = bend_ratios(cubes, body.options.half_width);
    matter = matter_of(cubes, body.base, body.options.weighting, false, ratio);
    add_volume(body.whole, lattice, matter, cubes.size);
    body.whole.stretch.assign(whole.size(), 1.0f);
    for (std::size_t s = 0; s < whole.size(); ++s) {
        if (body.whole.rate_sq[s] > 0) body.whole.stretch[s] = whole[s] / body.whole.rate_sq[s];
    }
}

}  // namespace

LatticeBody make_lattice(const geometry::Cubes& cubes, const LatticeOptions& options,
                         const geometry::TriMesh* surface)
{
    LatticeBody body;
    body.options = options;
    body.flat_axis = geometry::flat_axis(cubes);
    if (cubes.is_sheet()) {
        throw std::invalid_argument("method lattice needs cubes on a lattice, found a sheet of "
                                    "triangles: use method shell, or make the cubes with Plane");
    }
    if (options.plane == PlaneMotion::in_plane && body.flat_axis < 0) {
        throw std::invalid_argument(
            "expected a plane of cubes for motion in its plane: link one, or "
            "set plane to space");
    }
    body.base = make_corner_body(cubes, {}, surface, options.tear > 0);
    // Its thickness lies across the plane, where nothing moves.
    if (options.plane == PlaneMotion::in_plane) body.base.skin.leave_thickness();
    Lattice lattice = corner_lattice(cubes);
    const bool flat = body.flat_axis >= 0, plastic = options.plastic.yield > 0;
    if (plastic) body.cubes = cubes.corners;
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
    body.pieces = linked_pieces(lattice);
    const std::vector<std::uint32_t>& piece = body.pieces.of;
    const Lengths shortest = shortest_lengths(lattice, piece);
    body.slender = shortest.slender;
    body.compact = shortest.compact;
    if (!flat && options.calibrate == Calibration::both) {
        set_bends_apart(cubes, lattice, matter, body);
    } else if (!flat) {
        calibrate(cubes, piece, lattice, matter, body);
    }
    if (plastic || !body.whole.volume.empty()) body.pinned = std::make_shared<PinnedShapes>();
    if (options.contact.on) {
        body.side = particles_at_the_side(lattice, body.flat_axis);
        if (options.contact.self) {
            const double distance = options.contact.distance_in(cubes.size) / cubes.size;
            // By rounding, what rests just so far apart may seem nearer.
            body.along = NearAlong(lattice, body.side, links_that_fold, 0.999 * distance);
        }
    }
    if (options.tear > 0) {
        body.torn = std::make_shared<TornRegions>(std::move(lattice), std::move(matter), cubes.size,
                                                  plastic);
    }
    return body;
}

}  // namespace physics
