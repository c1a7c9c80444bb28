#include "physics/regions/region_sums.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/regions/line_sums.hpp"
#include "physics/regions/partial_sums.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

// Items a task handles: some 100 us.
constexpr std::size_t entries_a_task = 512;

// Slots that are visited together: they stay in the nearest cache.
constexpr std::size_t slots_a_visit = 256;

// Calls sum(lines, room) on pieces of these lines, in which none is parted from the one it is
// summed with.
template <class T, class Sum> void for_some_lines(const SomeLines& lines, const Sum& sum)
{
    geometry::parallel_for((lines.end - lines.begin + most_abreast - 1) / most_abreast,
                           entries_a_task / 8 / most_abreast,
                           [&](std::size_t begin, std::size_t end) {
                               Aligned<T> room;
                               SomeLines some = lines;
                               some.begin += most_abreast * begin;
                               some.end = std::min(lines.end, lines.begin + most_abreast * end);
                               sum(some, room);
                           });
}

// From items to windows.
template <class T>
void collect_lines(Along axis, const SomeLines& all, int w, const Quad<T>* items, Quad<T>* windows)
{
    for_some_lines<T>(all, [&](const SomeLines& lines, Aligned<T>& room) {
        collect_some(axis, lines, w, items->data(), windows->data(), room);
    });
}

// The transpose: windows are spread over items.
template <class T>
void spread_lines(Along axis, const SomeLines& all, int w, Quad<T>* windows, Quad<T>* items)
{
    for_some_lines<T>(all, [&](const SomeLines& lines, Aligned<T>& room) {
        spread_some(axis, lines, w, windows->data(), items->data(), room);
    });
}

// Calls sum(x, y) with the lines of each slab.
template <class Sum> void for_slabs(const LatticeRegions& regions, const Sum& sum)
{
    geometry::parallel_for(regions.slabs.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            const LatticeSlab before = s > 0 ? regions.slabs[s - 1] : LatticeSlab{};
            const LatticeSlab& slab = regions.slabs[s];
            sum(SomeLines{regions.x, before.x_lines, slab.x_lines},
                SomeLines{regions.y, before.y_lines, slab.y_lines});
        }
    });
}

enum class Way { collect, spread, both };

// The slots of a few lines, four quads each from `first` on: summed, visited and spread while they
// are at hand.
template <class T>
void sum_slots(const LatticeRegions& regions, RegionSums<T>& sums, Way way,
               const SlotVisit<T>& visit, const SomeLines& lines, std::span<Quad<T>> slots,
               Aligned<T>& room)
{
    const Along along = regions.flat ? Along::y_of_plane : Along::z;
    const int w = regions.half_width;
    const std::size_t first = lines.window, next = first + slots.size() / 4;
    // What slots are sums of, and are spread over again in the same place.
    T* const near = (regions.flat ? sums.bars : sums.plates).data()->data();
    const auto slot = [&](std::size_t s) { return slots.data() + 4 * (s - first); };
    const auto clear = [&] {
        const auto& dead = lines.along.dead;
        for (auto d = std::lower_bound(dead.begin(), dead.end(), first);
             d != dead.end() && *d < next; ++d) {
            std::fill_n(slot(*d), 4, Quad<T>::Zero());
        }
    };
    Quad<T>* const nodes = sums.partial.data();
    if (way != Way::spread) {
        collect_some<T>(along, lines, w, near, slots.data()->data(), room);
        clear();
        for_partial_slots(
            regions.partial, nodes, first, next,
            [&](std::size_t s, const Quad<T>* node) { std::copy_n(node, 4, slot(s)); });
    } else {
        std::fill(slots.begin(), slots.end(), Quad<T>::Zero());
    }
    visit(first, slots);
    if (way != Way::collect) {
        for_partial_slots(regions.partial, nodes, first, next, [&](std::size_t s, Quad<T>* node) {
            std::copy_n(slot(s), 4, node);
            std::fill_n(slot(s), 4, Quad<T>::Zero());
        });
        clear();
        spread_some<T>(along, lines, w, slots.data()->data(), near, room);
    }
}

template <class T> void collect_from_particles(const LatticeRegions& regions, RegionSums<T>& sums)
{
    collect_partial(regions.partial, regions.flat, sums.particles.data(), sums.partial.data());
    const int w = regions.half_width;
    for_slabs(regions, [&](const SomeLines& x, const SomeLines& y) {
        collect_lines(Along::x, x, w, sums.particles.data(), sums.bars.data());
        if (!regions.flat) collect_lines(Along::y, y, w, sums.bars.data(), sums.plates.data());
    });
}

template <class T> void spread_to_particles(const LatticeRegions& regions, RegionSums<T>& sums)
{
    Quad<T>* const bars = sums.bars.data();
    Quad<T>* const plates = sums.plates.data();
    if (!regions.flat) {
        for (const std::uint32_t d : regions.y.dead) {
            std::fill_n(plates + 3 * d, 3, Quad<T>::Zero());
        }
    }
    for (const std::uint32_t d : regions.x.dead) std::fill_n(bars + 2 * d, 2, Quad<T>::Zero());
    const int w = regions.half_width;
    for_slabs(regions, [&](const SomeLines& x, const SomeLines& y) {
        if (!regions.flat) spread_lines(Along::y, y, w, plates, bars);
        spread_lines(Along::x, x, w, bars, sums.particles.data());
    });
    spread_partial(regions.partial, regions.flat, sums.partial.data(), sums.particles.data());
}

// From particles to slots, back, or there and back, a few lines of slots at a time.
template <class T>
void sum_over(const LatticeRegions& regions, RegionSums<T>& sums, Way way,
              const SlotVisit<T>& visit)
{
    if (way != Way::spread) collect_from_particles(regions, sums);
    const LatticeLines& last = regions.flat ? regions.y : regions.z;
    for_some_lines<T>({last, 0, last.lines.size()}, [&](SomeLines lines, Aligned<T>& room) {
        Aligned<Quad<T>> slots;
        for (const std::size_t end = lines.end; lines.begin < end; lines.begin = lines.end) {
            const std::size_t first = lines.window = last.lines[lines.begin].window;
            std::size_t next = first;
            for (lines.end = lines.begin; lines.end < end && next < first + slots_a_visit;) {
                lines.end = std::min(end, lines.end + most_abreast);
                next = last.lines[lines.end - 1].window + last.lines[lines.end - 1].windows;
            }
            slots.resize(std::max(slots.size(), 4 * (next - first)));
            sum_slots(regions, sums, way, visit, lines, {slots.data(), 4 * (next - first)}, room);
        }
    });
    if (way != Way::collect) spread_to_particles(regions, sums);
}

}  // namespace

template <class T> RegionSums<T>::RegionSums(const LatticeRegions& regions)
{
    // Touched first by all threads: at a million particles finding room takes as long as a step.
    const auto make_room = [](auto& in, std::size_t n) {
        in.resize(n);  // leaves quads as they are
        geometry::parallel_for(n, 16 * entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) in[i].setZero();
        });
    };
    make_room(particles, regions.particles);
    make_room(bars, 2 * regions.x.windows);
    make_room(plates, regions.flat ? 0 : 3 * regions.y.windows);
    make_room(partial, 4 * regions.partial.nodes());
}

template <class T>
void collect(const LatticeRegions& regions, RegionSums<T>& sums, const SlotVisit<T>& visit)
{
    sum_over(regions, sums, Way::collect, visit);
}

template <class T>
void spread(const LatticeRegions& regions, RegionSums<T>& sums, const SlotVisit<T>& visit)
{
    sum_over(regions, sums, Way::spread, visit);
}

template <class T>
void collect_and_spread(const LatticeRegions& regions, RegionSums<T>& sums,
                        const SlotVisit<T>& visit)
{
    sum_over(regions, sums, Way::both, visit);
}

template struct RegionSums<float>;
template struct RegionSums<double>;
template void collect(const LatticeRegions&, RegionSums<float>&, const SlotVisit<float>&);
template void collect(const LatticeRegions&, RegionSums<double>&, const SlotVisit<double>&);
template void spread(const LatticeRegions&, RegionSums<float>&, const SlotVisit<float>&);
template void spread(const LatticeRegions&, RegionSums<double>&, const SlotVisit<double>&);
template void collect_and_spread(const LatticeRegions&, RegionSums<float>&,
                                 const SlotVisit<float>&);
template void collect_and_spread(const LatticeRegions&, RegionSums<double>&,
                                 const SlotVisit<double>&);

std::vector<std::uint32_t> count_holders(const LatticeRegions& regions)
{
    RegionSums<double> sums(regions);
    spread<double>(regions, sums, [](std::size_t, std::span<Quad<double>> slots) {
        for (std::size_t k = 0; k < slots.size(); k += 4) slots[k] = {1, 0, 0, 0};
    });
    std::vector<std::uint32_t> held_by;
    for (const auto& count : sums.particles) {
        held_by.push_back(std::uint32_t(std::lround(count[0])));
    }
    return held_by;
}

}  // namespace physics
