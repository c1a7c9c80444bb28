#include "geometry/fields/field_grid.hpp"

#include <algorithm>
#include <cmath>

namespace geometry {

// Cells along an axis beyond which there is no grid of them.
static constexpr double farthest = 1e9;

FieldGrid make_field_grid(std::span<const Box> influence)
{
    FieldGrid grid;
    Box all;
    double width = 0;
    std::size_t bounded = 0;
    for (const Box& box : influence) {
        if (box.empty() || !box.lo.allFinite()) continue;
        all.add(box);
        width += box.size().maxCoeff();
        ++bounded;
    }
    if (bounded == 0) return grid;
    const double most = 16.0 * static_cast<double>(bounded) + 8;
    grid.lo = all.lo;
    grid.cell = 0.5 * width / static_cast<double>(bounded);
    // Boxes that rounding has left without a width, or that are wider than numbers go.
    if (!(grid.cell > 0) || !((all.size() / grid.cell).maxCoeff() < farthest)) {
        grid.cell = std::max(all.size().maxCoeff(), 1.0);
        if (!std::isfinite(grid.cell)) return {};
    }
    for (;; grid.cell *= 1.25) {
        const Vec3 dims = (all.size() / grid.cell).array().ceil().max(1.0);
        if (dims.prod() > most) continue;
        grid.dims = dims.cast<int>();
        break;
    }
    grid.first.assign(static_cast<std::size_t>(grid.dims.prod()) + 1, 0);
    const auto each_entry = [&](const auto& visit) {
        for (std::uint32_t i = 0; i < influence.size(); ++i) {
            const Box& box = influence[i];
            if (box.empty() || !box.lo.allFinite()) continue;
            for_cells(grid, box, [&](std::size_t cell) { visit(cell, i); });
        }
    };
    each_entry([&](std::size_t cell, std::uint32_t) { ++grid.first[cell + 1]; });
    for (std::size_t c = 0; c + 1 < grid.first.size(); ++c) grid.first[c + 1] += grid.first[c];
    grid.skeleton.resize(grid.first.back());
    std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
    each_entry([&](std::size_t cell, std::uint32_t i) { grid.skeleton[next[cell]++] = i; });
    return grid;
}

}  // namespace geometry
