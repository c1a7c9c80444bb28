#include "physics/lattice/torn_skin.hpp"

#include <algorithm>
#include <numeric>

namespace physics {

namespace {

// The part of each corner of a cube, by the links that join them; 0 throughout: they are joined.
TornSkin::Parts parts_of(const CornerRuns::Corners& corners, const Lattice& lattice,
                         std::span<const std::uint32_t> broken)
{
    TornSkin::Parts part;
    std::iota(part.begin(), part.end(), std::uint8_t{0});
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::uint32_t d = 0; d < 3; ++d) {
            const std::size_t b = a | std::size_t{1} << d;
            const bool same = corners[a] == corners[b];  // a plane has no thickness
            if (b == a || (!same && lattice.next[corners[a]][d] != corners[b])) continue;
            if (!same && std::ranges::binary_search(broken, 3 * corners[a] + d)) continue;
            const auto [low, high] = std::minmax({part[a], part[b]});
            std::ranges::replace(part, high, low);
        }
    }
    return part;
}

}  // namespace

TornSkin::TornSkin(const ContactSurface& skin, const Lattice& lattice,
                   std::span<const std::uint32_t> broken, double h)
    : frames_({lattice.next.data()->data(), lattice.next.data()->data() + 3 * lattice.count()},
              broken, h),
      row_(skin.corners.size(), none)
{
    std::vector<std::uint8_t> open(lattice.count(), 0);  // its links are not what they were
    for (const std::uint32_t link : broken) {
        const std::uint32_t i = link / 3;
        if (i >= lattice.count() || lattice.next[i][link % 3] == none) continue;
        open[i] = open[lattice.next[i][link % 3]] = 1;
    }
    skin.corners.for_each(0, skin.corners.size(), [&](std::size_t c, const auto& corners) {
        if (std::ranges::none_of(corners, [&](std::uint32_t k) { return open[k] != 0; })) return;
        const Parts parts = physics::parts_of(corners, lattice, broken);
        const bool joined = parts == Parts{};
        row_[c] = joined ? none - 1 : std::uint32_t(parts_.size());
        if (!joined) parts_.push_back(parts);
    });
    find_bare(skin, std::move(open));
}

void TornSkin::find_bare(const ContactSurface& skin, std::vector<std::uint8_t> open)
{
    skin.corners.for_each(0, skin.corners.size(), [&](std::size_t c, const auto& corners) {
        if (!is_open(c)) return;
        const Parts parts = parts_of(c) ? *parts_of(c) : Parts{};
        const SurfacePatch& patch = skin.on(c);
        for (std::uint32_t i = patch.point; i < patch.points_end; ++i) {
            const auto& weight = skin.point[i];
            const std::uint8_t part = part_of(weight, parts);
            for (std::size_t a = 0; a < 8; ++a) {
                if (parts[a] == part && weight[a] > 0) open[corners[a]] = 0;
            }
        }
    });
    for (std::uint32_t k = 0; k < open.size(); ++k) {
        if (open[k]) bare_.push_back(k);
    }
}

}  // namespace physics
