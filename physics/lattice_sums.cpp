#include "physics/lattice_regions.hpp"

#include "geometry/parallel.hpp"
#include "physics/aligned.hpp"

#include <hwy/cache_control.h>

#include <algorithm>
#include <limits>

#ifndef PHYSICS_LATTICE_SUMS_CPP  // once for all targets
#define PHYSICS_LATTICE_SUMS_CPP
namespace physics {

// Lines along an axis: items of one, two and three quads, and their windows with one more, of a
// plane along y with two.
enum class Along { x, y, y_of_plane, z };
inline constexpr std::size_t quads_of_window[] = {2, 3, 4, 4};

// Lines that are summed at the same time, where a vector holds a quad of each.
inline constexpr std::size_t most_abreast = 2;

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

#if HWY_TARGET == HWY_SCALAR  // one line at a time
inline constexpr std::size_t abreast = 1;
#else
inline constexpr std::size_t abreast = most_abreast;
#endif

// Eight numbers: a quad of one line and a quad of the other.
template <class D, class T>
HWY_INLINE hn::Vec<D> load_both(D d, const T* one, [[maybe_unused]] const T* other)
{
#if HWY_TARGET == HWY_SCALAR
    return hn::LoadU(d, one);
#else
    const hn::Half<D> half;
    return hn::Combine(d, hn::LoadU(half, other), hn::LoadU(half, one));
#endif
}
template <class D, class V, class T>
HWY_INLINE void store_one([[maybe_unused]] D d, V both, [[maybe_unused]] bool other, T* to)
{
#if HWY_TARGET == HWY_SCALAR
    hn::StoreU(both, d, to);
#else
    const hn::Half<D> half;
    hn::StoreU(other ? hn::UpperHalf(half, both) : hn::LowerHalf(half, both), half, to);
#endif
}

// Quads of all those lines in turn, that are added as one.
template <class T, std::size_t quads> struct Row {
    static constexpr std::size_t group = 4 * abreast, numbers = group * quads;
    using D = hn::CappedTag<T, group>;
    static constexpr std::size_t lanes = hn::MaxLanes(D()), parts = numbers / lanes;

    hn::Vec<D> part[parts];

    HWY_INLINE void clear()
    {
        for (auto& p : part) p = hn::Zero(D());
    }
    HWY_INLINE void load(const T* from)
    {
        for (std::size_t i = 0; i < parts; ++i) part[i] = hn::LoadU(D(), from + i * lanes);
    }
    HWY_INLINE void store(T* to) const
    {
        for (std::size_t i = 0; i < parts; ++i) hn::StoreU(part[i], D(), to + i * lanes);
    }
    // From the quads of each line, `at` the same place.
    HWY_INLINE void load(const T* const (&from)[abreast], std::ptrdiff_t at)
    {
        for (std::size_t i = 0; i < parts; ++i) {
            const std::size_t quad = i * lanes / group, within = i * lanes % group;
            if constexpr (lanes == 8) {
                part[i] = load_both(D(), from[0] + at + 4 * quad, from[1] + at + 4 * quad);
            } else {
                part[i] = hn::LoadU(D(), from[within / 4] + at + 4 * quad + within % 4);
            }
        }
    }
    HWY_INLINE void store_line(std::size_t line, T* to) const
    {
        for (std::size_t i = 0; i < parts; ++i) {
            const std::size_t quad = i * lanes / group, within = i * lanes % group;
            if constexpr (lanes == 8) {
                store_one(D(), part[i], line == 1, to + 4 * quad);
            } else if (within / 4 == line) {
                hn::StoreU(part[i], D(), to + 4 * quad + within % 4);
            }
        }
    }
    // `some` quads from `to` on, and of another row from `from` on.
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void copy(const Row<T, length>& o)
    {
        for (std::size_t i = 0; i < of(some); ++i) part[of(to) + i] = o.part[of(from) + i];
    }
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void add(const Row<T, length>& o)
    {
        for (std::size_t i = 0; i < of(some); ++i) {
            part[of(to) + i] = hn::Add(part[of(to) + i], o.part[of(from) + i]);
        }
    }
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void subtract(const Row<T, length>& o)
    {
        for (std::size_t i = 0; i < of(some); ++i) {
            part[of(to) + i] = hn::Sub(part[of(to) + i], o.part[of(from) + i]);
        }
    }
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void add_times(T factor, const Row<T, length>& o)
    {
        const auto times = hn::Set(D(), factor);
        for (std::size_t i = 0; i < of(some); ++i) {
            part[of(to) + i] = hn::Add(part[of(to) + i], hn::Mul(times, o.part[of(from) + i]));
        }
    }

private:
    static constexpr std::size_t of(std::size_t some) { return some * group / lanes; }
};

// What a window sums, as seen from a place. Collected: S, the sum of its items, and the moments
// about that place of their first quads. Spread: the sum of its maps at that place, which their
// last quads move by as the place does.
template <class T, std::size_t quads, std::size_t moments, bool collects_> struct Sums {
    static constexpr bool collects = collects_;
    static constexpr std::size_t item_quads = quads, sum_quads = collects ? quads + moments : quads;
    static constexpr std::size_t answer_quads = collects ? sum_quads : quads - moments;
    static constexpr std::size_t added_quads = std::min(quads, answer_quads);
    static constexpr std::size_t moment_quads = moments;
    // As the place moves, `moments` quads from `moved` on change by those from `by` on.
    static constexpr std::size_t moved = collects ? quads : 0, by = collects ? 0 : quads - moments;
    static constexpr std::size_t numbers = Row<T, sum_quads>::numbers;
    using Item = Row<T, quads>;
    using Answer = Row<T, answer_quads>;

    Row<T, sum_quads> sum;

    HWY_INLINE void clear() { sum.clear(); }
    HWY_INLINE void step_on()
    {
        if constexpr (collects) {
            sum.template subtract<moved, by, moments>(sum);
        } else {
            sum.template add<moved, by, moments>(sum);
        }
    }
    // A step, then the item there. What is spread waits for one addition each, not two.
    HWY_INLINE void step_on(Item item)
    {
        if constexpr (collects) {
            step_on();
        } else {
            item.template add<moved, by, moments>(sum);
        }
        sum.template add<0, 0, quads>(item);
    }
    HWY_INLINE void step_back(Item item)
    {
        if constexpr (collects) {
            sum.template add<moved, by, moments>(sum);
        } else {
            item.template subtract<moved, by, moments>(sum);
        }
        sum.template add<0, 0, quads>(item);
    }
    HWY_INLINE void go_on(T steps)
    {
        sum.template add_times<moved, by, moments>(collects ? -steps : steps, sum);
    }
    // What `after` and `before`, one place on and one back, add to those that move.
    template <std::size_t length>
    static HWY_INLINE Row<T, moments> lever(const Row<T, length>& before,
                                            const Row<T, length>& after)
    {
        Row<T, moments> row;
        row.template copy<0, by, moments>(collects ? after : before);
        row.template subtract<0, by, moments>(collects ? before : after);
        return row;
    }
    // Both together, of the place w after that of `before` and w before that of `after`.
    static HWY_INLINE Answer meet(T w, const Sums& before, const Sums& after)
    {
        Answer answer;
        answer.template copy<0, 0, answer_quads>(before.sum);
        answer.template add<0, 0, answer_quads>(after.sum);
        answer.template add_times<moved, 0, moments>(w, lever(before.sum, after.sum));
        return answer;
    }
};

// Asks for the item of the next lines at this place: those go along beside these, so mostly it lies
// a few items further on.
template <std::size_t numbers, class T> HWY_INLINE void fetch_beside(const T* item)
{
    hwy::Prefetch(item + numbers * (abreast + 1) - 1);
}

// One of the lines that are summed abreast: its items are at the places lead .. lead + items - 1 as
// seen from its windows. In order to collect, items are looked up by `index` and windows go to `to`
// one after another; in order to spread it is the other way round.
template <class T> struct Side {
    int windows = 0, items = 0, lead = 0;
    const T* from = nullptr;
    T* to = nullptr;
    const std::uint32_t* index = nullptr;
};

// Lines abreast: items at the places lead .. lead + items - 1 of both, as seen from the windows,
// which are at 0 .. windows - 1. What is collected lies in `gathered`, quads of both lines in turn;
// what is spread one place after another at the `from` of each line.
template <class T> struct Slide {
    int w = 1, windows = 0, lead = 0, items = 0;
    Side<T> side[abreast];
    const T* gathered = nullptr;
    const T* from[abreast] = {};

    bool has(int place) const { return place >= lead && place < lead + items; }
    // How far items lie apart, and the one that lies `at` from the first.
    template <class S> static constexpr std::ptrdiff_t stride()
    {
        return std::ptrdiff_t(S::collects ? S::Item::numbers : 4 * S::item_quads);
    }
    template <class S> HWY_INLINE typename S::Item item_at(std::ptrdiff_t at) const
    {
        typename S::Item row;
        if constexpr (S::collects) {
            row.load(gathered + at);
        } else {
            row.load(from, at);
        }
        return row;
    }
    template <class S> HWY_INLINE typename S::Item item(int place) const
    {
        return item_at<S>((place - lead) * stride<S>());
    }
    // Asks for the memory of this place in the next lines, of their windows, which lie one after
    // another. Here and there it costs nothing; all of a line at once would be waited for.
    template <class S> HWY_INLINE void fetch_ahead(int at) const
    {
        for (const Side<T>& s : side) {
            const int next = at + int(abreast) * (S::collects ? s.windows : s.items);
            if constexpr (S::collects) {
                hwy::Prefetch(s.to + std::size_t(next) * (4 * S::answer_quads));
            } else {
                hwy::Prefetch(s.from + std::size_t(next) * (4 * S::item_quads));
            }
        }
    }
    template <class S> HWY_INLINE void answer(int at, const typename S::Answer& answer) const
    {
        for (std::size_t l = 0; l < abreast; ++l) {
            if (at >= side[l].windows) continue;
            std::size_t place = std::size_t(at);
            if constexpr (!S::collects) {
                if (side[l].index[at] == none) continue;
                place = side[l].index[at];
            }
            T* const to = side[l].to + place * (4 * S::answer_quads);
            answer.store_line(l, to);
            if constexpr (!S::collects) fetch_beside<4 * S::answer_quads>(to);
        }
    }
};

// `suffix` has room for 2w + 1 sums. A half width that the compiler knows, not 0, makes short
// blocks cheaper.
template <class S, int half_width, class T>
HWY_INLINE void slide_blocks(const Slide<T>& line, T* suffix)
{
    constexpr std::ptrdiff_t entry = std::ptrdiff_t(S::numbers);
    constexpr std::ptrdiff_t stride = Slide<T>::template stride<S>();
    const int w = half_width > 0 ? half_width : line.w, length = 2 * w + 1;
    for (int first = 0; first < line.windows; first += length) {
        const int base = first - w, next = base + length;  // first positions of blocks
        const int stored = std::min(length, line.windows - first);
        const int low = std::clamp(line.lead - base, 0, length);
        const int high = std::clamp(line.lead + line.items - base, low, length);

        // Suffix sums: from position base + j to the block's end, as seen from base + j. Those
        // before the first item differ by their place only.
        S whole;
        whole.clear();
        for (int j = high; j < stored; ++j) whole.sum.store(suffix + j * entry);
        std::ptrdiff_t item = (base + high - 1 - line.lead) * stride;
        int j = high - 1;
        for (; j >= std::max(low, stored); --j, item -= stride) {
            whole.step_back(line.template item_at<S>(item));
        }
        for (std::ptrdiff_t to = j * entry; j >= low; --j, item -= stride, to -= entry) {
            whole.step_back(line.template item_at<S>(item));
            whole.sum.store(suffix + to);
        }

        // And prefix sums of the next block up to position first + t + w, as seen from that.
        const int enter = std::max(1, line.lead - next + 1);
        const unsigned entering = unsigned(std::max(0, line.lead + line.items - next + 1 - enter));
        item = (next - 1 - line.lead) * stride;
        const T* kept = suffix;
        S part;
        part.clear();
        for (int t = 0; t < stored; ++t, item += stride, kept += entry) {
            if (unsigned(t - enter) < entering) {
                part.step_on(line.template item_at<S>(item));
            } else {
                part.step_on();
            }
            S rest;
            if (t < low) {
                rest = whole;
                rest.go_on(T(t - low));
            } else {
                rest.sum.load(kept);
            }
            line.template fetch_ahead<S>(first + t);
            line.template answer<S>(first + t, S::meet(T(w), rest, part));
        }
    }
}

// Of windows with this half width, and items of so many quads: what is near stays in registers.
template <int half_width, std::size_t quads>
inline constexpr bool is_narrow = half_width > 0 && half_width < 4 &&
                                  (2 * half_width + 1) * quads <= 21;

// The same for narrow windows, item by item: as long as registers hold what is near, adding it all
// costs less than writing suffixes down.
template <int w, class S, class T> HWY_INLINE void slide_item_by_item(const Slide<T>& line)
{
    constexpr int length = 2 * w + 1;
    typename S::Item near[length];
    const auto read = [&](int place, typename S::Item& to) HWY_ATTR {
        if (line.has(place)) {
            to = line.template item<S>(place);
        } else {
            to.clear();
        }
    };
    for (int d = 1; d < length; ++d) read(d - 1 - w, near[d]);
    for (int at = 0; at < line.windows; ++at) {
        for (int d = 1; d < length; ++d) near[d - 1] = near[d];
        read(at + w, near[length - 1]);
        typename S::Answer answer;
        answer.clear();
        answer.template copy<0, 0, S::added_quads>(near[0]);
        for (int d = 1; d < length; ++d) answer.template add<0, 0, S::added_quads>(near[d]);
        for (int d = 1; d <= w; ++d) {
            answer.template add_times<S::moved, 0, S::moment_quads>(
                T(d), S::lever(near[w - d], near[w + d]));
        }
        line.template fetch_ahead<S>(at);
        line.template answer<S>(at, answer);
    }
}

// Items of all places, zeros where a line has none.
template <class S, class T> HWY_INLINE void gather(const Slide<T>& slide, T* to)
{
    constexpr std::size_t numbers = 4 * S::item_quads;
    const T nothing[numbers] = {};
    const auto item = [&](const Side<T>& side, int place) HWY_ATTR -> const T* {
        const int k = place - side.lead;
        if (k < 0 || k >= side.items) return nothing;
        if constexpr (S::collects) {
            const std::uint32_t i = side.index[k];
            return i == none ? nothing : side.from + std::size_t(i) * numbers;
        } else {
            return side.from + std::size_t(k) * numbers;
        }
    };
    for (int k = 0; k < slide.items; ++k) {
        const T* from[abreast];
        for (std::size_t l = 0; l < abreast; ++l) from[l] = item(slide.side[l], slide.lead + k);
        typename S::Item row;
        if constexpr (S::collects) {
            for (const T* f : from) fetch_beside<numbers>(f);
        }
        row.load(from, 0);
        if constexpr (S::collects) {
            row.store(to + std::size_t(k) * S::Item::numbers);
        } else {
            for (std::size_t l = 0; l < abreast; ++l) {
                row.store_line(l, to + (l * std::size_t(slide.items) + std::size_t(k)) * numbers);
            }
        }
    }
}

// Sums along the lines of `slide`.
template <class S, int half_width, class T>
HWY_INLINE void sum_windows(Slide<T>& slide, Aligned<T>& room)
{
    slide.lead = std::numeric_limits<int>::max();
    int end = std::numeric_limits<int>::min();
    bool alike = true;
    for (const Side<T>& s : slide.side) {
        slide.windows = std::max(slide.windows, s.windows);
        alike &= s.items == slide.side[0].items && s.lead == slide.side[0].lead;
        if (s.items == 0) continue;
        slide.lead = std::min(slide.lead, s.lead);
        end = std::max(end, s.lead + s.items);
    }
    slide.items = end - slide.lead;
    const std::size_t suffixes = std::size_t(2 * slide.w + 1) * S::numbers;
    const bool in_place = !S::collects && alike;
    const std::size_t items = in_place ? 0 : std::size_t(slide.items) * S::Item::numbers;
    room.resize(std::max(room.size(), suffixes + items));
    T* const gathered = room.data() + suffixes;
    if (!in_place) gather<S>(slide, gathered);
    slide.gathered = gathered;
    for (std::size_t l = 0; l < abreast; ++l) {
        slide.from[l] = in_place ? slide.side[l].from : gathered + l * (items / abreast);
    }
    if constexpr (is_narrow<half_width, S::item_quads>) {
        slide_item_by_item<half_width, S>(slide);
    } else {
        slide_blocks<S, half_width>(slide, room.data());
    }
}

// Lines begin .. end of `along`, from items to windows, or from windows to items: for those, place
// 0 is the first item.
template <class S, int half_width, class T>
HWY_NOINLINE void sum_lines(const LatticeLines& along, std::size_t begin, std::size_t end, int w,
                            const T* from, T* to, Aligned<T>& room)
{
    for (std::size_t first = begin; first < end; first += abreast) {
        Slide<T> slide;
        slide.w = w;
        for (std::size_t k = 0; k < abreast; ++k) {
            Side<T>& side = slide.side[k];
            side.from = from;
            side.to = to;
            if (first + k >= end) continue;
            const auto& line = along.lines[first + k];
            side.index = along.items.data() + line.item;
            if constexpr (S::collects) {
                side.windows = int(line.windows);
                side.items = int(line.items);
                side.lead = line.lead;
                side.to += std::size_t(line.window) * (4 * S::answer_quads);
            } else {
                side.windows = int(line.items);
                side.items = int(line.windows);
                side.lead = -line.lead;
                side.from += std::size_t(line.window) * (4 * S::item_quads);
            }
        }
        sum_windows<S, half_width>(slide, room);
    }
}

template <class S, class T>
HWY_INLINE void sum_some(const LatticeLines& along, std::size_t begin, std::size_t end, int w,
                         const T* from, T* to, Aligned<T>& room)
{
    if constexpr (std::is_same_v<T, float>) {  // in double, references, one way will do
        if (w == 1) return sum_lines<S, 1>(along, begin, end, w, from, to, room);
        if (w == 2) return sum_lines<S, 2>(along, begin, end, w, from, to, room);
        if (w == 3) return sum_lines<S, 3>(along, begin, end, w, from, to, room);
        if (w == 4) return sum_lines<S, 4>(along, begin, end, w, from, to, room);
    }
    sum_lines<S, 0>(along, begin, end, w, from, to, room);
}

// Items of one, two and three quads to windows of those and their moments.
template <class T>
HWY_INLINE void collect_any(Along axis, const LatticeLines& along, std::size_t begin,
                            std::size_t end, int w, const T* items, T* windows, Aligned<T>& room)
{
    if (axis == Along::x) sum_some<Sums<T, 1, 1, true>>(along, begin, end, w, items, windows, room);
    if (axis == Along::y) sum_some<Sums<T, 2, 1, true>>(along, begin, end, w, items, windows, room);
    if (axis == Along::y_of_plane) {
        sum_some<Sums<T, 2, 2, true>>(along, begin, end, w, items, windows, room);
    }
    if (axis == Along::z) sum_some<Sums<T, 3, 1, true>>(along, begin, end, w, items, windows, room);
}

// The transpose.
template <class T>
HWY_INLINE void spread_any(Along axis, const LatticeLines& along, std::size_t begin,
                           std::size_t end, int w, const T* windows, T* items, Aligned<T>& room)
{
    if (axis == Along::x)
        sum_some<Sums<T, 2, 1, false>>(along, begin, end, w, windows, items, room);
    if (axis == Along::y)
        sum_some<Sums<T, 3, 1, false>>(along, begin, end, w, windows, items, room);
    if (axis == Along::y_of_plane) {
        sum_some<Sums<T, 4, 2, false>>(along, begin, end, w, windows, items, room);
    }
    if (axis == Along::z)
        sum_some<Sums<T, 4, 1, false>>(along, begin, end, w, windows, items, room);
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
        (along.lines.size() + most_abreast - 1) / most_abreast, entries_a_task / 8 / most_abreast,
        [&](std::size_t group, std::size_t last) {
            const std::size_t begin = group * most_abreast;
            const std::size_t end = std::min(along.lines.size(), last * most_abreast);
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
        (along.lines.size() + most_abreast - 1) / most_abreast, entries_a_task / 8 / most_abreast,
        [&](std::size_t group, std::size_t last) {
            const std::size_t begin = group * most_abreast;
            const std::size_t end = std::min(along.lines.size(), last * most_abreast);
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
    const auto make_room = [](auto& in, std::size_t n) {
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
