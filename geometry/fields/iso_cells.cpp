#include "geometry/fields/iso_cells.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/fields/iso_grid.hpp"

#include <limits>

namespace geometry {

IsoCells iso_cells(const IsoField& field, int along)
{
    IsoCells cells;
    if (field.domain.empty()) return cells;
    const double longest = field.domain.size().maxCoeff();
    if (!(longest > 0)) return cells;
    constexpr std::size_t no_limit = std::numeric_limits<std::int32_t>::max();
    const IsoGrid grid = iso_grid(field, longest / along / block_cells, no_limit);
    const std::vector<Vec3i> crossed = crossed_blocks(grid);
    if (crossed.empty()) return cells;
    Vec3i lo = crossed[0], hi = crossed[0];
    for (const Vec3i& at : crossed) {
        lo = lo.cwiseMin(at);
        hi = hi.cwiseMax(at);
    }
    cells.cell = block_cells * grid.cell;
    cells.lo = cells.cell * lo.cast<double>();
    cells.dims = hi - lo + Vec3i::Ones();
    cells.bounds.add(cells.lo);
    cells.bounds.add(Vec3(cells.lo + cells.cell * cells.dims.cast<double>()));
    cells.slope.assign(cells.index(cells.dims - Vec3i::Ones()) + 1, 0);
    cells.leap.assign(cells.slope.size(), 0);
    parallel_for(crossed.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3i at = crossed[i] - lo;
            constexpr Steepness unknown{1e30, 0};
            const auto [slope, leap] = field.steepness ? field.steepness(cells.box(at)) : unknown;
            // A hair more, which rounding to float may take away.
            cells.slope[cells.index(at)] = std::max(static_cast<float>(1.000001 * slope), 1e-30f);
            cells.leap[cells.index(at)] = static_cast<float>(1.000001 * leap);
        }
    });
    return cells;
}

}  // namespace geometry
