#include "physics/brick_layout.hpp"

#include <algorithm>
#include <numeric>

namespace physics {
namespace {

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

}  // namespace

BrickLayout lay_out_bricks(const geometry::Cubes& cubes, std::size_t piece_cubes)
{
    BrickLayout out;
    out.corners = cubes.corner_count();
    std::vector<std::uint32_t> order(cubes.count());
    std::iota(order.begin(), order.end(), 0u);
    Cut parts;
    if (!order.empty()) bisect(cubes, order, 0, order.size(), piece_cubes, parts);
    for (const auto& [begin, end] : parts) {
        std::sort(order.begin() + static_cast<std::ptrdiff_t>(begin),
                  order.begin() + static_cast<std::ptrdiff_t>(end));
    }

    // Which piece has each corner: none, one, or several.
    constexpr std::uint32_t none = 0xffffffff, several = 0xfffffffe;
    std::vector<std::uint32_t> owner(out.corners, none);
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        for (std::size_t i = parts[p].first; i < parts[p].second; ++i) {
            for (const std::uint32_t k : cubes.corners[order[i]]) {
                if (owner[k] == none) owner[k] = p;
                if (owner[k] != p) owner[k] = several;
            }
        }
    }

    // Slots: each piece's own corners as its cubes meet them, then the shared ones, then those of
    // no cube at all.
    out.slot.assign(out.corners, none);
    std::uint32_t next = 0;
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        BrickPiece piece;
        piece.first_corner = next;
        for (std::size_t i = parts[p].first; i < parts[p].second; ++i) {
            for (const std::uint32_t k : cubes.corners[order[i]]) {
                if (owner[k] == p && out.slot[k] == none) out.slot[k] = next++;
            }
        }
        piece.last_corner = next;
        out.pieces.push_back(piece);
    }
    out.shared = next;
    for (std::size_t k = 0; k < out.corners; ++k) {
        if (out.slot[k] == none) out.slot[k] = next++;
    }

    next = (next + 3) / 4 * 4;  // whole runs of 16 numbers, see padded_numbers()

    std::vector<std::vector<std::uint32_t>> copies(out.corners - out.shared);
    std::vector<std::uint32_t> copy_of(out.corners, none);  // in the piece at hand
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        BrickPiece& piece = out.pieces[p];
        piece.first_block = static_cast<std::uint32_t>(out.blocks());
        piece.first_copy = next;
        std::vector<std::uint32_t> met;
        for (std::size_t i = parts[p].first; i < parts[p].second; i += block_lanes) {
            const std::size_t last = std::min(i + block_lanes, parts[p].second) - 1;
            std::array<std::array<std::uint32_t, block_lanes>, 8> from, to;
            for (std::size_t lane = 0; lane < block_lanes; ++lane) {
                // Lanes past the end repeat the last cube; they are given no stiffness.
                const std::uint32_t c = order[std::min(i + lane, last)];
                out.cube.push_back(i + lane <= last ? c : no_cube);
                for (std::size_t a = 0; a < 8; ++a) {
                    const std::uint32_t k = cubes.corners[c][a];
                    from[a][lane] = to[a][lane] = out.slot[k];
                    if (out.slot[k] < out.shared) continue;
                    if (copy_of[k] == none) {
                        copy_of[k] = next++;
                        met.push_back(k);
                        copies[out.slot[k] - out.shared].push_back(copy_of[k]);
                    }
                    to[a][lane] = copy_of[k];
                }
            }
            for (std::size_t a = 0; a < 8; ++a) {
                out.gather.insert(out.gather.end(), from[a].begin(), from[a].end());
                out.scatter.insert(out.scatter.end(), to[a].begin(), to[a].end());
            }
        }
        for (const std::uint32_t k : met) copy_of[k] = none;
        piece.last_block = static_cast<std::uint32_t>(out.blocks());
        piece.last_copy = next;
    }
    out.slots = next;
    out.copy_at.push_back(0);
    for (const auto& list : copies) {
        out.copy.insert(out.copy.end(), list.begin(), list.end());
        out.copy_at.push_back(static_cast<std::uint32_t>(out.copy.size()));
    }
    return out;
}

}  // namespace physics
