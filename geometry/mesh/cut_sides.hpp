#pragma once

// Triangles cut at the middles of their long sides, without gaps.

#include "geometry/mesh/mesh_fwd.hpp"

#include <unordered_map>
#include <vector>

namespace geometry {

// The middles of sides, each made once, at the end of the positions.
class SideMiddles {
public:
    explicit SideMiddles(std::vector<Vec3f>& positions) : positions_(positions) {}

    std::uint32_t of(std::uint32_t a, std::uint32_t b);

private:
    std::vector<Vec3f>& positions_;
    std::unordered_map<std::uint64_t, std::uint32_t> by_side_;
};

// Cuts each triangle, once, at the middles of its sides that are longer than `longest` (m). Returns
// whether there was one. Triangles that share a side share what becomes of it.
bool cut_sides(double longest, std::vector<Vec3f>& positions, std::vector<Triangle>& triangles);

}  // namespace geometry
