#pragma once

// Where separate pieces of a mesh come together in cubes: which of them share corners, by points of
// their triangles at most half a cube apart.

#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/pieces.hpp"

#include <span>

namespace geometry {

// A mesh in its cubes.
struct PlacedMesh {
    const TriMesh& mesh;
    const Pieces& pieces;
    const Cubes& cubes;
    CubeFinder finder;                 // of the cubes
    std::vector<std::uint32_t> cube;   // V, that holds the vertex
    std::vector<std::uint32_t> piece;  // V, no_index where no triangle uses the vertex

    // Of some triangles that follow each other, as far as they may meet another piece.
    struct Block {
        std::vector<std::uint32_t> first;  // into cubes, and one more that ends the last
        std::vector<std::uint32_t> cubes;
    };
    std::vector<Block> blocks;

    Vec3 point(std::uint32_t v) const { return mesh.positions[v].cast<double>(); }
    // That hold points of the triangle; none where it is not finite, or far from other pieces.
    std::span<const std::uint32_t> cubes_of(std::size_t triangle) const;
};

// The mesh, its pieces and the cubes must outlive the result. The same for any number of threads.
PlacedMesh place_mesh(const TriMesh& mesh, const Pieces& pieces, const Cubes& cubes);

using PiecePair = std::array<std::uint32_t, 2>;  // the lower number first

struct PieceMeetings {
    std::vector<PiecePair> pairs;  // sorted
    std::vector<PiecePair> at;     // the first piece at each corner, and the first other one
    enum Near : std::uint8_t {
        far,
        beside,  // shares a corner with a cube of the next kind
        here,    // has a corner where pieces meet
    };
    std::vector<Near> near;  // C

    bool any(std::span<const std::uint32_t> cubes, Near at_least) const;
};

// Looks for this many pairs.
PieceMeetings find_piece_meetings(const PlacedMesh& placed, std::size_t most_pairs);

// Points of the two pieces of each pair where they come together.
std::vector<std::array<std::vector<Vec3>, 2>> points_of_pairs(const PlacedMesh& placed,
                                                              const PieceMeetings& meetings);

}  // namespace geometry
