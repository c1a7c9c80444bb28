#include "physics/regions/torn_sums.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>

namespace physics {

namespace {

// Places low .. high along x.
struct Row {
    int z, y, low, high;

    auto operator<=>(const Row&) const = default;
};

// Sorted, none beside or over another.
void merge(std::vector<Row>& rows)
{
    std::sort(rows.begin(), rows.end());
    std::size_t count = 0;
    for (const Row& row : rows) {
        Row* const last = count > 0 ? &rows[count - 1] : nullptr;
        if (last && last->z == row.z && last->y == row.y && row.low <= last->high + 1) {
            last->high = std::max(last->high, row.high);
        } else {
            rows[count++] = row;
        }
    }
    rows.resize(count);
}

// Those up to w away along one axis too.
void spread_rows(std::vector<Row>& rows, int Row::*along, int w)
{
    std::vector<Row> out;
    for (Row row : rows) {
        const int at = row.*along;
        for (row.*along = at - w; row.*along <= at + w; ++(row.*along)) out.push_back(row);
    }
    merge(out);
    rows = std::move(out);
}

}  // namespace

TornSums::TornSums(const Lattice& lattice, const LatticeRegions& whole)
    : lattice_(lattice), half_width_(whole.half_width), flat_(whole.flat),
      particle_(whole.particle), places_{lattice.at, whole.axes},
      runs_(turned(lattice, whole.axes)),
      sums_(whole.flat ? 1 : 2 * std::size_t(whole.half_width) + 1), lost_(lattice.count() + 1, 0)
{
    for (std::uint32_t slot = 0; slot < whole.slots(); ++slot) {
        if (whole.particle[slot] != none) by_place_.push_back(slot);
    }
    std::ranges::sort(by_place_, {}, [&](std::uint32_t slot) { return place_in_order(slot); });
    take(whole.partial.region);
    set(whole.partial.region);
}

void TornSums::break_links(std::span<const std::uint32_t> links)
{
    // Whoever held an end may have reached through it; links go both ways, so those are among the
    // particles in its box.
    std::vector<std::uint32_t> ends;
    for (const auto link : links) {
        ends.push_back(link / 3);
        ends.push_back(lattice_.next[link / 3][link % 3]);
    }
    changed_ = slots_around(ends);
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

std::vector<std::uint32_t> TornSums::slots_around(std::span<const std::uint32_t> particles) const
{
    std::vector<Row> rows;
    for (const auto particle : particles) {
        const Vec3i at = places_(particle);
        rows.push_back({at[2], at[1], at[0] - half_width_, at[0] + half_width_});
    }
    merge(rows);
    spread_rows(rows, &Row::y, half_width_);
    if (!flat_) spread_rows(rows, &Row::z, half_width_);
    std::vector<std::uint32_t> out;
    const auto from = [&](const Order& place) {
        return std::ranges::lower_bound(by_place_, place, {},
                                        [&](std::uint32_t slot) { return place_in_order(slot); });
    };
    for (const Row& row : rows) {
        out.insert(out.end(), from({row.z, row.y, row.low}), from({row.z, row.y, row.high + 1}));
    }
    std::sort(out.begin(), out.end());
    return out;
}

// Those of the slots that are not in sums_ yet go there, and their particles count as lost until
// they are set.
void TornSums::take(std::span<const std::uint32_t> slots)
{
    std::vector<std::uint32_t> fresh;
    std::vector<SharedSums::Region> regions;
    for (const auto slot : slots) {
        if (sums_.has(slot)) {
            sums_.for_each_piece(slot, [&](std::uint32_t first, std::uint32_t length) {
                count_lost(first, length, 1);
            });
        } else {
            fresh.push_back(slot);
            regions.push_back({slot, particle_[slot]});
        }
    }
    sums_.add(regions);
    for_pieces(fresh, [&](std::uint32_t, const Pieces& pieces) {
        for (const auto& piece : pieces) count_lost(piece.first, piece.length, 1);
    });
}

// To what is reached now.
void TornSums::set(std::span<const std::uint32_t> slots)
{
    for_pieces(slots, [&](std::uint32_t slot, const Pieces& pieces) {
        sums_.set(slot, pieces);
        for (const auto& piece : pieces) count_lost(piece.first, piece.length, ~0u);  // one less
    });
}

void TornSums::count_lost(std::uint32_t first, std::uint32_t length, std::uint32_t regions)
{
    lost_[first] += regions;
    lost_[first + length] -= regions;
}

std::vector<std::uint32_t> TornSums::lost() const
{
    std::vector<std::uint32_t> out(lattice_.count());
    std::uint32_t count = 0;
    for (std::size_t k = 0; k < out.size(); ++k) {
        count += lost_[k];
        out[runs_.particles()[k]] = count;
    }
    return out;
}

// Calls visit(slot, pieces), in turn, with those that are reached from the particles of these
// slots, by z and place.
template <class Visit>
void TornSums::for_pieces(std::span<const std::uint32_t> slots, const Visit& visit) const
{
    constexpr std::size_t at_a_time = 4096;
    std::vector<Pieces> pieces(std::min(slots.size(), at_a_time));
    for (; !slots.empty(); slots = slots.subspan(std::min(slots.size(), at_a_time))) {
        const auto some = slots.first(std::min(slots.size(), at_a_time));
        geometry::parallel_for(some.size(), 64, [&](std::size_t begin, std::size_t end) {
            Reach reach(runs_, half_width_);
            for (std::size_t k = begin; k < end; ++k) {
                const std::uint32_t r = particle_[some[k]];
                const auto found = reach.from(r, places_(r));
                pieces[k].assign(found.begin(), found.end());
                std::sort(pieces[k].begin(), pieces[k].end());
            }
        });
        for (std::size_t k = 0; k < some.size(); ++k) visit(some[k], pieces[k]);
    }
}

}  // namespace physics
