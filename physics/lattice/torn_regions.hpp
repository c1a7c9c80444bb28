#pragma once

// The regions of a lattice with broken links, kept for the last few sets of links that were asked
// for. When more links break, only the regions around them are updated. The result depends on the
// body and the links alone: what is kept changes how long a step takes, never what it gives.

#include "physics/lattice/matched_regions.hpp"
#include "physics/regions/torn_sums.hpp"

#include <list>
#include <memory>
#include <mutex>

namespace physics {

class TornRegions {
public:
    using Found = std::shared_ptr<const MatchedRegions>;

    TornRegions(Lattice lattice, std::vector<RegionMatter> matter, double h, bool with_spread)
        : lattice_(std::move(lattice)), matter_(std::move(matter)), h_(h), with_spread_(with_spread)
    {}

    // `whole` are the body's own, `broken` as in State; links that never were are none that break.
    Found find(const MatchedRegions& whole, const std::vector<std::uint32_t>& broken);

    const Lattice& lattice() const { return lattice_; }
    std::size_t bytes() const;

private:
    struct Kept {
        std::vector<std::uint32_t> broken;
        Found found;
        std::unique_ptr<TornSums> sums;  // until another goes on from it
    };

    // `before` are those of some of the links.
    MatchedRegions match(const MatchedRegions& whole, const MatchedRegions& before,
                         const TornSums& torn) const;

    static constexpr std::size_t most = 2;
    Lattice lattice_;
    std::vector<RegionMatter> matter_;  // as match_regions() wants it
    double h_;
    bool with_spread_;
    std::mutex mutex_;
    std::list<Kept> kept_;  // newest first
};

}  // namespace physics
