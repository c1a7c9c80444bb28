#include "physics/lattice_regions.hpp"

#include "geometry/parallel.hpp"
#include "physics/aligned.hpp"

#ifndef PHYSICS_LATTICE_SUMS_CPP  // once for all targets
#define PHYSICS_LATTICE_SUMS_CPP
namespace physics {

// Lines along an axis: items of one, two and three quads, and their windows with one more, of a
// plane along y with two.
enum class Along { x, y, y_of_plane, z };
inline constexpr std::size_t quads_of_window[] = {2, 3, 4, 4};

}  // namespace physics
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/lattice_sums.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace sums_kernel {

namespace hn = hwy::HWY_NAMESPACE;

// n numbers, a multiple of four, that are added as one: eight at a time, then four.
template <class T, std::size_t n> struct Row {
    static constexpr std::size_t most = n >= 8 ? 8 : 4;
    using D = hn::CappedTag<T, most>;
    static constexpr std::size_t lanes = hn::MaxLanes(D()), parts = most / lanes;

    hn::Vec<D> part[parts];
    Row<T, n - most> rest;

    HWY_INLINE void clear()
    {
        for (auto& p : part) p = hn::Zero(D());
        rest.clear();
    }
    HWY_INLINE void load(const T* from)
    {
        for (std::size_t i = 0; i < parts; ++i) part[i] = hn::LoadU(D(), from + i * lanes);
        rest.load(from + most);
    }
    HWY_INLINE void store(T* to) const
    {
        for (std::size_t i = 0; i < parts; ++i) hn::StoreU(part[i], D(), to + i * lanes);
        rest.store(to + most);
    }
    HWY_INLINE void add(const Row& o)
    {
        for (std::size_t i = 0; i < parts; ++i) part[i] = hn::Add(part[i], o.part[i]);
        rest.add(o.rest);
    }
    HWY_INLINE void add(const T* from)
    {
        Row row;
        row.load(from);
        add(row);
    }
    HWY_INLINE void subtract(const Row& o)
    {
        for (std::size_t i = 0; i < parts; ++i) part[i] = hn::Sub(part[i], o.part[i]);
        rest.subtract(o.rest);
    }
    HWY_INLINE void add_times(T factor, const Row& o)
    {
        const auto times = hn::Set(D(), factor);
        for (std::size_t i = 0; i < parts; ++i) {
            part[i] = hn::Add(part[i], hn::Mul(times, o.part[i]));
        }
        rest.add_times(factor, o.rest);
    }
};
template <class T> struct Row<T, 0> {
    HWY_INLINE void clear() {}
    HWY_INLINE void load(const T*) {}
    HWY_INLINE void store(T*) const {}
    HWY_INLINE void add(const Row&) {}
    HWY_INLINE void add(const T*) {}
    HWY_INLINE void subtract(const Row&) {}
    HWY_INLINE void add_times(T, const Row&) {}
};

// Sums of what lies in a window. Some quads of each item, the first ones in order to collect and
// the last in order to spread, get their moments about the window's place too.
template <class T, std::size_t main_numbers, std::size_t others, bool collects> struct Sums {
    static constexpr std::size_t item = main_numbers + others;  // numbers
    static constexpr std::size_t main_at = collects ? 0 : others;
    static constexpr std::size_t others_at = collects ? main_numbers : 0;
    using Main = Row<T, main_numbers>;

    Main main, moment;
    Row<T, others> rest;

    HWY_INLINE void clear()
    {
        main.clear();
        moment.clear();
        rest.clear();
    }
    HWY_INLINE void add_item(const T* from)
    {
        main.add(from + main_at);
        rest.add(from + others_at);
    }
    // Suffixes, as slide() keeps them.
    static constexpr std::size_t entry = others + 2 * main_numbers;
    HWY_INLINE void keep(T* to) const
    {
        main.store(to);
        moment.store(to + main_numbers);
        rest.store(to + 2 * main_numbers);
    }
    HWY_INLINE void restore(const T* from)
    {
        main.load(from);
        moment.load(from + main_numbers);
        rest.load(from + 2 * main_numbers);
    }
    // Collected: the sums and the moments. Spread: the other sums, the moments taken from the
    // first.
    static constexpr std::size_t answer = collects ? item + main_numbers : others;
    HWY_INLINE void store(T* to) const
    {
        if constexpr (collects) {
            main.store(to);
            rest.store(to + main_numbers);
            moment.store(to + item);
        } else {
            rest.store(to);
            Main front;
            front.load(to);
            front.subtract(moment);
            front.store(to);
        }
    }
};

// A line's items lie at `from`, one after another, at the places lead .. lead + items - 1 as seen
// from the windows, which are at 0 .. windows - 1 and go to `to`, one after another or where
// `place` says.
template <class T> struct Slide {
    int w, windows, lead, items;
    const T* from;
    T* to;
    const std::uint32_t* place;

    template <class S> HWY_INLINE void answer(int at, const S& sums) const
    {
        if (place == nullptr) {
            sums.store(to + std::size_t(at) * S::answer);
        } else if (place[at] != none) {
            sums.store(to + std::size_t(place[at]) * S::answer);
        }
    }
};

// `suffix` has room for 2w + 1 entries.
template <class S, class T> HWY_INLINE void slide_blocks(const Slide<T>& line, T* suffix)
{
    const int w = line.w, length = 2 * w + 1;
    for (int first = 0; first < line.windows; first += length) {
        const int base = first - w;  // the block's first position
        const int stored = std::min(length, line.windows - first);
        const int low = std::max(0, line.lead - base);
        const int high = std::min(length, line.lead + line.items - base);
        const T* const block = line.from + (base - line.lead) * std::ptrdiff_t(S::item);

        // Suffix sums: from position base + j to the block's end, moments about base + j.
        S sums;
        sums.clear();
        for (int j = stored - 1; j >= std::max(high, 0); --j) sums.keep(suffix + j * int(S::entry));
        int j = high - 1;
        for (; j >= std::max(low, stored); --j) {
            sums.moment.add(sums.main);
            sums.add_item(block + j * std::ptrdiff_t(S::item));
        }
        for (; j >= low; --j) {
            sums.moment.add(sums.main);
            sums.add_item(block + j * std::ptrdiff_t(S::item));
            sums.keep(suffix + j * int(S::entry));
        }
        for (j = std::min(low, length) - 1; j >= 0; --j) {
            sums.moment.add(sums.main);
            if (j < stored) sums.keep(suffix + j * int(S::entry));
        }

        // And prefix sums of the next block up to position first + t + w, moments about that.
        sums.clear();
        for (int t = 0; t < stored; ++t) {
            const int position = base + length + t - 1;
            if (t > 0) {
                sums.moment.subtract(sums.main);
                if (position >= line.lead && position < line.lead + line.items) {
                    sums.add_item(block + (length + t - 1) * std::ptrdiff_t(S::item));
                }
            }
            S total;
            total.restore(suffix + t * int(S::entry));
            typename S::Main between = sums.main;
            between.subtract(total.main);
            total.moment.add(sums.moment);
            total.moment.add_times(T(w), between);
            total.main.add(sums.main);
            total.rest.add(sums.rest);
            line.answer(first + t, total);
        }
    }
}

// The same for narrow windows, item by item: with few items a block its bookkeeping costs more than
// the additions it saves.
template <int w, class S, class T> HWY_INLINE void slide_item_by_item(const Slide<T>& line)
{
    constexpr int length = 2 * w + 1;
    const T nothing[S::item] = {};
    const T* near[length];
    const auto item = [&](int position) HWY_ATTR -> const T* {
        const bool there = position >= line.lead && position < line.lead + line.items;
        return there ? line.from + (position - line.lead) * std::ptrdiff_t(S::item) : nothing;
    };
    for (int d = 1; d < length; ++d) near[d] = item(d - 1 - w);
    for (int at = 0; at < line.windows; ++at) {
        for (int d = 1; d < length; ++d) near[d - 1] = near[d];
        near[length - 1] = item(at + w);
        S sums;
        sums.clear();
        for (int d = 0; d < length; ++d) sums.add_item(near[d]);
        for (int d = 1; d <= w; ++d) {
            typename S::Main after, before;
            after.load(near[w + d] + S::main_at);
            before.load(near[w - d] + S::main_at);
            after.subtract(before);
            sums.moment.add_times(T(d), after);
        }
        line.answer(at, sums);
    }
}

template <class S, class T> HWY_INLINE void sum_windows(const Slide<T>& line, T* suffix)
{
    if (line.w == 1) {
        slide_item_by_item<1, S>(line);
    } else if (line.w == 2) {
        slide_item_by_item<2, S>(line);
    } else {
        slide_blocks<S>(line, suffix);
    }
}

// Lines begin .. end of `along`, from items of `channels` quads to windows of those and the moments
// of the first `moments`.
template <std::size_t channels, std::size_t moments, class T>
HWY_INLINE void collect_some(const LatticeLines& along, std::size_t begin, std::size_t end, int w,
                             const T* items, T* windows, Aligned<T>& room)
{
    using S = Sums<T, 4 * moments, 4 * (channels - moments), true>;
    const std::size_t suffixes = std::size_t(2 * w + 1) * S::entry;
    for (std::size_t l = begin; l < end; ++l) {
        const auto& line = along.lines[l];
        const std::uint32_t* const index = along.items.data() + line.item;
        room.resize(std::max(room.size(), suffixes + line.items * S::item));
        T* const gathered = room.data() + suffixes;
        for (std::size_t k = 0; k < line.items; ++k) {
            Row<T, S::item> row;
            if (index[k] == none) {
                row.clear();
            } else {
                row.load(items + index[k] * S::item);
            }
            row.store(gathered + k * S::item);
        }
        const Slide<T> slide{w,         int(line.windows),
                             line.lead, int(line.items),
                             gathered,  windows + std::size_t(line.window) * S::answer,
                             nullptr};
        sum_windows<S>(slide, room.data());
    }
}

// The transpose: windows of channels + moments quads are spread over items of `channels`. Seen from
// the items, place 0 is the first item.
template <std::size_t channels, std::size_t moments, class T>
HWY_INLINE void spread_some(const LatticeLines& along, std::size_t begin, std::size_t end, int w,
                            const T* windows, T* items, Aligned<T>& room)
{
    using S = Sums<T, 4 * moments, 4 * channels, false>;
    room.resize(std::max(room.size(), std::size_t(2 * w + 1) * S::entry));
    for (std::size_t l = begin; l < end; ++l) {
        const auto& line = along.lines[l];
        const Slide<T> slide{w,
                             int(line.items),
                             -line.lead,
                             int(line.windows),
                             windows + std::size_t(line.window) * S::item,
                             items,
                             along.items.data() + line.item};
        sum_windows<S>(slide, room.data());
    }
}

template <class T>
HWY_INLINE void collect_any(Along axis, const LatticeLines& along, std::size_t begin,
                            std::size_t end, int w, const T* items, T* windows, Aligned<T>& room)
{
    if (axis == Along::x) collect_some<1, 1>(along, begin, end, w, items, windows, room);
    if (axis == Along::y) collect_some<2, 1>(along, begin, end, w, items, windows, room);
    if (axis == Along::y_of_plane) collect_some<2, 2>(along, begin, end, w, items, windows, room);
    if (axis == Along::z) collect_some<3, 1>(along, begin, end, w, items, windows, room);
}

template <class T>
HWY_INLINE void spread_any(Along axis, const LatticeLines& along, std::size_t begin,
                           std::size_t end, int w, const T* windows, T* items, Aligned<T>& room)
{
    if (axis == Along::x) spread_some<1, 1>(along, begin, end, w, windows, items, room);
    if (axis == Along::y) spread_some<2, 1>(along, begin, end, w, windows, items, room);
    if (axis == Along::y_of_plane) spread_some<2, 2>(along, begin, end, w, windows, items, room);
    if (axis == Along::z) spread_some<3, 1>(along, begin, end, w, windows, items, room);
}

}  // namespace sums_kernel

// Dispatch tables take plain functions.
void collect_float(Along axis, const LatticeLines& along, std::size_t begin, std::size_t end, int w,
                   const float* items, float* windows, Aligned<float>& room)
{
    sums_kernel::collect_any(axis, along, begin, end, w, items, windows, room);
}
void collect_double(Along axis, const LatticeLines& along, std::size_t begin, std::size_t end,
                    int w, const double* items, double* windows, Aligned<double>& room)
{
    sums_kernel::collect_any(axis, along, begin, end, w, items, windows, room);
}
void spread_float(Along axis, const LatticeLines& along, std::size_t begin, std::size_t end, int w,
                  const float* windows, float* items, Aligned<float>& room)
{
    sums_kernel::spread_any(axis, along, begin, end, w, windows, items, room);
}
void spread_double(Along axis, const LatticeLines& along, std::size_t begin, std::size_t end, int w,
                   const double* windows, double* items, Aligned<double>& room)
{
    sums_kernel::spread_any(axis, along, begin, end, w, windows, items, room);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(collect_float);
HWY_EXPORT(collect_double);
HWY_EXPORT(spread_float);
HWY_EXPORT(spread_double);

namespace {

// Items a task handles: some 100 us.
constexpr std::size_t entries_a_task = 512;

// From items to windows.
template <class T>
void collect_lines(Along axis, const LatticeLines& along, int w, const Quad<T>* items,
                   Quad<T>* windows)
{
    geometry::parallel_for(
        along.lines.size(), entries_a_task / 8, [&](std::size_t begin, std::size_t end) {
            Aligned<T> room;
            const T* const from = items->data();
            T* const to = windows->data();
            if constexpr (std::is_same_v<T, float>) {
                HWY_DYNAMIC_DISPATCH(collect_float)(axis, along, begin, end, w, from, to, room);
            } else {
                HWY_DYNAMIC_DISPATCH(collect_double)
                (axis, along, begin, end, w, from, to, room);
            }
        });
}

// The transpose: windows are spread over items.
template <class T>
void spread_lines(Along axis, const LatticeLines& along, int w, Quad<T>* windows, Quad<T>* items)
{
    const std::size_t quads = quads_of_window[std::size_t(axis)];
    for (const std::uint32_t d : along.dead) {
        for (std::size_t c = 0; c < quads; ++c) windows[d * quads + c].setZero();
    }
    geometry::parallel_for(
        along.lines.size(), entries_a_task / 8, [&](std::size_t begin, std::size_t end) {
            Aligned<T> room;
            const T* const from = windows->data();
            T* const to = items->data();
            if constexpr (std::is_same_v<T, float>) {
                HWY_DYNAMIC_DISPATCH(spread_float)(axis, along, begin, end, w, from, to, room);
            } else {
                HWY_DYNAMIC_DISPATCH(spread_double)(axis, along, begin, end, w, from, to, room);
            }
        });
}

// S and its moments about a place `by` back, added to `to`. A plane's third moment is along both
// axes.
template <class T> void add_shifted(bool flat, const Vec3i& by, const Quad<T>* from, Quad<T>* to)
{
    to[0] += from[0];
    for (int d = 0; d < 3; ++d) to[1 + d] += from[1 + d] + T(by[d]) * from[0];
    if (flat) to[3] += T(by[0]) * from[2] + T(by[1]) * from[1] + T(by[0] * by[1]) * from[0];
}

// What spreads, an affine map with the product of both axes on a plane, as seen from a place `by`
// on.
template <class T> void add_moved(bool flat, const Vec3i& by, const Quad<T>* from, Quad<T>* to)
{
    to[0] += from[0] + T(by[0]) * from[1] + T(by[1]) * from[2];
    for (std::size_t c = 1; c < 4; ++c) to[c] += from[c];
    if (flat) {
        to[0] += T(by[0] * by[1]) * from[3];
        to[1] += T(by[1]) * from[3];
        to[2] += T(by[0]) * from[3];
    } else {
        to[0] += T(by[2]) * from[3];
    }
}

}  // namespace

template <class T> RegionSums<T>::RegionSums(const LatticeRegions& regions)
{
    const std::size_t slots = regions.slots(), bars = regions.x.windows, plates = regions.y.windows;
    // Touched first by all threads: at a million particles finding room takes as long as a step.
    const auto make_room = [](std::vector<Quad<T>>& in, std::size_t n) {
        in.resize(n);  // leaves quads as they are
        geometry::parallel_for(n, 16 * entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) in[i].setZero();
        });
    };
    make_room(a, std::max(regions.flat ? 0 : 4 * slots, 2 * bars));
    make_room(b, std::max((regions.flat ? 4 : 3) * plates, regions.particles));
    make_room(exceptional, 4 * regions.exceptions.nodes());
}

template <class T> std::span<Quad<T>> RegionSums<T>::particles(const LatticeRegions& regions)
{
    return {b.data(), regions.particles};
}

template <class T> std::span<Quad<T>> RegionSums<T>::slots(const LatticeRegions& regions)
{
    return {regions.flat ? b.data() : a.data(), regions.quads() * regions.slots()};
}

template <class T> void collect(const LatticeRegions& regions, RegionSums<T>& sums)
{
    const LatticeExceptions& e = regions.exceptions;
    const int w = regions.half_width;
    const std::size_t first_plate = e.bars, first_region = e.bars + e.plates;
    const auto nodes = sums.exceptional.data();
    // A node's value about its own place: S and three moments.
    geometry::parallel_for(e.bars, entries_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            Quad<T> total[4] = {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero()};
            for (std::uint32_t k = e.child_at[n]; k < e.child_at[n + 1]; ++k) {
                const Quad<T>& f = sums.b[e.child[k]];
                total[0] += f;
                total[1] += T(k - e.child_at[n]) * f;  // a bar is unbroken, and about its first
            }
            for (std::size_t c = 0; c < 4; ++c) nodes[4 * n + c] = total[c];
        }
    });
    for (const auto& [low, high] :
         {std::pair(first_plate, first_region), std::pair(first_region, e.nodes())}) {
        geometry::parallel_for(
            high - low, entries_a_task, [&, low = low](std::size_t begin, std::size_t end) {
                for (std::size_t n = low + begin; n < low + end; ++n) {
                    Quad<T> total[4] = {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(),
                                        Quad<T>::Zero()};
                    for (std::uint32_t k = e.child_at[n]; k < e.child_at[n + 1]; ++k) {
                        const std::size_t child = e.child[k];
                        add_shifted<T>(regions.flat, e.at[child] - e.at[n], nodes + 4 * child,
                                       total);
                    }
                    for (std::size_t c = 0; c < 4; ++c) nodes[4 * n + c] = total[c];
                }
            });
    }

    collect_lines(Along::x, regions.x, w, sums.b.data(), sums.a.data());
    collect_lines(regions.flat ? Along::y_of_plane : Along::y, regions.y, w, sums.a.data(),
                  sums.b.data());
    if (!regions.flat) collect_lines(Along::z, regions.z, w, sums.b.data(), sums.a.data());
    const auto slots = sums.slots(regions);
    const std::size_t quads = regions.quads();
    for (const std::uint32_t d : regions.flat ? regions.y.dead : regions.z.dead) {
        for (std::size_t c = 0; c < quads; ++c) slots[quads * d + c].setZero();
    }
    for (std::size_t i = 0; i < e.region.size(); ++i) {
        for (std::size_t c = 0; c < quads; ++c) {
            slots[quads * e.region[i] + c] = nodes[4 * (first_region + i) + c];
        }
    }
}

template <class T> void spread(const LatticeRegions& regions, RegionSums<T>& sums)
{
    const LatticeExceptions& e = regions.exceptions;
    const int w = regions.half_width;
    const std::size_t first_plate = e.bars, first_region = e.bars + e.plates;
    const auto nodes = sums.exceptional.data();
    const auto slots = sums.slots(regions);
    const std::size_t quads = regions.quads();
    for (std::size_t i = 0; i < e.region.size(); ++i) {
        for (std::size_t c = 0; c < quads; ++c) {
            Quad<T>& slot = slots[quads * e.region[i] + c];
            nodes[4 * (first_region + i) + c] = slot;
            slot.setZero();
        }
    }
    if (!regions.flat) spread_lines(Along::z, regions.z, w, sums.a.data(), sums.b.data());
    spread_lines(regions.flat ? Along::y_of_plane : Along::y, regions.y, w, sums.b.data(),
                 sums.a.data());
    spread_lines(Along::x, regions.x, w, sums.a.data(), sums.b.data());

    // From plates' regions down: an affine map a node, about its own place.
    for (const auto& [low, high] :
         {std::pair(first_plate, first_region), std::pair(std::size_t{0}, first_plate)}) {
        geometry::parallel_for(
            high - low, entries_a_task, [&, low = low](std::size_t begin, std::size_t end) {
                for (std::size_t n = low + begin; n < low + end; ++n) {
                    Quad<T> total[4] = {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(),
                                        Quad<T>::Zero()};
                    for (std::uint32_t k = e.parent_at[n]; k < e.parent_at[n + 1]; ++k) {
                        const std::size_t parent = e.parent[k];
                        add_moved<T>(regions.flat, e.at[n] - e.at[parent], nodes + 4 * parent,
                                     total);
                    }
                    for (std::size_t c = 0; c < 4; ++c) nodes[4 * n + c] = total[c];
                }
            });
    }
    geometry::parallel_for(
        e.particle.size(), entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Quad<T> total = Quad<T>::Zero();
                for (std::uint32_t k = e.bar_at[i]; k < e.bar_at[i + 1]; ++k) {
                    const std::size_t bar = e.bar[k] >> 8, along = e.bar[k] & 255u;
                    total += nodes[4 * bar] + T(along) * nodes[4 * bar + 1];
                }
                sums.b[e.particle[i]] += total;
            }
        });
}

template struct RegionSums<float>;
template struct RegionSums<double>;
template void collect(const LatticeRegions&, RegionSums<float>&);
template void collect(const LatticeRegions&, RegionSums<double>&);
template void spread(const LatticeRegions&, RegionSums<float>&);
template void spread(const LatticeRegions&, RegionSums<double>&);

}  // namespace physics
#endif
