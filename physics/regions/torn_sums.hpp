#pragma once

// The regions of a lattice while its links break: only those near a break are updated. The result
// depends on which links are broken, not on their order.

#include "physics/regions/shared_sums.hpp"

namespace physics {

class TornSums {
public:
    // `whole` are the regions of `lattice`, which must outlive it.
    TornSums(const Lattice& lattice, const LatticeRegions& whole);

    // Breaks links, 3 * particle + axis each, that are there and not broken yet.
    void break_links(std::span<const std::uint32_t> links);

    // Slots whose boxes hold an end of what broke last, ascending. Some of their regions have
    // changed, no others have.
    std::span<const std::uint32_t> changed() const { return changed_; }
    // Slots whose boxes hold one of these particles, ascending.
    std::vector<std::uint32_t> slots_around(std::span<const std::uint32_t> particles) const;
    // How many regions that held a particle have lost it. N.
    std::vector<std::uint32_t> lost() const;

    PartialRegions partial() const { return sums_.table(runs_.particles(), places_); }
    // Whether most of what is stored is out of date, so that a new one would be smaller; `live` is
    // what partial() returned last.
    bool is_worn(const PartialRegions& live) const { return sums_.is_worn(live); }

private:
    using Pieces = std::vector<Reach::Piece>;
    using Order = std::array<int, 3>;  // z, y, x

    static Order in_order(const Vec3i& p) { return {p[2], p[1], p[0]}; }
    Order place_in_order(std::uint32_t slot) const { return in_order(places_(particle_[slot])); }
    void take(std::span<const std::uint32_t> slots);
    void set(std::span<const std::uint32_t> slots);
    void count_lost(std::uint32_t first, std::uint32_t length, std::uint32_t regions);
    template <class Visit>
    void for_pieces(std::span<const std::uint32_t> slots, const Visit& visit) const;

    const Lattice& lattice_;
    int half_width_;
    bool flat_;
    std::vector<std::uint32_t> particle_;  // of each slot
    TurnedPlaces places_;
    Runs runs_;
    SharedSums sums_;
    std::vector<std::uint32_t> by_place_;  // slots with a particle, by its place in_order()
    std::vector<std::uint32_t> lost_;      // N + 1, differences along Runs::particles()
    std::vector<std::uint32_t> changed_;
};

}  // namespace physics
