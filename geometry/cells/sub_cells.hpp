#pragma once

// The 4 x 4 x 4 quarters of a cell as bits x + 4 y + 16 z of a word, and steps between them.

#include "geometry/base/vec.hpp"

#include <array>
#include <cstdint>

namespace geometry {

using SubCells = std::uint64_t;

inline constexpr int across_cell = 4;  // quarters along a cell's edge
inline constexpr SubCells all_sub_cells = ~SubCells{0};

using Step = std::array<int, 3>;

// Half of the steps to the 26 neighbours; the other half are these backwards. The first three lead
// across faces.
inline constexpr std::array<Step, 13> steps{{{1, 0, 0},
                                             {0, 1, 0},
                                             {0, 0, 1},
                                             {1, 1, 0},
                                             {-1, 1, 0},
                                             {1, 0, 1},
                                             {-1, 0, 1},
                                             {0, 1, 1},
                                             {0, -1, 1},
                                             {1, 1, 1},
                                             {-1, 1, 1},
                                             {1, -1, 1},
                                             {-1, -1, 1}}};

constexpr Step backwards(const Step& s)
{
    return {-s[0], -s[1], -s[2]};
}

constexpr unsigned sub_cell_bit(int x, int y, int z)
{
    return static_cast<unsigned>(x + across_cell * (y + across_cell * z));
}

namespace detail {

// Quarters whose coordinate along `axis` is `at`.
constexpr SubCells layer_of(std::size_t axis, int at)
{
    SubCells out = 0;
    for (unsigned i = 0; i < 64; ++i) {
        if (static_cast<int>(i >> (2 * axis) & 3) == at) out |= SubCells{1} << i;
    }
    return out;
}

inline constexpr std::array<std::array<SubCells, 4>, 3> layers = [] {
    std::array<std::array<SubCells, 4>, 3> out{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (int at = 0; at < 4; ++at) out[axis][static_cast<std::size_t>(at)] = layer_of(axis, at);
    }
    return out;
}();

}  // namespace detail

// Where quarters come to lie that take `step` and thereby go over into the cell `cells` further
// on, in that cell's numbering; those that land in another cell are dropped.
constexpr SubCells landed(SubCells from, const Step& step, const Step& cells = {0, 0, 0})
{
    int shift = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (step[k] == 0) {
            if (cells[k] != 0) return 0;
            continue;
        }
        const SubCells last = detail::layers[k][step[k] > 0 ? 3 : 0];
        if (cells[k] == 0)
            from &= ~last;
        else if (cells[k] == step[k])
            from &= last;
        else
            return 0;
        shift += (step[k] - across_cell * cells[k]) * (1 << (2 * k));
    }
    return shift >= 0 ? from << shift : from >> -shift;
}

}  // namespace geometry
