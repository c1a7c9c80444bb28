#pragma once

// The votes of rays on points in cells: inside or not.

#include "geometry/cells/crossings.hpp"

#include <span>
#include <vector>

namespace geometry {

// How many axes must vote: on a closed mesh the rays of one speak for all six.
int axes_needed(const LatticeMesh& mesh, Inside rule);

// Adds one axis's votes at per_cell^3 points in each cell: votes[cell per_cell^3 + x + y per_cell +
// z per_cell^2]. `cells` sorted by (z, y, x). `windings`, unless empty: which winding numbers the
// lines run through in each cell for longer than a thousandth of it, as bits of winding_bit().
void add_votes(const LatticeMesh& mesh, Inside rule, int axis, int per_cell,
               std::span<const Vec3i> cells, std::vector<std::int8_t>& votes,
               std::span<std::uint8_t> windings = {});

// Winding numbers as bits.
struct WindingBit {
    enum : std::uint8_t { plus_one = 1, minus_one = 2, beyond = 4 };
};
inline std::uint8_t winding_bit(int winding)  // not 0
{
    return winding == 1    ? WindingBit::plus_one
           : winding == -1 ? WindingBit::minus_one
                           : WindingBit::beyond;
}

}  // namespace geometry
