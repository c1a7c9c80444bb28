#pragma once

// What Voxelize says of bodies that enclose no volume, as a flat face does: fill_cubes() gives
// their cubes the least fill, and that is all that they weigh.

#include "geometry/cubes/cubes.hpp"
#include "geometry/cubes/sample_volume.hpp"
#include "graph/types/context.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nodes {

// Bodies without volume, and what they weigh.
struct NoVolume {
    std::size_t bodies = 0;
    double mass = 0;  // kg

    void operator+=(const NoVolume& more) { bodies += more.bodies, mass += more.mass; }
};

// Whether cubes weigh what `min_fill` gives them: no other share of them is full, and their mass is
// not that of what fills them.
inline bool weighs_by_min_fill(const geometry::Cubes& cubes, double min_fill)
{
    if (cubes.count() == 0 || min_fill >= 1) return false;
    const double least = std::max(min_fill, 1e-9), whole = std::pow(cubes.size, 3);
    double given = 0;  // kg
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (cubes.fill[c] > (1 + 1e-9) * least) return false;
        given += cubes.matters[cubes.matter[c]].density * cubes.fill[c] * whole;
    }
    return geometry::total_mass(cubes) > 0.999 * given;
}

// Of one body. `sure`: whether its volume is measured, as it may fill its cubes to min_fill just
// so.
inline NoVolume no_volume_of(const geometry::TriMesh& mesh, geometry::Inside rule,
                             const geometry::Cubes& cubes, double min_fill, bool sure)
{
    if (!weighs_by_min_fill(cubes, min_fill)) return {};
    const double given =
        static_cast<double>(cubes.count()) * cubes.fill[0] * std::pow(cubes.size, 3);
    if (sure && geometry::volume_inside(mesh, rule) > 0.5 * given) return {};
    return {1, geometry::total_mass(cubes)};
}

// `bodies`: of how many.
inline void warn_of_no_volume(const NoVolume& found, std::size_t bodies, double min_fill,
                              const graph::Context& context)
{
    if (found.bodies == 0) return;
    const std::string which =
        bodies == 1 ? "the mesh encloses no volume: it weighs"
        : found.bodies == 1
            ? fmt::format("1 of {} bodies encloses no volume: it weighs", bodies)
            : fmt::format("{} of {} bodies enclose no volume: they weigh", found.bodies, bodies);
    context.warn(fmt::format("{} {:.3g} kg, which is what min_fill = {:.3g} gives cubes that the "
                             "faces only pass through. Set thickness to that of the faces",
                             which, found.mass, min_fill));
}

}  // namespace nodes
