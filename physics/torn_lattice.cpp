#include "physics/torn_lattice.hpp"

#include "geometry/parallel.hpp"

#include <algorithm>

namespace physics {

namespace {

void sort_once(std::vector<std::uint32_t>& numbers)
{
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

}  // namespace

TornLattice::Order TornLattice::in_order(const Vec3i& p)
{
    return {p[2], p[1], p[0]};
}

TornLattice::TornLattice(const Lattice& lattice, const LatticeRegions& whole)
    : lattice_(lattice), half_width_(whole.half_width), flat_(whole.flat),
      particle_(whole.particle), places_{lattice.at, whole.axes},
      runs_(turned(lattice, whole.axes)), sums_(whole.half_width), lost_(lattice.count(), 0)
{
    for (std::uint32_t slot = 0; slot < whole.slots(); ++slot) {
        if (whole.particle[slot] != none) by_place_.push_back(slot);
    }
    std::ranges::sort(by_place_, {}, [&](std::uint32_t slot) { return place_in_order(slot); });
    take(whole.exceptions.region);
    set(whole.exceptions.region);
}

// Those of the slots that are not in sums_ yet go there, and their particles count as lost until
// they are set.
void TornLattice::take(std::span<const std::uint32_t> slots)
{
    std::vector<std::uint32_t> fresh;
    std::vector<SharedSums::Region> regions;
    for (const auto slot : slots) {
        if (sums_.has(slot)) {
            for_each_particle(slot, [&](std::uint32_t i) { ++lost_[i]; });
        } else {
            fresh.push_back(slot);
            regions.push_back({slot, particle_[slot]});
        }
    }
    sums_.add(regions);
    for (const Pieces& pieces : pieces_of(fresh)) {
        for (const auto& piece : pieces) {
            for (const auto i : in_runs(piece)) ++lost_[i];
        }
    }
}

// To what is reached now.
void TornLattice::set(std::span<const std::uint32_t> slots)
{
    const auto pieces = pieces_of(slots);
    for (std::size_t k = 0; k < slots.size(); ++k) {
        sums_.set(slots[k], pieces[k]);
        for (const auto& piece : pieces[k]) {
            for (const auto i : in_runs(piece)) --lost_[i];
        }
    }
}

void TornLattice::break_links(std::span<const std::uint32_t> links)
{
    find_changed(links);
    take(changed_);
    const auto axis_of = [&](std::uint32_t d) {
        return int(std::find(places_.axes.begin(), places_.axes.end(), int(d)) -
                   places_.axes.begin());
    };
    for (const auto link : links) {
        const std::uint32_t i = link / 3, d = link % 3;
        runs_.cut(i, lattice_.next[i][d], axis_of(d), places_(i)[0]);
    }
    set(changed_);
}

// Whoever held an end may have reached through it; links go both ways, so those are among the
// particles in its box.
void TornLattice::find_changed(std::span<const std::uint32_t> links)
{
    const int w = half_width_, across = flat_ ? 0 : w;
    std::vector<std::uint32_t> ends;
    for (const auto link : links) {
        ends.push_back(link / 3);
        ends.push_back(lattice_.next[link / 3][link % 3]);
    }
    sort_once(ends);
    // Rows of the boxes, as ranges of by_place_.
    std::vector<std::pair<std::ptrdiff_t, std::ptrdiff_t>> rows;
    for (const auto end : ends) {
        const Vec3i at = places_(end);
        for (int z = -across; z <= across; ++z) {
            for (int y = -w; y <= w; ++y) {
                const auto low = in_order(at + Vec3i(-w, y, z)),
                           high = in_order(at + Vec3i(w, y, z));
                const auto first = std::ranges::lower_bound(
                    by_place_, low, {}, [&](std::uint32_t slot) { return place_in_order(slot); });
                auto last = first;
                while (last != by_place_.end() && place_in_order(*last) <= high) ++last;
                rows.emplace_back(first - by_place_.begin(), last - by_place_.begin());
            }
        }
    }
    std::sort(rows.begin(), rows.end());
    changed_.clear();
    std::ptrdiff_t next = 0;
    for (const auto& [first, last] : rows) {
        for (next = std::max(next, first); next < last; ++next) {
            changed_.push_back(by_place_[std::size_t(next)]);
        }
    }
    std::sort(changed_.begin(), changed_.end());
}

// Those that are reached from the particles of these slots, by z and place.
std::vector<TornLattice::Pieces> TornLattice::pieces_of(std::span<const std::uint32_t> slots) const
{
    std::vector<Pieces> out(slots.size());
    geometry::parallel_for(slots.size(), 64, [&](std::size_t begin, std::size_t end) {
        Reach reach(runs_, half_width_);
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t r = particle_[slots[k]];
            const auto pieces = reach.from(r, places_(r));
            out[k].assign(pieces.begin(), pieces.end());
            std::sort(out[k].begin(), out[k].end());
        }
    });
    return out;
}

}  // namespace physics
