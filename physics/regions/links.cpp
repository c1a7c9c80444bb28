#include "physics/regions/links.hpp"

namespace physics {

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
