#pragma once

// What Voxelize says of points that its cubes are too small for.

#include "geometry/cubes/components.hpp"
#include "graph/types/context.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nodes {

// Cubes where points lie that are farther apart than a cube is long: they fall as dust. So do those
// of a file in another unit.
inline void warn_of_dust(const geometry::Cubes& cubes, const graph::Context& context)
{
    constexpr std::size_t many = 100;
    if (cubes.count() < many) return;
    const auto parts = geometry::find_components(cubes, geometry::Connectivity::corner);
    const auto alone = std::count(parts.cubes.begin(), parts.cubes.end(), std::size_t{1});
    if (2 * static_cast<std::size_t>(alone) < cubes.count()) return;
    geometry::Vec3i low = cubes.cell.front(), high = low;
    for (const geometry::Vec3i& cell : cubes.cell)
        low = low.cwiseMin(cell), high = high.cwiseMax(cell);
    const double extent = cubes.size * ((high - low).maxCoeff() + 1);
    context.warn(fmt::format(
        "{} of {} cubes touch no other, so that they fall apart: the points are farther apart than "
        "cubes of {:.2g} m are long, over {:.2g} m in all. Set a larger `size`, or `unit` of "
        "ReadMesh, if the file is in another unit",
        alone, cubes.count(), cubes.size, extent));
}

}  // namespace nodes
