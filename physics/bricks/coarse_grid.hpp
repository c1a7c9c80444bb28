#pragma once

// Cubes of a grid gathered in coarse cells of ratio^3, for multigrid.
//
//   o--o--o--o--o      o-----------o     A coarse cell holds the cubes of its place that hang
//   |  |  |  |  |      |           |     together there by shared corners. Parts of a body that
//   o--o--o--o--o  ->  |           |     only come near each other in one place get coarse cells
//   |  |  |  |  |      |           |     apart, as Nesme and others do for the cubes themselves
//   o--o--o--o--o      o-----------o     (Preserving topology and elasticity for embedded
//                                        deformable models. ACM TOG 28(3), 2009). Two coarse
// cells share a node where they share a corner that the node moves.

#include "geometry/cubes/cubes.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace physics {

using Eight = std::array<std::uint32_t, 8>;

// A grid as a coarser one is made from it. Corners are numbered as in brick_element.hpp.
struct GridView {
    std::span<const geometry::Vec3i> cell;    // C
    std::span<const Eight> corners;           // C, into corner
    std::span<const geometry::Vec3i> corner;  // K, lattice coordinates
};

// Lists of indices, list i at index[first[i]] .. index[first[i + 1]].
struct IndexLists {
    std::vector<std::uint32_t> first{0}, index;

    std::size_t count() const { return first.size() - 1; }
    std::span<const std::uint32_t> of(std::size_t i) const
    {
        return std::span(index).subspan(first[i], first[i + 1] - first[i]);
    }
};

struct CoarseGrid {
    int ratio = 0;
    std::vector<geometry::Vec3i> cell;  // its own, sorted by (z, y, x)
    std::vector<Eight> nodes;           // of each cell, into node
    std::vector<geometry::Vec3i> node;  // lattice coordinates
    IndexLists cells;                   // of each coarse cell, the cells that it holds
    // Of each coarse cell, the corners that its nodes move: each corner that is not left out is
    // moved by one cell (any that holds it would give the same).
    IndexLists corners;
    IndexLists shares;  // of each node, where it is in `nodes`: 8 * cell + number

    GridView view() const { return {cell, nodes, node}; }
};

// Corners that are held along all axes (K, bits as in Pins, or empty: none) are moved by no cell.
CoarseGrid coarsen(const GridView& fine, int ratio, std::span<const std::uint8_t> held = {});

// Where a corner lies in its coarse cell, 0 .. ratio along each axis.
inline geometry::Vec3i place_in_cell(const geometry::Vec3i& corner, const geometry::Vec3i& cell,
                                     int ratio)
{
    return corner - ratio * cell;
}

}  // namespace physics
