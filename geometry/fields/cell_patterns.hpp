#pragma once

// How a surface passes through a cell of a grid: for each of the 256 patterns of corners inside the
// solid, which of the cell's edges each sheet of the surface crosses.
//
//        6-------7        corner a lies at ((a & 1), (a >> 1 & 1), (a >> 2 & 1));
//       /|      /|        edge 4 d + i runs along axis d;
//      4-------5 |        face 2 d + s is the one across axis d on side s.
//      | 2-----|-3
//      |/      |/         Corner 0 alone inside: one sheet, across the edges 0-1, 0-2 and 0-4.
//      0-------1          Corners 0 and 7: two sheets.
//
// The patterns are derived, not listed. On a face with four crossings the inside corners are cut
// off one by one, and the face's curves are chained around the cell into the sheets' borders.
//
//      o--+--.      o--+--.
//      | /   |      |   \ |      o: corners inside, +: crossings. Left: each corner inside is cut
//      +     +      +     +      off by itself, the rule. Right: each corner outside is.
//      |   / |      | \   |
//      .--+--o      .--+--o
//
// Two cells that share such a face would be joined by it twice where in both of them one sheet
// holds both of its curves. In those patterns it is the only face of its kind, the troublesome one;
// there both cells cut off the outside corners instead, which splits the sheets. So the mesh is a
// manifold.
//   Wenger. Isosurfaces: geometry, topology, and algorithms. CRC Press 2013, 5.3 (manifold dual
//   contouring).

#include <array>
#include <cstdint>

namespace geometry {

constexpr std::uint8_t no_sheet = 0xff;  // an edge that is not crossed
constexpr std::uint8_t no_face = 0xff;

// The sheets of surface in one cell.
struct CellSheets {
    std::uint8_t count = 0;
    std::array<std::uint8_t, 12> of_edge{};  // which sheet crosses it, or no_sheet
};

struct CellPatterns {
    std::array<std::array<std::uint8_t, 2>, 12> edge_corners{};
    // By pattern, a bit for each corner inside; [1]: the troublesome face cut the other way.
    std::array<std::array<CellSheets, 2>, 256> sheets{};
    std::array<std::uint8_t, 256> troublesome{};  // the face, or no_face
};

// Made once.
const CellPatterns& cell_patterns();

}  // namespace geometry
