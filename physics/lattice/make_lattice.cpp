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
    body.poisson = *std::max_element(cubes.poisson.begin(), cubes.poisson.end());
    if (!flat && options.calibrate == Calibration::bending) {
        // Softer by what it bends too stiffly: the mass and all proportions stay.
        const std::vector<double> excess = bending_excess(cubes, body, piece);
        body.soft_stretch = *std::max_element(excess.begin(), excess.end());
        for (std::size_t k = 0; k < matter.size(); ++k) matter[k][0] /= excess[k];
        for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
            const std::uint32_t r = body.whole.regions.particle[s];
            if (r != none) body.whole.rate_sq[s] = float(double(body.whole.rate_sq[s]) / excess[r]);
        }
    }
    if (options.contact.on) body.side = particles_at_the_side(lattice, body.flat_axis);
    if (options.tear > 0) {
        body.torn = std::make_shared<TornRegions>(std::move(lattice), std::move(matter), cubes.size,
                                                  plastic);
    }
    return body;
}

}  // namespace physics
