#include "physics/regions/shared_sums.hpp"

#include <algorithm>
#include <numeric>

namespace physics {

namespace {

std::uint64_t mixed(std::uint64_t hash, std::uint64_t with)
{
    hash = (hash ^ with) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 29;
}

// Which lists name each number below `count`, with with(list, place in it) of each, in their order.
template <class With> Lists transposed(const Lists& lists, std::size_t count, const With& with)
{
    Lists out;
    out.at.assign(count + 1, 0);
    for (const auto k : lists.all) ++out.at[k + 1];
    std::partial_sum(out.at.begin(), out.at.end(), out.at.begin());
    out.all.resize(lists.all.size());
    std::vector<std::uint32_t> next(out.at.begin(), out.at.end() - 1);
    for (std::uint32_t l = 0; l < lists.count(); ++l) {
        for (std::uint32_t i = lists.at[l]; i < lists.at[l + 1]; ++i) {
            out.all[next[lists.all[i]]++] = with(l, i - lists.at[l]);
        }
    }
    return out;
}

void add_parents(const Lists& regions, const Lists& plates, PartialRegions& e)
{
    const auto plates_of = transposed(plates, e.bars, [&](auto p, auto) { return e.bars + p; });
    const auto regions_of =
        transposed(regions, e.plates, [&](auto r, auto) { return e.bars + e.plates + r; });
    e.parent_at = plates_of.at;
    e.parent = plates_of.all;
    for (std::uint32_t p = 0; p < e.plates; ++p) {
        e.parent_at.push_back(std::uint32_t(plates_of.all.size()) + regions_of.at[p + 1]);
    }
    e.parent.insert(e.parent.end(), regions_of.all.begin(), regions_of.all.end());
}

void add_bars_of_particles(const Lists& bars, std::size_t particles, PartialRegions& e)
{
    assert(e.bars < 1u << 24);
    auto bars_of = transposed(bars, particles, [](auto b, auto k) { return b * 256 + k; });
    e.bar_at.push_back(0);
    for (std::uint32_t i = 0; i < particles; ++i) {
        if (bars_of[i].empty()) continue;
        e.particle.push_back(i);
        e.bar_at.push_back(bars_of.at[i + 1]);
    }
    e.bar = std::move(bars_of.all);
}

}  // namespace

void Numbering::grow()
{
    slot_.assign(2 * slot_.size(), none);
    for (std::uint32_t k = 0; k < hash_.size(); ++k) {
        std::size_t at = place(hash_[k]);
        while (slot_[at] != none) at = (at + 1) & (slot_.size() - 1);
        slot_[at] = k;
    }
}

void SharedSums::add(std::span<const Region> regions)
{
    const auto before = std::ptrdiff_t(regions_.size());
    for (Region region : regions) {
        region.at = std::uint32_t(plates_of_.size());
        regions_.push_back(region);
        plates_of_.resize(plates_of_.size() + most_plates_, none);
    }
    std::inplace_merge(regions_.begin(), regions_.begin() + before, regions_.end(),
                       [](const Region& a, const Region& b) { return a.slot < b.slot; });
}

std::size_t SharedSums::find(std::uint32_t slot) const
{
    const auto at =
        std::lower_bound(regions_.begin(), regions_.end(), slot,
                         [](const Region& region, std::uint32_t s) { return region.slot < s; });
    return at != regions_.end() && at->slot == slot ? std::size_t(at - regions_.begin())
                                                    : regions_.size();
}

void SharedSums::set(std::uint32_t slot, Pieces pieces)
{
    assert(has(slot));
    std::uint32_t* const plates = plates_of_.data() + regions_[find(slot)].at;
    std::size_t count = 0;
    for (std::size_t i = 0; i < pieces.size();) {
        std::uint64_t hash = 0;
        const std::size_t begin = plates_.all.size();
        for (const int z = pieces[i].z; i < pieces.size() && pieces[i].z == z; ++i) {
            const Bar bar{pieces[i].first, pieces[i].length};
            const auto b = bar_numbers_.of(mixed(bar.first, bar.length), [&](std::uint32_t k) {
                return bars_[k].first == bar.first && bars_[k].length == bar.length;
            });
            if (b == bars_.size()) bars_.push_back(bar);
            plates_.all.push_back(b);
            hash = mixed(hash, b);
        }
        const std::span<const std::uint32_t> plate(plates_.all.begin() + std::ptrdiff_t(begin),
                                                   plates_.all.end());
        const auto p = plate_numbers_.of(hash, [&](std::uint32_t k) {
            const auto other = plates_[k];
            return std::equal(plate.begin(), plate.end(), other.begin(), other.end());
        });
        if (p == plates_.count()) {
            plates_.end();
        } else {
            plates_.all.resize(begin);
        }
        plates[count++] = p;
    }
    if (count < most_plates_) plates[count] = none;
}

// What regions need of plates and bars, numbered as they are first seen, from the first region on.
struct SharedSums::Needed {
    Lists regions, plates;  // of plates, bars
    std::vector<Bar> bars;
};

SharedSums::Needed SharedSums::needed() const
{
    Needed out;
    std::vector<std::uint32_t> plate_number(plates_.count(), none), bar_number(bars_.size(), none);
    std::vector<std::uint32_t> seen_plates;
    for (const Region& region : regions_) {
        const std::uint32_t* plate = plates_of_.data() + region.at;
        for (std::size_t k = 0; k < most_plates_ && plate[k] != none; ++k) {
            auto& number = plate_number[plate[k]];
            if (number == none) {
                number = std::uint32_t(seen_plates.size());
                seen_plates.push_back(plate[k]);
            }
            out.regions.all.push_back(number);
        }
        out.regions.end();
    }
    for (const auto p : seen_plates) {
        for (const auto b : plates_[p]) {
            if (bar_number[b] == none) {
                bar_number[b] = std::uint32_t(out.bars.size());
                out.bars.push_back(bars_[b]);
            }
            out.plates.all.push_back(bar_number[b]);
        }
        out.plates.end();
    }
    return out;
}

PartialRegions SharedSums::table(std::span<const std::uint32_t> particles,
                                 TurnedPlaces places) const
{
    const Needed need = needed();
    const Lists &regions = need.regions, &plates = need.plates;
    Lists bars;  // of particles
    for (const Bar& bar : need.bars) {
        const auto first = particles.begin() + bar.first;
        bars.all.insert(bars.all.end(), first, first + bar.length);
        bars.end();
    }
    PartialRegions e;
    for (const Region& region : regions_) e.region.push_back(region.slot);
    e.bars = bars.count();
    e.plates = plates.count();

    e.child_at = {0};
    const auto add_children = [&](const Lists& lists, std::uint32_t first) {
        for (std::uint32_t k = 0; k < lists.count(); ++k) {
            for (const auto child : lists[k]) e.child.push_back(first + child);
            e.child_at.push_back(std::uint32_t(e.child.size()));
        }
    };
    add_children(bars, 0);
    add_children(plates, 0);
    add_children(regions, e.bars);
    for (const Bar& bar : need.bars) e.at.push_back(places(particles[bar.first]));
    for (std::uint32_t p = 0; p < e.plates; ++p) e.at.push_back(e.at[plates[p][0]]);
    for (const Region& region : regions_) e.at.push_back(places(region.particle));

    add_parents(regions, plates, e);
    add_bars_of_particles(bars, places.at.size(), e);
    return e;
}

}  // namespace physics
