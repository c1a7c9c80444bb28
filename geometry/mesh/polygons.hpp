#pragma once

// Meshes hold triangles. Those that one polygon of a file was cut into share a number, so that a
// writer finds the polygon again: as the edges of its triangles that do not cancel.

#include "geometry/mesh/mesh_fwd.hpp"

#include <cstdint>
#include <span>

namespace geometry {

// Gives the next `triangles` triangles one number more than the last has, or 0. Polygons of a list
// are numbered 0, 1, 2 and so on in the order of their triangles, which follow each other.
void add_polygon(std::vector<std::uint32_t>& polygon, std::size_t triangles);

// Whether no two triangles share a number: the list says nothing that an empty one would not.
bool has_triangles_only(const std::vector<std::uint32_t>& polygon);

// The same for `gone.size()` triangles without those that are gone. A polygon that loses some of
// its triangles, but not all, falls apart into the others.
std::vector<std::uint32_t> polygons_left(const std::vector<std::uint32_t>& polygon,
                                         std::span<const std::uint8_t> gone);

// The faces of a mesh as a file holds them.
struct Outlines {
    std::vector<std::uint32_t> begin{0};  // P + 1, into corner
    std::vector<std::uint32_t> corner;    // 3 f + k stands for corner k of triangle f

    std::size_t count() const { return begin.size() - 1; }
    std::span<const std::uint32_t> operator[](std::size_t p) const
    {
        return std::span(corner).subspan(begin[p], begin[p + 1] - begin[p]);
    }
    // A polygon of n corners has n - 2 triangles.
    std::size_t first_triangle(std::size_t p) const { return begin[p] - 2 * p; }
    std::size_t most_corners() const;
};

// Polygons in their order, wound as their triangles; triangulate() cuts an undeformed one the same
// way again. A polygon becomes its triangles where their outline is not one loop that passes each
// of their corners once, and where they differ in material, group or, at a corner, in texture
// coordinates. Of several normals at a corner, one counts.
Outlines outlines(const MeshTopology& topology);

}  // namespace geometry
