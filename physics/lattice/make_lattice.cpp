#include "geometry/cubes/plane.hpp"
#include "physics/lattice/bending_excess.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/lattice/torn_regions.hpp"
#include "physics/regions/find_regions.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {

namespace {

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

std::vector<RegionMatter> matter_of(const geometry::Cubes& cubes, const CornerBody& base,
                                    Weighting weighting, bool flat)
{
    std::vector<RegionMatter> matter(cubes.corner_count(), {0, 0, 0});
    const double volume = std::pow(cubes.size, 3);
    std::vector<double> corner_mass(flat ? cubes.corner_count() : 0, 0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        // A plane's fill is its thickness: nothing to round up.
        const double share = flat ? cubes.fill[c] : stiffness_share(cubes, c, weighting);
        for (const auto k : cubes.corners[c]) {
            const double stiff = cubes.young[c] * share * volume / 8, nu = cubes.poisson[c];
            matter[k][0] += stiff;
            matter[k][2] += flat ? cubes.mass[c] / 8 * cubes.fill[c] * cubes.fill[c] / (1 - nu * nu)
                                 : stiff * std::max(nu, 0.0);
        }
    }
    for (std::size_t k = 0; k < matter.size(); ++k) matter[k][1] = base.mass[k];
    return matter;
}

// What regions resist so that the body has the material's E and nu: k of rotations, E = k (1 + nu).
// In a bend they resist x k, x its excess at nu = 0, and what nu adds at most phi k nu, for a
// region sees no more than the mean of its strains. So k = E / (x + phi nu); x = phi = 1 is right
// for stretch. phi: with volume the same bend costs phi lambda more, lambda / k = nu / (1 - 2 nu).
void calibrate(const geometry::Cubes& cubes, const std::vector<std::uint32_t>& piece,
               const Lattice& lattice, std::vector<RegionMatter>& matter, LatticeBody& body)
{
    const bool bends = body.options.calibrate == Calibration::bending;
    body.poisson = *std::max_element(cubes.poisson.begin(), cubes.poisson.end());
    std::vector<double> excess(matter.size(), 1), with_volume(matter.size(), 0);
    if (bends) excess = bending_excess(cubes, body, piece);
    if (body.poisson > 0) {
        add_volume(body.whole, lattice, matter, cubes.size);
        if (bends) with_volume = bending_excess(cubes, body, piece);
    }
    for (std::size_t k = 0; k < matter.size(); ++k) {
        const double nu = matter[k][2] / matter[k][0];
        double resists = excess[k] + nu;
        if (bends) {
            const double more = (with_volume[k] - excess[k]) * (1 - 2 * nu);
            resists = excess[k] + std::clamp(more, 0.0, nu);
        }
        body.soft_stretch = std::max(body.soft_stretch, resists / (1 + nu));
        matter[k][0] /= resists;
        matter[k][2] /= resists;
    }
    find_rates(body.whole, matter, cubes.size);
}

}  // namespace

LatticeBody make_lattice(const geometry::Cubes& cubes, const LatticeOptions& options,
                         const geometry::TriMesh* surface)
{
    LatticeBody body;
    body.options = options;
    body.flat_axis = geometry::flat_axis(cubes);
    if (options.plane == PlaneMotion::in_plane && body.flat_axis < 0) {
        throw std::invalid_argument(
            "expected a plane of cubes for motion in its plane: link one, or "
            "set plane to space");
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
    body.pieces = linked_pieces(lattice);
    const std::vector<std::uint32_t>& piece = body.pieces.of;
    const Lengths shortest = shortest_lengths(lattice, piece);
    body.slender = shortest.slender;
    body.compact = shortest.compact;
    if (!flat) calibrate(cubes, piece, lattice, matter, body);
    if (options.contact.on) body.side = particles_at_the_side(lattice, body.flat_axis);
    if (options.tear > 0) {
        body.torn = std::make_shared<TornRegions>(std::move(lattice), std::move(matter), cubes.size,
                                                  plastic);
    }
    return body;
}

}  // namespace physics
