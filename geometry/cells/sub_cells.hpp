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

// What a step does to the quarters of a word: those `from` are shifted.
struct Move {
    SubCells from = 0;
    int shift = 0;

    constexpr SubCells operator()(SubCells s) const
    {
        return shift >= 0 ? (s & from) << shift : (s & from) >> -shift;
    }
};

// Where quarters come to lie that take `step` and thereby go over into the cell `cells` further
// on, in that cell's numbering; those that land in another cell are dropped.
constexpr Move move_of(const Step& step, const Step& cells = {0, 0, 0})
{
    Move out{all_sub_cells, 0};
    for (std::size_t k = 0; k < 3; ++k) {
        if (step[k] == 0) {
            if (cells[k] != 0) return {};
            continue;
        }
        const SubCells last = detail::layers[k][step[k] > 0 ? 3 : 0];
        if (cells[k] == 0)
            out.from &= ~last;
        else if (cells[k] == step[k])
            out.from &= last;
        else
            return {};
        out.shift += (step[k] - across_cell * cells[k]) * (1 << (2 * k));
    }
    return out;
}

constexpr SubCells landed(SubCells from, const Step& step, const Step& cells = {0, 0, 0})
{
    return move_of(step, cells)(from);
}

// Within a cell.
inline constexpr std::array<Move, steps.size()> moves_on = [] {
    std::array<Move, steps.size()> out;
    for (std::size_t d = 0; d < steps.size(); ++d) out[d] = move_of(steps[d]);
    return out;
}();
inline constexpr std::array<Move, steps.size()> moves_back = [] {
    std::array<Move, steps.size()> out;
    for (std::size_t d = 0; d < steps.size(); ++d) out[d] = move_of(backwards(steps[d]));
    return out;
}();

}  // namespace geometry
