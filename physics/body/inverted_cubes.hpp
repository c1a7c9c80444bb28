#pragma once

// How many cubes of a body are inverted or pressed nearly flat: a sign that a simulation has gone
// wrong, whatever its method.

#include "geometry/base/parallel.hpp"
#include "physics/body/corner_body.hpp"

#include <cstddef>

namespace physics {

// Cubes of the body whose mean deformation leaves less than a tenth of their volume, with corners
// at x (four numbers a slot).
inline std::size_t count_inverted(const CornerBody& body, const CornerRuns& cubes, const double* x)
{
    constexpr double least = 0.1;  // of the volume at rest
    constexpr std::size_t grain = 4096;
    return geometry::ordered_sum(
        cubes.size(), grain, std::size_t{0}, [&](std::size_t begin, std::size_t end) {
            std::size_t count = 0;
            cubes.for_each(begin, end, [&](std::size_t, const CornerRuns::Corners& corners) {
                geometry::Mat3 gradient = geometry::Mat3::Zero();  // mean deformation
                const double h = body.edge_at(corners[0]);
                for (unsigned a = 0; a < 8; ++a) {
                    const Vec3 p = Eigen::Map<const Vec3>(x + 4 * std::size_t{corners[a]});
                    for (unsigned j = 0; j < 3; ++j) {
                        gradient.col(j) += (a >> j & 1 ? 0.25 : -0.25) / h * p;
                    }
                }
                count += !(gradient.determinant() >= least);
            });
            return count;
        });
}

}  // namespace physics
