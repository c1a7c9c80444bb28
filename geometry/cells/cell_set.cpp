#include "geometry/cells/cell_set.hpp"

#include "geometry/base/stop.hpp"

#include <algorithm>
#include <bit>

namespace geometry {
namespace {

constexpr auto bit_counts = [] {
    std::array<std::uint8_t, 256> counts{};
    for (unsigned i = 1; i < 256; ++i) {
        counts[i] = static_cast<std::uint8_t>((i & 1) + counts[i / 2]);
    }
    return counts;
}();

constexpr int shift = 20;  // half of a coordinate's 21 bits, so that packed ones are positive

std::uint64_t pack(int x, int y, int z)
{
    const auto part = [](int v) { return static_cast<std::uint64_t>(v + (1 << shift)); };
    return part(z) << 42 | part(y) << 21 | part(x);
}

int unpack(std::uint64_t key, int axis)
{
    return static_cast<int>(key >> (21 * axis) & 0x1fffff) - (1 << shift);
}

std::uint64_t scatter(std::uint64_t key)
{
    key *= 0x9e3779b97f4a7c15u;
    return key ^ key >> 32;
}

std::size_t within_tile(int bx, int by, int bz)
{
    return static_cast<std::size_t>((bz & 7) << 6 | (by & 7) << 3 | (bx & 7));
}

unsigned row_bits(std::uint64_t word, int y)
{
    return static_cast<unsigned>(word >> (8 * y)) & 0xff;
}

}  // namespace

std::uint32_t CellSet::find_tile(std::uint64_t key) const
{
    if (slots_.empty()) return no_index;
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t at = scatter(key) & mask;; at = (at + 1) & mask) {
        if (slots_[at] == no_index || tile_key_[slots_[at]] == key) return slots_[at];
    }
}

std::uint32_t CellSet::find_block(int bx, int by, int bz) const
{
    const std::uint64_t key = pack(bx >> 3, by >> 3, bz >> 3);
    const std::uint32_t tile = key == last_key_ ? last_tile_ : find_tile(key);
    return tile == no_index ? no_index : tiles_[tile][within_tile(bx, by, bz)];
}

std::uint32_t CellSet::make_block(int bx, int by, int bz)
{
    const std::uint64_t key = pack(bx >> 3, by >> 3, bz >> 3);
    if (key != last_key_) {
        last_key_ = key;
        last_tile_ = find_tile(key);
        if (last_tile_ == no_index) {
            last_tile_ = static_cast<std::uint32_t>(tiles_.size());
            tiles_.emplace_back().fill(no_index);
            tile_key_.push_back(key);
            if (slots_.size() < 2 * tiles_.size()) {
                slots_.assign(std::max<std::size_t>(16, 2 * slots_.size()), no_index);
                for (std::uint32_t t = 0; t < tiles_.size(); ++t) {
                    std::size_t at = scatter(tile_key_[t]);
                    while (slots_[at & (slots_.size() - 1)] != no_index) ++at;
                    slots_[at & (slots_.size() - 1)] = t;
                }
            } else {
                std::size_t at = scatter(key);
                while (slots_[at & (slots_.size() - 1)] != no_index) ++at;
                slots_[at & (slots_.size() - 1)] = last_tile_;
            }
        }
    }
    std::uint32_t& block = tiles_[last_tile_][within_tile(bx, by, bz)];
    if (block == no_index) {
        block = static_cast<std::uint32_t>(blocks_.size());
        blocks_.emplace_back().fill(0);
        block_key_.push_back(pack(bx, by, bz));
    }
    return block;
}

void CellSet::note_new(std::uint64_t bits)
{
    count_ += static_cast<std::size_t>(std::popcount(bits));
    if (count_ > limit_) throw TooManyCells("the set of cells is full");
}

void CellSet::insert_long_run(int x0, int x1, int y, int z)
{
    for (int bx = x0 >> 3; bx <= x1 >> 3; ++bx) {
        const int lo = std::max(x0 - 8 * bx, 0), hi = std::min(x1 - 8 * bx, 7);
        const unsigned bits = (0xffu << lo) & (0xffu >> (7 - hi));
        add(block_at(bx, y >> 3, z >> 3), y, z, bits);
    }
}

void CellSet::insert_layers(const Vec3i& lo, int n, const std::uint64_t* layers, std::size_t stride)
{
    constexpr std::uint64_t column = 0x0101010101010101;
    const int dx = lo.x() & 7, dy = lo.y() & 7;
    // What of each byte stays in the block as it moves up by dx bits.
    const std::uint64_t stays = column * (0xffu << dx & 0xff);
    for (int over_y = 0; over_y < (dy == 0 ? 1 : 2); ++over_y) {
        for (int over_x = 0; over_x < (dx == 0 ? 1 : 2); ++over_x) {
            std::uint32_t block = no_index;
            for (int z = 0; z < n; ++z) {
                const std::uint64_t bits = layers[static_cast<std::size_t>(z) * stride];
                const std::uint64_t in_x =
                    over_x == 0 ? bits << dx & stays : bits >> (8 - dx) & ~stays;
                const std::uint64_t word = over_y == 0 ? in_x << 8 * dy : in_x >> (64 - 8 * dy);
                if ((lo.z() + z) % 8 == 0) block = no_index;
                if (word == 0) continue;
                if (block == no_index) {
                    block =
                        block_at((lo.x() >> 3) + over_x, (lo.y() >> 3) + over_y, (lo.z() + z) >> 3);
                }
                add_word(block, lo.z() + z, word);
            }
        }
    }
}

void CellSet::unite(const CellSet& other)
{
    for (std::size_t b = 0; b < other.blocks_.size(); ++b) {
        const std::uint64_t key = other.block_key_[b];
        const std::uint32_t mine = make_block(unpack(key, 0), unpack(key, 1), unpack(key, 2));
        for (int z = 0; z < 8; ++z) {
            add_word(mine, z, other.blocks_[b][static_cast<std::size_t>(z)]);
        }
    }
}

bool CellSet::contains(const Vec3i& cell) const
{
    const std::uint32_t block = find_block(cell.x() >> 3, cell.y() >> 3, cell.z() >> 3);
    if (block == no_index) return false;
    const std::uint64_t word = blocks_[block][static_cast<std::size_t>(cell.z() & 7)];
    return row_bits(word, cell.y() & 7) >> (cell.x() & 7) & 1;
}

std::vector<Vec3i> CellSet::sorted() const
{
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(blocks_.size());
    for (std::uint32_t b = 0; b < order.size(); ++b) order[b] = {block_key_[b], b};
    std::sort(order.begin(), order.end());

    std::vector<Vec3i> cells(count_);
    std::size_t n = 0;
    constexpr std::uint64_t no_x = ~std::uint64_t{0x1fffff}, no_yx = no_x << 21;
    StopCheck stop;
    for (std::size_t layer = 0, layer_end = 0; layer < order.size(); layer = layer_end) {
        const std::uint64_t key = order[layer].first & no_yx;
        while (layer_end < order.size() && (order[layer_end].first & no_yx) == key) ++layer_end;
        for (int z = 0; z < 8; ++z) {
            for (std::size_t row = layer, row_end = layer; row < layer_end; row = row_end) {
                stop();
                const std::uint64_t row_key = order[row].first & no_x;
                while (row_end < layer_end && (order[row_end].first & no_x) == row_key) ++row_end;
                for (int y = 0; y < 8; ++y) {
                    for (std::size_t i = row; i < row_end; ++i) {
                        const auto [k, b] = order[i];
                        unsigned bits = row_bits(blocks_[b][static_cast<std::size_t>(z)], y);
                        for (; bits != 0; bits &= bits - 1) {
                            cells[n++] = {8 * unpack(k, 0) + std::countr_zero(bits),
                                          8 * unpack(k, 1) + y, 8 * unpack(k, 2) + z};
                        }
                    }
                }
            }
        }
    }
    return cells;
}

std::size_t CellSet::bytes() const
{
    return blocks_.capacity() * sizeof(Block) + block_key_.capacity() * sizeof(std::uint64_t) +
           tiles_.capacity() * sizeof(tiles_[0]) + tile_key_.capacity() * sizeof(std::uint64_t) +
           slots_.capacity() * sizeof(std::uint32_t);
}

namespace {

CellSet set_of(std::span<const Vec3i> cells)
{
    CellSet set;
    for (const Vec3i& cell : cells) set.insert(cell);
    return set;
}

}  // namespace

CellIndex::CellIndex(std::span<const Vec3i> cells) : CellIndex(set_of(cells), cells) {}

CellIndex::CellIndex(CellSet set, std::span<const Vec3i> cells) : set_(std::move(set))
{
    first_.resize(set_.blocks_.size());
    const bool copies = set_.count() != cells.size();
    std::uint32_t number = 0;  // of the distinct cell
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
        const Vec3i& c = cells[i];
        if (copies && i > 0 && c == cells[i - 1]) continue;
        const std::uint32_t b = set_.find_block(c.x() >> 3, c.y() >> 3, c.z() >> 3);
        const auto z = static_cast<std::size_t>(c.z() & 7);
        const unsigned bits = row_bits(set_.blocks_[b][z], c.y() & 7);
        if ((bits & ((1u << (c.x() & 7)) - 1)) == 0) {  // the first of its row
            first_[b][8 * z + static_cast<std::size_t>(c.y() & 7)] = number;
        }
        if (copies) copies_.push_back(i);
        ++number;
    }
    if (copies) copies_.push_back(static_cast<std::uint32_t>(cells.size()));
}

CellIndex::Found CellIndex::find(const Vec3i& c) const
{
    if ((c.array() < -CellSet::extent).any() || (c.array() >= CellSet::extent).any()) return {};
    const std::uint32_t b = set_.find_block(c.x() >> 3, c.y() >> 3, c.z() >> 3);
    if (b == no_index) return {};
    const auto z = static_cast<std::size_t>(c.z() & 7);
    const unsigned bits = row_bits(set_.blocks_[b][z], c.y() & 7);
    if ((bits >> (c.x() & 7) & 1) == 0) return {};
    const std::uint32_t number = first_[b][8 * z + static_cast<std::size_t>(c.y() & 7)] +
                                 bit_counts[bits & ((1u << (c.x() & 7)) - 1)];
    if (copies_.empty()) return {number, number + 1};
    return {copies_[number], copies_[number + 1]};
}

std::size_t CellIndex::bytes() const
{
    return set_.bytes() + first_.capacity() * sizeof(first_[0]) +
           copies_.capacity() * sizeof(std::uint32_t);
}

CellRuns runs_of(std::span<const Vec3i> cells)
{
    CellRuns out;
    StopCheck stop;
    for (std::uint32_t i = 0; i < cells.size();) {
        stop();
        const Vec3i& c = cells[i];
        if (out.rows.empty() || out.rows.back().y != c.y() || out.rows.back().z != c.z()) {
            out.rows.push_back({c.y(), c.z(), static_cast<std::uint32_t>(out.runs.size())});
        }
        CellRuns::Run run{c.x(), c.x() + 1, i};
        for (++i; i < cells.size() && cells[i].x() == run.x1 && cells[i].y() == c.y() &&
                  cells[i].z() == c.z();
             ++i) {
            ++run.x1;
        }
        out.runs.push_back(run);
    }
    out.rows.push_back({0, 0, static_cast<std::uint32_t>(out.runs.size())});
    return out;
}

}  // namespace geometry
