#pragma once

// How the cubes of a body lie in memory while they are simulated: in blocks for SIMD, in pieces for
// threads.
//
// Cubes go through SIMD lanes in blocks of 16, whatever the width of the processor, so that sums
// come in the same order everywhere. Blocks are gathered in pieces, compact runs of cubes that one
// thread works on at a time. A corner whose cubes are all of one piece belongs to it, so that the
// piece adds its forces there directly; a corner between pieces has a copy in each of them, and the
// copies are summed in order afterwards. No two threads ever write the same place, and the sums do
// not depend on the number of threads.
//
//   slot      0 .. corners                     .. slots
//             [ piece 0 | piece 1 | .. | shared ][ copies of piece 0 | copies of piece 1 | .. ]

#include "geometry/cubes/cubes.hpp"
#include "physics/math/aligned_memory.hpp"

#include <span>

namespace physics {

inline constexpr std::size_t block_lanes = 16;
struct BrickPiece {
    std::uint32_t first_block = 0, last_block = 0;
    std::uint32_t first_corner = 0, last_corner = 0;  // its own slots
    std::uint32_t first_copy = 0, last_copy = 0;      // its copies' slots
};

struct BrickLayout {
    std::size_t corners = 0;  // K
    std::size_t slots = 0;    // K, up to a multiple of 4, and all copies
    std::size_t shared = 0;   // the slots shared .. corners have copies

    std::vector<std::uint32_t> slot;     // K, of each corner of the cubes
    std::vector<std::uint32_t> cube;     // B x 16, or no_index in the last block of a piece
    Aligned<std::uint32_t> gather;       // B x 8 x 16, slots to read
    Aligned<std::uint32_t> scatter;      // B x 8 x 16, slots to add to
    std::vector<std::uint32_t> copy_at;  // corners - shared + 1, into copy
    std::vector<std::uint32_t> copy;     // slots of the copies of each shared corner
    std::vector<BrickPiece> pieces;

    std::size_t blocks() const { return cube.size() / block_lanes; }
};

// Cuts the cubes into pieces of at most `piece_cubes`, and at the cubes `cuts` (ascending), so that
// no piece has cubes from before and after one.
BrickLayout lay_out_bricks(const geometry::Cubes& cubes, std::size_t piece_cubes = 1024,
                           std::span<const std::uint32_t> cuts = {});

}  // namespace physics
