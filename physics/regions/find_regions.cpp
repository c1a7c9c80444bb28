#include "physics/regions/find_regions.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/regions/chart_lines.hpp"
#include "physics/regions/region_sums.hpp"
#include "physics/regions/shared_sums.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace physics {

namespace {

// One region that does not hold everything in its box.
struct PartialRegion {
    std::uint32_t slot, particle;
    std::vector<Reach::Piece> pieces;  // by z, then by place
};

// Regions whose reach is not all that its chart has in the box.
std::vector<PartialRegion> find_partial_regions(const Lattice& lattice,
                                                const LatticeRegions& regions, const Runs& runs,
                                                const std::vector<Chart>& all_charts)
{
    const ChartExtents charts(lattice, all_charts, regions.half_width);
    // How many particles of a region's chart its box holds, and how many of them are loose: a sum
    // over all regions as if none were partial.
    RegionSums<double> sums(regions);
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        sums.particles[i] = {1, charts.is_loose(i) ? 1.0 : 0.0, 0, 0};
    }
    std::vector<std::uint32_t> held(regions.slots());
    constexpr std::uint32_t all_places = none;
    collect<double>(regions, sums, [&](std::size_t first, std::span<const Quad<double>> slots) {
        for (std::size_t k = 0; 4 * k < slots.size(); ++k) {
            const Quad<double>& sum = slots[4 * k];
            const std::uint32_t r = regions.particle[first + k];
            const bool is_full = r != none && sum[1] == 0 && sum[0] == double(charts.places(r));
            held[first + k] = is_full ? all_places : std::uint32_t(sum[0]);
        }
    });
    // How often the chart has changed along the runs up to each of their particles.
    const auto in_runs = runs.particles();
    std::vector<std::uint32_t> changes(in_runs.size(), 0);
    for (std::size_t k = 1; k < changes.size(); ++k) {
        const bool same = charts.of(in_runs[k]) == charts.of(in_runs[k - 1]);
        changes[k] = changes[k - 1] + (same ? 0 : 1);
    }
    constexpr std::size_t piece = 4096;
    std::vector<std::vector<PartialRegion>> found((regions.slots() + piece - 1) / piece);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        Reach reach(runs, regions.half_width);
        for (std::size_t p = begin; p < end; ++p) {
            for (std::size_t slot = p * piece; slot < std::min(regions.slots(), (p + 1) * piece);
                 ++slot) {
                const std::uint32_t r = regions.particle[slot];
                if (r == none || held[slot] == all_places) continue;
                std::uint32_t reached = 0;
                bool elsewhere = false;
                const auto pieces = reach.from(r, lattice.at[r]);
                for (const auto& run : pieces) {
                    elsewhere |= charts.of(in_runs[run.first]) != charts.of(r) ||
                                 changes[run.first] != changes[run.first + run.length - 1];
                    reached += run.length;
                }
                if (!elsewhere && reached == held[slot]) continue;
                PartialRegion fresh{std::uint32_t(slot), r, {pieces.begin(), pieces.end()}};
                std::sort(fresh.pieces.begin(), fresh.pieces.end());
                found[p].push_back(std::move(fresh));
            }
        }
    });
    std::vector<PartialRegion> all;
    for (auto& list : found) {
        all.insert(all.end(), std::make_move_iterator(list.begin()),
                   std::make_move_iterator(list.end()));
    }
    return all;
}

}  // namespace

LatticeRegions find_regions(const Lattice& given, int half_width, int flat_axis)
{
    if (half_width < 1 || half_width > 64) {
        throw std::invalid_argument(
            fmt::format("expected a half width from 1 to 64, found {}", half_width));
    }
    LatticeRegions regions;
    regions.half_width = half_width;
    regions.particles = given.count();
    regions.flat = flat_axis >= 0;
    if (regions.flat) regions.axes = {(flat_axis + 1) % 3, (flat_axis + 2) % 3, flat_axis};
    const Lattice lattice = turned(given, regions.axes);
    if (regions.flat) {
        for (const auto& next : lattice.next) {
            if (next[2] != none) {
                throw std::invalid_argument("expected no links along the flat axis of a plane");
            }
        }
    }
    const std::vector<Chart> charts = make_charts(lattice);
    for (const Chart& chart : charts) add_chart_lines(lattice, chart, regions);
    regions.particle.resize(regions.flat ? regions.y.windows : regions.z.windows, none);

    const Runs runs(lattice);
    SharedSums sums(regions.flat ? 1 : 2 * std::size_t(half_width) + 1);
    const auto partial = find_partial_regions(lattice, regions, runs, charts);
    std::vector<SharedSums::Region> added;
    for (const PartialRegion& x : partial) added.push_back({x.slot, x.particle});
    sums.add(added);
    for (const PartialRegion& x : partial) sums.set(x.slot, x.pieces);
    regions.partial = sums.table(runs.particles(), {lattice.at, {0, 1, 2}});
    return regions;
}

}  // namespace physics
