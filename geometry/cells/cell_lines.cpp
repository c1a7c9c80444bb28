#include "geometry/cells/cell_lines.hpp"

namespace geometry {
namespace {

constexpr int fine = 4;  // points along a cell's edge
constexpr std::size_t fine_points = fine * fine * fine;

CellLines lines_along(int first_axis, int end_axis, const LatticeMesh& mesh, Inside rule,
                      std::span<const Vec3i> cells)
{
    std::vector<std::int8_t> votes(cells.size() * fine_points, 0);
    CellLines out;
    out.inside.assign(cells.size(), 0);
    out.windings.assign(cells.size(), 0);
    for (int axis = first_axis; axis < end_axis; ++axis) {
        add_votes(mesh, rule, axis, fine, cells, votes, out.windings);
    }
    for (std::size_t c = 0; c < cells.size(); ++c) {
        for (std::size_t i = 0; i < fine_points; ++i) {
            const bool in = std::abs(votes[c * fine_points + i]) > end_axis - first_axis;
            out.inside[c] |= std::uint64_t{in} << i;
        }
    }
    return out;
}

}  // namespace

CellLines cell_lines(const LatticeMesh& mesh, Inside rule, std::span<const Vec3i> cells)
{
    return axes_needed(mesh, rule) == 1 ? lines_along(0, 1, mesh, rule, cells)
                                        : lines_along(0, 3, mesh, rule, cells);
}

CellLines cell_lines_along(int axis, const LatticeMesh& mesh, Inside rule,
                           std::span<const Vec3i> cells)
{
    return lines_along(axis, axis + 1, mesh, rule, cells);
}

}  // namespace geometry
