#include "physics/bricks/brick_layout.hpp"

#include "geometry/base/no_index.hpp"

#include <algorithm>
#include <numeric>

namespace physics {
namespace {

using geometry::no_index;

using Cut = std::vector<std::pair<std::size_t, std::size_t>>;

// Halves order[begin, end) across its longest side until each part is small enough: at a plane
// between layers where one lies near the middle, else in the middle of a layer.
void bisect(const geometry::Cubes& cubes, std::vector<std::uint32_t>& order, std::size_t begin,
            std::size_t end, std::size_t most, Cut& parts)
{
    if (end - begin <= most) {
        parts.emplace_back(begin, end);
        return;
    }
    Eigen::Vector3i lo = cubes.cell[order[begin]], hi = lo;
    for (std::size_t i = begin; i < end; ++i) {
        lo = lo.cwiseMin(cubes.cell[order[i]]);
        hi = hi.cwiseMax(cubes.cell[order[i]]);
    }
    // in 64 bits: cells may lie anywhere
    Eigen::Index axis = 0;
    (hi.cast<std::int64_t>() - lo.cast<std::int64_t>()).maxCoeff(&axis);
    std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin),
              order.begin() + static_cast<std::ptrdiff_t>(end),
              [&](std::uint32_t a, std::uint32_t b) {
                  const int ca = cubes.cell[a][axis], cb = cubes.cell[b][axis];
                  return ca != cb ? ca < cb : a < b;
              });
    const std::size_t middle = begin + (end - begin) / 2;
    const auto layer = [&](std::size_t i) { return cubes.cell[order[i]][axis]; };
    std::size_t down = middle, up = middle;
    while (down > begin && layer(down - 1) == layer(middle)) --down;
    while (up < end && layer(up) == layer(middle)) ++up;
    std::size_t cut = middle - down < up - middle ? down : up;
    const std::size_t quarter = (end - begin) / 4;
    if (cut < begin + quarter || cut > end - quarter) cut = middle;
    bisect(cubes, order, begin, cut, most, parts);
    bisect(cubes, order, cut, end, most, parts);
}

constexpr std::uint32_t several_pieces = no_index - 1;

// The cubes in the order of their pieces, each piece a range of them in their own order.
struct PieceCubes {
    std::vector<std::uint32_t> order;
    Cut parts;
};

PieceCubes cut_into_pieces(const geometry::Cubes& cubes, std::size_t most,
                           std::span<const std::uint32_t> cuts)
{
    PieceCubes out;
    out.order.resize(cubes.count());
    std::iota(out.order.begin(), out.order.end(), 0u);
    std::size_t done = 0;
    const auto cut_at = [&](std::size_t to) {
        if (done < to) bisect(cubes, out.order, done, to, most, out.parts);
        done = to;
    };
    for (const std::uint32_t cut : cuts) cut_at(cut);
    cut_at(cubes.count());
    for (const auto& [begin, end] : out.parts) {
        std::sort(out.order.begin() + static_cast<std::ptrdiff_t>(begin),
                  out.order.begin() + static_cast<std::ptrdiff_t>(end));
    }
    return out;
}

// Which piece has each corner: none, one, or several.
std::vector<std::uint32_t> find_owners(const geometry::Cubes& cubes, const PieceCubes& pieces)
{
    std::vector<std::uint32_t> owner(cubes.corner_count(), no_index);
    for (std::uint32_t p = 0; p < pieces.parts.size(); ++p) {
        for (std::size_t i = pieces.parts[p].first; i < pieces.parts[p].second; ++i) {
            for (const std::uint32_t k : cubes.corners[pieces.order[i]]) {
                if (owner[k] == no_index) owner[k] = p;
                if (owner[k] != p) owner[k] = several_pieces;
            }
        }
    }
    return owner;
}

// Slots: each piece's own corners as its cubes meet them, then the shared ones, then those of no
// cube at all. Makes the pieces. Returns how many slots there are.
std::uint32_t number_slots(const geometry::Cubes& cubes, const PieceCubes& pieces, BrickLayout& out)
{
    const std::vector<std::uint32_t> owner = find_owners(cubes, pieces);
    out.corners = cubes.corner_count();
    out.slot.assign(out.corners, no_index);
    std::uint32_t next = 0;
    for (std::uint32_t p = 0; p < pieces.parts.size(); ++p) {
        BrickPiece piece;
        piece.first_corner = next;
        for (std::size_t i = pieces.parts[p].first; i < pieces.parts[p].second; ++i) {
            for (const std::uint32_t k : cubes.corners[pieces.order[i]]) {
                if (owner[k] == p && out.slot[k] == no_index) out.slot[k] = next++;
            }
        }
        piece.last_corner = next;
        out.pieces.push_back(piece);
    }
    out.shared = next;
    for (std::size_t k = 0; k < out.corners; ++k) {
        if (out.slot[k] == no_index) out.slot[k] = next++;
    }
    return next;
}

// Copies of shared corners while blocks are laid out.
struct Copies {
    std::uint32_t next;                             // slot of the next copy
    std::vector<std::vector<std::uint32_t>> slots;  // of the copies of each shared corner
    std::vector<std::uint32_t> in_piece;            // by corner, of the piece at hand, or no_index
    std::vector<std::uint32_t> met;                 // corners with a copy in the piece at hand
};

// Where a piece adds to corner k.
std::uint32_t slot_to_add_to(const BrickLayout& layout, std::uint32_t k, Copies& copies)
{
    const std::uint32_t slot = layout.slot[k];
    if (slot < layout.shared) return slot;
    if (copies.in_piece[k] == no_index) {
        copies.in_piece[k] = copies.next++;
        copies.met.push_back(k);
        copies.slots[slot - layout.shared].push_back(copies.in_piece[k]);
    }
    return copies.in_piece[k];
}

// The cubes order[begin, end) of one piece, 16 at a time.
void add_blocks(const geometry::Cubes& cubes, const std::vector<std::uint32_t>& order,
                std::size_t begin, std::size_t end, Copies& copies, BrickLayout& out)
{
    for (std::size_t i = begin; i < end; i += block_lanes) {
        const std::size_t last = std::min(i + block_lanes, end) - 1;
        std::array<std::array<std::uint32_t, block_lanes>, 8> from, to;
        for (std::size_t lane = 0; lane < block_lanes; ++lane) {
            // Lanes past the end repeat the last cube; they are given no stiffness.
            const std::uint32_t c = order[std::min(i + lane, last)];
            out.cube.push_back(i + lane <= last ? c : no_index);
            for (std::size_t a = 0; a < 8; ++a) {
                const std::uint32_t k = cubes.corners[c][a];
                from[a][lane] = out.slot[k];
                to[a][lane] = slot_to_add_to(out, k, copies);
            }
        }
        for (std::size_t a = 0; a < 8; ++a) {
            out.gather.insert(out.gather.end(), from[a].begin(), from[a].end());
            out.scatter.insert(out.scatter.end(), to[a].begin(), to[a].end());
        }
    }
}

}  // namespace

BrickLayout lay_out_bricks(const geometry::Cubes& cubes, std::size_t piece_cubes,
                           std::span<const std::uint32_t> cuts)
{
    BrickLayout out;
    const PieceCubes pieces = cut_into_pieces(cubes, piece_cubes, cuts);
    const std::uint32_t slots = number_slots(cubes, pieces, out);
    Copies copies;
    copies.next = (slots + 3) / 4 * 4;  // whole runs of 16 numbers, see padded_numbers()
    copies.slots.resize(out.corners - out.shared);
    copies.in_piece.assign(out.corners, no_index);
    for (std::size_t p = 0; p < out.pieces.size(); ++p) {
        BrickPiece& piece = out.pieces[p];
        piece.first_block = static_cast<std::uint32_t>(out.blocks());
        piece.first_copy = copies.next;
        add_blocks(cubes, pieces.order, pieces.parts[p].first, pieces.parts[p].second, copies, out);
        for (const std::uint32_t k : copies.met) copies.in_piece[k] = no_index;
        copies.met.clear();
        piece.last_block = static_cast<std::uint32_t>(out.blocks());
        piece.last_copy = copies.next;
    }
    out.slots = copies.next;
    out.copy_at.push_back(0);
    for (const auto& list : copies.slots) {
        out.copy.insert(out.copy.end(), list.begin(), list.end());
        out.copy_at.push_back(static_cast<std::uint32_t>(out.copy.size()));
    }
    return out;
}

}  // namespace physics
