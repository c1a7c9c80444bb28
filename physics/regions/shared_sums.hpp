#pragma once

// Partial regions, which do not hold everything in their box, as sums of bars and plates that they
// share. The result depends on the regions alone: however they came about, they are numbered and
// added up in the same order.

#include "physics/regions/lattice_regions.hpp"
#include "physics/regions/lattice_runs.hpp"

#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace physics {

// Numbers what is the same alike, from 0 in the order that it is first seen.
class Numbering {
public:
    // `same(k)` says whether what has number k is this; a new number is count().
    template <class Same> std::uint32_t of(std::uint64_t hash, const Same& same)
    {
        if (2 * hash_.size() >= slot_.size()) grow();
        std::size_t at = place(hash);
        for (; slot_[at] != none; at = (at + 1) & (slot_.size() - 1)) {
            if (hash_[slot_[at]] == hash && same(slot_[at])) return slot_[at];
        }
        slot_[at] = std::uint32_t(hash_.size());
        hash_.push_back(hash);
        return slot_[at];
    }
    std::uint32_t count() const { return std::uint32_t(hash_.size()); }

private:
    std::size_t place(std::uint64_t hash) const { return hash & (slot_.size() - 1); }
    void grow();

    std::vector<std::uint64_t> hash_;
    std::vector<std::uint32_t> slot_ = std::vector<std::uint32_t>(1024, none);
};

// Lists one after another.
struct Lists {
    std::vector<std::uint32_t> at{0}, all;

    void end()
    {
        assert(all.size() < none);
        at.push_back(std::uint32_t(all.size()));
    }
    std::uint32_t count() const { return std::uint32_t(at.size() - 1); }
    std::span<const std::uint32_t> operator[](std::size_t k) const
    {
        return {all.begin() + at[k], all.begin() + at[k + 1]};
    }
};

// Places of particles along the axes that lines run along.
struct TurnedPlaces {
    const std::vector<Vec3i>& at;
    std::array<int, 3> axes;

    Vec3i operator()(std::uint32_t i) const
    {
        return {at[i][axes[0]], at[i][axes[1]], at[i][axes[2]]};
    }
};

class SharedSums {
public:
    using Pieces = std::span<const Reach::Piece>;

    // `most_plates` a region has: 2w + 1, of a plane one.
    explicit SharedSums(std::size_t most_plates) : most_plates_(most_plates) {}

    struct Region {
        std::uint32_t slot, particle;
        std::uint32_t at = 0;  // of its plates
    };

    // Regions that are none of these yet, by slot. Until set() they hold nothing.
    void add(std::span<const Region> regions);
    bool has(std::uint32_t slot) const { return find(slot) != regions_.size(); }
    // By z, then by place.
    void set(std::uint32_t slot, Pieces pieces);
    // Calls visit(first, length) with each piece of a region's, into Runs::particles().
    template <class Visit> void for_each_piece(std::uint32_t slot, const Visit& visit) const
    {
        assert(has(slot));
        const std::uint32_t* plate = plates_of_.data() + regions_[find(slot)].at;
        for (std::size_t p = 0; p < most_plates_ && plate[p] != none; ++p) {
            for (const auto b : plates_[plate[p]]) visit(bars_[b].first, bars_[b].length);
        }
    }

    // Whether most of what is stored is out of date; `live` is what table() returned last.
    bool is_worn(const PartialRegions& live) const
    {
        const std::size_t used = live.child_at[live.bars + live.plates] - live.child_at[live.bars];
        return plates_.all.size() > (std::size_t{1} << 20) + 4 * used;
    }

    PartialRegions table(std::span<const std::uint32_t> particles, TurnedPlaces places) const;

private:
    struct Bar {
        std::uint32_t first, length;
    };
    struct Needed;

    Needed needed() const;
    std::size_t find(std::uint32_t slot) const;

    std::size_t most_plates_;               // of a region
    std::vector<Region> regions_;           // by slot
    std::vector<std::uint32_t> plates_of_;  // most_plates_ a region, none after the last
    Numbering bar_numbers_, plate_numbers_;
    std::vector<Bar> bars_;  // also those that no region has any more
    Lists plates_;           // of bars, likewise
};

}  // namespace physics
