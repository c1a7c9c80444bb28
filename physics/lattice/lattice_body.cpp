#include "physics/lattice/lattice_body.hpp"

#include "physics/lattice/torn_regions.hpp"

namespace physics {

Lattice corner_lattice(const geometry::Cubes& cubes)
{
    Lattice lattice;
    lattice.at = cubes.corner;
    lattice.next.assign(cubes.corner_count(), {none, none, none});
    for (const auto& corners : cubes.corners) {
        for (unsigned a = 0; a < 8; ++a) {
            for (unsigned d = 0; d < 3; ++d) {
                const std::uint32_t from = corners[a], to = corners[a | 1u << d];
                if (from != to) lattice.next[from][d] = to;
            }
        }
    }
    return lattice;
}

namespace {

template <class... V> std::size_t bytes_in(const V&... v)
{
    return ((v.size() * sizeof(v[0])) + ...);
}

std::size_t bytes_of(const MatchedRegions& m)
{
    std::size_t sum = bytes_in(m.mass, m.held_by, m.rate_sq, m.bend_sq, m.inverse_spread, m.twist,
                               m.poisson, m.volume_gain, m.volume, m.stretch, m.regions.particle);
    for (const LatticeLines* along : {&m.regions.x, &m.regions.y, &m.regions.z}) {
        sum += bytes_in(along->lines, along->items, along->dead);
    }
    const PartialRegions& e = m.regions.partial;
    return sum + bytes_in(m.regions.slabs) +
           bytes_in(e.region, e.at, e.child_at, e.child, e.parent_at, e.parent, e.particle,
                    e.bar_at, e.bar);
}

}  // namespace

std::size_t LatticeBody::bytes() const
{
    return sizeof *this - sizeof base + base.bytes() + bytes_of(whole) + membrane.bytes() +
           bytes_in(cubes, side, pieces.of) + along.bytes() + (torn ? torn->bytes() : 0);
}

State rest_state(const LatticeBody& body)
{
    State state;
    state.v.assign(body.base.corners, Vec3::Zero());
    state.plastic_strain.assign(body.cubes.size(), 0.0f);
    for (std::size_t k = 0; k < body.base.corners; ++k) {
        state.x.emplace_back(Eigen::Map<const Vec3>(body.base.rest.data() + 4 * k));
    }
    return state;
}

}  // namespace physics
