#pragma once

// Where in its pixel each sample lies, from the middle. The renderer moves its pictures there, and
// rays are sent there.

#include <array>

namespace render {

inline constexpr int layer_samples = 4, lattice_samples = 16;

// And by how much the discs of soft light turn.
struct SamplePlace {
    float x = 0, y = 0, turn = 0;
};

// Four places of which no two share a row or a column: an edge or a line at any slant, a quarter
// of a pixel wide or more, meets one of them. As in shaders/edges.frag.
inline constexpr std::array<SamplePlace, layer_samples> in_a_square{
    {{-0.125f, -0.375f}, {0.375f, -0.125f}, {-0.375f, 0.125f}, {0.125f, 0.375f}}};

// One of sixteen, the points of a lattice of rank 1.
constexpr SamplePlace in_a_lattice(int k)
{
    return {(float(k) + 0.5f) / 16 - 0.5f, float((7 * k) % 16) / 16 + 0.5f / 16 - 0.5f,
            float(k) / 16};
}

// The middles of a pixel's quarters, row by row.
inline constexpr std::array<SamplePlace, 4> in_quarters{
    {{-0.25f, -0.25f}, {0.25f, -0.25f}, {-0.25f, 0.25f}, {0.25f, 0.25f}}};

}  // namespace render
