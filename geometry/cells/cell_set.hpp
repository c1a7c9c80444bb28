#pragma once

// Sets of integer cells that cost memory by what they hold, not by the box around it.
//
//   cells --8x8x8--> blocks of 512 bits --8x8x8--> tiles of 512 block numbers, in a hash table
//
// A shallow tree of fixed fan-out after
// Museth. VDB: high-resolution sparse volumes with dynamic topology. ACM TOG 32(3), 2013.

#include "geometry/base/no_index.hpp"
#include "geometry/base/vec.hpp"

#include <span>
#include <stdexcept>
#include <vector>

namespace geometry {

// Thrown when a set would grow beyond its limit.
struct TooManyCells : std::length_error {
    using std::length_error::length_error;
};

class CellSet {
public:
    // Coordinates are in -extent .. extent - 1.
    static constexpr int extent = 1 << 20;

    explicit CellSet(std::size_t limit = ~std::size_t{0}) : limit_(limit) {}

    // Precondition of all below: coordinates within the extent. Throws TooManyCells.
    void insert(const Vec3i& cell) { insert_run(cell.x(), cell.x(), cell.y(), cell.z()); }
    void insert_run(int x0, int x1, int y, int z)  // cells (x0..x1, y, z), both ends included
    {
        // Most runs lie in the block of the one before.
        if (x0 >> 3 == last_.x && x1 >> 3 == last_.x && y >> 3 == last_.y && z >> 3 == last_.z) {
            return add(last_.block, y, z, (0xffu << (x0 & 7)) & (0xffu >> (7 - (x1 & 7))));
        }
        insert_long_run(x0, x1, y, z);
    }
    // Cells lo + (x, y, z) for bit x of byte y of layers[z * stride], z < n.
    void insert_layers(const Vec3i& lo, int n, const std::uint64_t* layers, std::size_t stride);
    void unite(const CellSet& other);

    bool contains(const Vec3i& cell) const;
    std::size_t count() const { return count_; }
    std::vector<Vec3i> sorted() const;  // by (z, y, x)
    std::size_t bytes() const;

private:
    friend class CellIndex;
    using Block = std::array<std::uint64_t, 8>;  // word z, byte y, bit x

    std::uint32_t find_block(int bx, int by, int bz) const;  // no_index when there is no such block
    std::uint32_t make_block(int bx, int by, int bz);
    std::uint32_t find_tile(std::uint64_t key) const;
    // Most come after one in the same block.
    std::uint32_t block_at(int bx, int by, int bz)
    {
        if (bx != last_.x || by != last_.y || bz != last_.z) {
            last_ = {bx, by, bz, make_block(bx, by, bz)};
        }
        return last_.block;
    }
    void insert_long_run(int x0, int x1, int y, int z);
    void add(std::uint32_t block, int y, int z, unsigned bits)
    {
        add_word(block, z, std::uint64_t{bits} << (8 * (y & 7)));
    }
    void add_word(std::uint32_t block, int z, std::uint64_t wanted)
    {
        std::uint64_t& word = blocks_[block][static_cast<std::size_t>(z & 7)];
        const std::uint64_t fresh = wanted & ~word;
        if (fresh == 0) return;
        word |= wanted;
        note_new(fresh);
    }
    void note_new(std::uint64_t bits);  // counts them

    std::vector<Block> blocks_;
    std::vector<std::uint64_t> block_key_;               // its coordinates, ordered by (z, y, x)
    std::vector<std::array<std::uint32_t, 512>> tiles_;  // block numbers or no_index
    std::vector<std::uint64_t> tile_key_;
    std::vector<std::uint32_t> slots_;  // open addressing, into tiles_; a power of two of them
    std::uint64_t last_key_ = ~std::uint64_t{0};
    std::uint32_t last_tile_ = no_index;
    struct {
        int x = -extent, y = 0, z = 0;  // in blocks, of a block that is there; or far away
        std::uint32_t block = 0;
    } last_;
    std::size_t count_ = 0, limit_;
};

// Finds cells in a sorted list in constant time, in about 4 to 40 bytes a cell.
class CellIndex {
public:
    struct Found {
        std::uint32_t begin = 0, end = 0;  // into the list; more than one for copies of a cell
        explicit operator bool() const { return begin != end; }
    };

    CellIndex() = default;

    // `cells` sorted by (z, y, x), copies allowed, within CellSet's extent.
    explicit CellIndex(std::span<const Vec3i> cells);

    // The same, when a set of just these cells is at hand.
    CellIndex(CellSet set, std::span<const Vec3i> cells);

    // Any coordinates.
    Found find(const Vec3i& cell) const;

    std::size_t bytes() const;

private:
    CellSet set_;
    std::vector<std::array<std::uint32_t, 64>> first_;  // a block: number of each row's first cell
    std::vector<std::uint32_t> copies_;  // where each distinct cell begins; empty without copies
};

// The same cells as rows of runs along x: what sweeps over neighbours read.
struct CellRuns {
    struct Run {
        int x0 = 0, x1 = 0;       // x0 <= x < x1
        std::uint32_t first = 0;  // the number of cell x0 in the list
    };
    struct Row {
        int y = 0, z = 0;
        std::uint32_t first = 0;  // into runs, up to the next row's
    };
    std::vector<Run> runs;
    std::vector<Row> rows;  // by (z, y), and one more that only ends the last
};

// `cells` sorted by (z, y, x), no copies.
CellRuns runs_of(std::span<const Vec3i> cells);

}  // namespace geometry
