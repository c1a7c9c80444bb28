#pragma once

// What ReadMesh says of a single vertex of a file that spoils all that is made of it.

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace nodes {

// Of one that is `far` times as far from the median of all as the next one is; empty: there is
// none.
inline std::string told_of_far_vertex(const geometry::TriMesh& mesh)
{
    constexpr double far = 1e4;
    const std::size_t count = mesh.positions.size();
    if (count < 4 || !geometry::what_place_is_not_finite(mesh).empty()) return {};
    geometry::Vec3 median;
    std::vector<float> values(count);
    for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t v = 0; v < count; ++v) values[v] = mesh.positions[v][axis];
        const auto middle = values.begin() + std::ptrdiff_t(count / 2);
        std::nth_element(values.begin(), middle, values.end());
        median[axis] = *middle;
    }
    double farthest = 0, next = 0;  // m
    std::size_t which = 0;
    for (std::size_t v = 0; v < count; ++v) {
        const double distance = (mesh.positions[v].cast<double>() - median).norm();
        if (distance > farthest) {
            next = farthest, farthest = distance, which = v;
        } else {
            next = std::max(next, distance);
        }
    }
    if (!(farthest > far * next)) return {};
    const geometry::Vec3f& p = mesh.positions[which];
    return fmt::format("vertex {} is at ({:.3g}, {:.3g}, {:.3g}), {:.2g} m from the middle of the "
                       "mesh, and all others lie within {:.2g} m: mend the file",
                       which + 1, p.x(), p.y(), p.z(), farthest, next);
}

}  // namespace nodes
