#include "physics/regions/links.hpp"

#include "geometry/base/union_find.hpp"

#include <algorithm>

namespace physics {

LinkedPieces linked_pieces(const Lattice& lattice, const std::vector<std::uint32_t>& broken)
{
    geometry::Sets sets(lattice.count());
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        for (std::uint32_t d = 0; d < 3; ++d) {
            const std::uint32_t j = lattice.next[i][d];
            if (j != none && !std::binary_search(broken.begin(), broken.end(), 3 * i + d)) {
                sets.join(i, j);
            }
        }
    }
    LinkedPieces out;
    out.of.resize(lattice.count());
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        const std::uint32_t first = sets.root(i);
        out.of[i] = first == i ? std::uint32_t(out.count++) : out.of[first];
    }
    return out;
}

Lattice turned(const Lattice& lattice, const std::array<int, 3>& axes)
{
    Lattice out;
    for (const Vec3i& p : lattice.at) out.at.emplace_back(p[axes[0]], p[axes[1]], p[axes[2]]);
    for (const auto& next : lattice.next) {
        out.next.push_back(
            {next[std::size_t(axes[0])], next[std::size_t(axes[1])], next[std::size_t(axes[2])]});
    }
    return out;
}

}  // namespace physics
