#include "geometry/mesh/cut_sides.hpp"

#include <algorithm>

namespace geometry {

std::uint32_t SideMiddles::of(std::uint32_t a, std::uint32_t b)
{
    const std::uint64_t side = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [found, fresh] =
        by_side_.emplace(side, static_cast<std::uint32_t>(positions_.size()));
    if (fresh) {
        positions_.push_back(
            (0.5 * (positions_[a].cast<double>() + positions_[b].cast<double>())).cast<float>());
    }
    return found->second;
}

bool cut_sides(double longest, std::vector<Vec3f>& positions, std::vector<Triangle>& triangles)
{
    SideMiddles middles(positions);
    std::vector<Triangle> out;
    out.reserve(triangles.size());
    bool any = false;
    for (Triangle t : triangles) {
        std::array<bool, 3> cut{};
        for (std::size_t i = 0; i < 3; ++i) {
            cut[i] = (positions[t[(i + 1) % 3]] - positions[t[i]]).cast<double>().norm() > longest;
        }
        const int cuts = cut[0] + cut[1] + cut[2];
        any |= cuts > 0;
        // Turned so that side 0 is cut, and side 2 is not unless all are.
        while (cuts > 0 && (!cut[0] || (cuts == 2 && cut[2]))) {
            std::rotate(t.begin(), t.begin() + 1, t.end());
            std::rotate(cut.begin(), cut.begin() + 1, cut.end());
        }
        const auto [a, b, c] = t;
        if (cuts == 0) {
            out.push_back(t);
        } else if (cuts == 1) {
            const auto ab = middles.of(a, b);
            out.insert(out.end(), {Triangle{a, ab, c}, Triangle{ab, b, c}});
        } else if (cuts == 2) {
            const auto ab = middles.of(a, b), bc = middles.of(b, c);
            out.insert(out.end(), {Triangle{ab, b, bc}, Triangle{a, ab, bc}, Triangle{a, bc, c}});
        } else {
            const auto ab = middles.of(a, b), bc = middles.of(b, c), ca = middles.of(c, a);
            out.insert(out.end(), {Triangle{a, ab, ca}, Triangle{ab, b, bc}, Triangle{bc, c, ca},
                                   Triangle{ab, bc, ca}});
        }
    }
    triangles = std::move(out);
    return any;
}

}  // namespace geometry
