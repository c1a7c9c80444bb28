#include "physics/body/sheet_crossings.hpp"

#include "geometry/base/stop.hpp"
#include "physics/body/sheet_cells.hpp"

#include <algorithm>
#include <map>
#include <optional>

namespace physics {
namespace {

using geometry::Box3f;

// Where the segment from p to q goes through the triangle.
std::optional<Vec3> crossing(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& triangle)
{
    const auto& [a, b, c] = triangle;
    const Vec3 normal = (b - a).cross(c - a);
    const double above_p = normal.dot(p - a), above_q = normal.dot(q - a);
    if ((above_p >= 0) == (above_q >= 0)) return {};
    const Vec3 x = p + above_p / (above_p - above_q) * (q - p);
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 &from = triangle[i], &to = triangle[(i + 1) % 3];
        if (normal.dot((to - from).cross(x - from)) < -1e-9 * normal.squaredNorm()) return {};
    }
    return x;
}

}  // namespace

std::vector<SheetCrossing> sheet_crossings(const CornerBody& body)
{
    if (!body.sheets) return {};
    const SheetCells& cells = *body.sheets;
    const auto place = [&](std::uint32_t slot) -> Vec3 {
        return Eigen::Map<const Vec3>(body.rest.data() + 4 * std::size_t{slot});
    };
    std::map<std::pair<std::size_t, std::size_t>, Vec3> found;
    geometry::StopCheck stop;
    for (std::uint32_t own = 0; own < cells.cell.size(); ++own) {
        for (auto e = cells.edge_at[own]; e < cells.edge_at[own + 1]; ++e) {
            stop();
            const std::uint32_t i = cells.edge[e][0], j = cells.edge[e][1];
            const Vec3 p = place(i), q = place(j);
            Box3f box;
            box.add(p.cast<float>());
            box.add(q.cast<float>());
            cells.tree.overlapping(box, [&](std::uint32_t other) {
                const std::pair<std::size_t, std::size_t> two =
                    std::minmax(cells.model[own], cells.model[other]);
                if ((two.first == two.second && !cells.self) || found.contains(two)) return;
                for (std::size_t t = 2 * std::size_t{other}; t < 2 * std::size_t{other} + 2; ++t) {
                    const auto& k = cells.triangle[t];
                    const auto has = [&](std::uint32_t slot) {
                        return std::find(k.begin(), k.end(), slot) != k.end();
                    };
                    if (has(i) || has(j) || k[0] == k[1] || k[1] == k[2] || k[2] == k[0]) continue;
                    const auto at = crossing(p, q, {place(k[0]), place(k[1]), place(k[2])});
                    if (at) found.emplace(two, *at);
                }
            });
        }
    }
    std::vector<SheetCrossing> out;
    for (const auto& [models, at] : found) out.push_back({models, at});
    return out;
}

}  // namespace physics
