#include "physics/body/flat_cells.hpp"

#include <numeric>
#include <optional>

namespace physics {
namespace {

std::optional<std::array<std::uint32_t, 4>> flat_corners(const CornerRuns::Corners& k)
{
    for (std::size_t flat = 1; flat < 8; flat *= 2) {
        bool is_flat = true;
        for (std::size_t a = 0; a < 8; ++a) is_flat &= k[a] == k[a | flat];
        const std::size_t u = flat == 1 ? 2 : 1, v = flat == 4 ? 2 : 4;
        if (is_flat) return std::array{k[0], k[u], k[v], k[u | v]};
    }
    return std::nullopt;
}

}  // namespace

FlatCells flat_cells(const CornerBody& body)
{
    FlatCells out;
    const CornerRuns& corners = body.skin.corners;
    corners.for_each(0, corners.size(), [&](std::size_t c, const auto& of) {
        const auto flat = flat_corners(of);
        if (!flat) return;
        out.cell.push_back(static_cast<std::uint32_t>(c));
        out.corner.push_back(*flat);
    });
    out.first.assign(body.corners + 1, 0);
    for (const auto& cell : out.corner) {
        for (const std::uint32_t slot : cell) ++out.first[slot + 1];
    }
    std::partial_sum(out.first.begin(), out.first.end(), out.first.begin());
    out.of.resize(out.first.back());
    std::vector<std::uint32_t> next(out.first.begin(), out.first.end() - 1);
    for (std::uint32_t c = 0; c < out.corner.size(); ++c) {
        for (const std::uint32_t slot : out.corner[c]) out.of[next[slot]++] = c;
    }
    return out;
}

}  // namespace physics
