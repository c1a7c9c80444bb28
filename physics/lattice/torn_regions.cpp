#include "physics/lattice/torn_regions.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace physics {

TornRegions::Found TornRegions::find(const MatchedRegions& whole,
                                     const std::vector<std::uint32_t>& broken)
{
    std::unique_ptr<TornSums> torn;
    Found before;
    std::vector<std::uint32_t> already;
    {
        const std::lock_guard lock(mutex_);
        auto from = kept_.end();
        for (auto kept = kept_.begin(); kept != kept_.end(); ++kept) {
            if (kept->broken == broken) {
                kept_.splice(kept_.begin(), kept_, kept);
                return kept_.front().found;
            }
            if (!kept->sums || kept->sums->is_worn(kept->found->regions.partial) ||
                (from != kept_.end() && from->broken.size() >= kept->broken.size()))
                continue;
            if (std::includes(broken.begin(), broken.end(), kept->broken.begin(),
                              kept->broken.end())) {
                from = kept;
            }
        }
        if (from != kept_.end()) {
            torn = std::move(from->sums);
            before = from->found;
            already = from->broken;
        }
    }
    // Not under the lock: it runs on all threads.
    if (!torn) torn = std::make_unique<TornSums>(lattice_, whole.regions);
    std::vector<std::uint32_t> fresh;
    std::set_difference(broken.begin(), broken.end(), already.begin(), already.end(),
                        std::back_inserter(fresh));
    std::erase_if(fresh, [&](std::uint32_t link) {
        return link / 3 >= lattice_.count() || lattice_.next[link / 3][link % 3] == none;
    });
    torn->break_links(fresh);
    const auto found =
        std::make_shared<const MatchedRegions>(match(whole, before ? *before : whole, *torn));
    const std::lock_guard lock(mutex_);
    kept_.push_front({broken, found, std::move(torn)});
    if (kept_.size() > most) kept_.pop_back();
    return found;
}

MatchedRegions TornRegions::match(const MatchedRegions& whole, const MatchedRegions& before,
                                  const TornSums& torn) const
{
    MatchedRegions out;
    out.regions = whole.regions;
    out.regions.partial = torn.partial();
    out.mass = before.mass;
    out.held_by = before.held_by;
    out.rate_sq = before.rate_sq;
    out.bend_sq = before.bend_sq;
    out.inverse_spread = before.inverse_spread;
    out.twist = before.twist;
    out.poisson = before.poisson;
    out.volume_gain = before.volume_gain;
    out.volume = before.volume;
    out.stretch = before.stretch;  // of a piece as it was made
    const auto lost = torn.lost();
    std::vector<std::uint32_t> fresh;
    for (std::uint32_t i = 0; i < lost.size(); ++i) {
        if (lost[i] == 0) continue;
        const double holders = std::round(1 / double(whole.held_by[i])) - lost[i];
        const auto held_by = float(1 / holders);
        if (held_by == out.held_by[i]) continue;
        fresh.push_back(i);
        out.mass[i] = float(matter_[i][1] / holders);
        out.held_by[i] = held_by;
    }
    // Rates of partial regions, by the sums that they share; those of full ones stay.
    const PartialRegions& e = out.regions.partial;
    std::vector<RegionMatter> matter(e.nodes());
    for (std::size_t n = 0; n < matter.size(); ++n) {
        for (std::uint32_t k = e.child_at[n]; k < e.child_at[n + 1]; ++k) {
            const auto& part = n < e.bars ? matter_[e.child[k]] : matter[e.child[k]];
            for (std::size_t d = 0; d < part.size(); ++d) matter[n][d] += part[d];
        }
    }
    for (std::size_t i = 0; i < e.region.size(); ++i) {
        const auto rates = rates_of(matter[e.bars + e.plates + i], out.regions.half_width, h_);
        out.rate_sq[e.region[i]] = rates.rate_sq;
        if (out.regions.flat) out.bend_sq[e.region[i]] = rates.bend_sq;
        if (out.poisson.empty()) continue;
        out.poisson[e.region[i]] = rates.poisson;
        out.volume_gain[e.region[i]] = rates.volume_gain;
    }
    if (with_spread_ || out.regions.flat || !out.poisson.empty()) {
        // A region that changes loses a particle, and one that is lost weighs more in the others.
        std::vector<std::uint8_t> changed(out.regions.slots(), 0);
        for (const auto slot : torn.slots_around(fresh)) changed[slot] = 1;
        find_spread(out, lattice_, with_spread_, [&](std::size_t s) { return changed[s] != 0; });
    }
    return out;
}

// Of the last few sets of links nothing counts: they come and go.
std::size_t TornRegions::bytes() const
{
    return lattice_.at.size() * sizeof lattice_.at[0] +
           lattice_.next.size() * sizeof lattice_.next[0] + matter_.size() * sizeof matter_[0];
}

}  // namespace physics
