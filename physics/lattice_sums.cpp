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

// Lines that are summed at the same time, where a vector holds a quad of each.
inline constexpr std::size_t most_abreast = 2;

// Some lines, begin .. end, and the window that their windows' numbers start with.
struct SomeLines {
    const LatticeLines& along;
    std::size_t begin, end;
    std::uint32_t window = 0;
};

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
    // Slots are visited while they are at hand; windows of fewer quads come from far.
    static constexpr bool windows_far = (collects ? answer_quads : quads) < 4;
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
    bool alike = true;  // in where their items are
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
        if constexpr (!S::windows_far) return;
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
template <class S, bool alike, class T> HWY_INLINE void gather(const Slide<T>& slide, T* to)
{
    constexpr std::size_t numbers = 4 * S::item_quads;
    const T nothing[numbers] = {};
    const auto item = [&](const Side<T>& side, int place) HWY_ATTR -> const T* {
        const int k = place - side.lead;
        if (!alike && (k < 0 || k >= side.items)) return nothing;
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
    for (const Side<T>& s : slide.side) {
        slide.windows = std::max(slide.windows, s.windows);
        slide.alike &= s.items == slide.side[0].items && s.lead == slide.side[0].lead;
        if (s.items == 0) continue;
        slide.lead = std::min(slide.lead, s.lead);
        end = std::max(end, s.lead + s.items);
    }
    slide.items = end - slide.lead;
    const std::size_t suffixes = std::size_t(2 * slide.w + 1) * S::numbers;
    const bool in_place = !S::collects && slide.alike;
    const std::size_t items = in_place ? 0 : std::size_t(slide.items) * S::Item::numbers;
    room.resize(std::max(room.size(), suffixes + items));
    T* const gathered = room.data() + suffixes;
    if (!slide.alike) {
        gather<S, false>(slide, gathered);
    } else if (S::collects) {
        gather<S, true>(slide, gathered);
    }
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

// From items to windows, or from windows to items: for those, place 0 is the first item.
template <class S, int half_width, class T>
HWY_NOINLINE void sum_lines(const SomeLines& lines, int w, const T* from, T* to, Aligned<T>& room)
{
    const LatticeLines& along = lines.along;
    for (std::size_t first = lines.begin; first < lines.end; first += abreast) {
        Slide<T> slide;
        slide.w = w;
        for (std::size_t k = 0; k < abreast; ++k) {
            Side<T>& side = slide.side[k];
            side.from = from;
            side.to = to;
            if (first + k >= lines.end) continue;
            const auto& line = along.lines[first + k];
            side.index = along.items.data() + line.item;
            if constexpr (S::collects) {
                side.windows = int(line.windows);
                side.items = int(line.items);
                side.lead = line.lead;
                side.to += std::size_t(line.window - lines.window) * (4 * S::answer_quads);
            } else {
                side.windows = int(line.items);
                side.items = int(line.windows);
                side.lead = -line.lead;
                side.from += std::size_t(line.window - lines.window) * (4 * S::item_quads);
            }
        }
        sum_windows<S, half_width>(slide, room);
    }
}

template <class S, class T>
HWY_INLINE void sum_some(const SomeLines& lines, int w, const T* from, T* to, Aligned<T>& room)
{
    if constexpr (std::is_same_v<T, float>) {  // in double, references, one way will do
        if (w == 1) return sum_lines<S, 1>(lines, w, from, to, room);
        if (w == 2) return sum_lines<S, 2>(lines, w, from, to, room);
        if (w == 3) return sum_lines<S, 3>(lines, w, from, to, room);
        if (w == 4) return sum_lines<S, 4>(lines, w, from, to, room);
    }
    sum_lines<S, 0>(lines, w, from, to, room);
}

// Items of one, two and three quads to windows of those and their moments.
template <class T>
HWY_INLINE void collect_any(Along axis, const SomeLines& lines, int w, const T* items, T* windows,
                            Aligned<T>& room)
{
    if (axis == Along::x) sum_some<Sums<T, 1, 1, true>>(lines, w, items, windows, room);
    if (axis == Along::y) sum_some<Sums<T, 2, 1, true>>(lines, w, items, windows, room);
    if (axis == Along::y_of_plane) sum_some<Sums<T, 2, 2, true>>(lines, w, items, windows, room);
    if (axis == Along::z) sum_some<Sums<T, 3, 1, true>>(lines, w, items, windows, room);
}

// The transpose.
template <class T>
HWY_INLINE void spread_any(Along axis, const SomeLines& lines, int w, const T* windows, T* items,
                           Aligned<T>& room)
{
    if (axis == Along::x) sum_some<Sums<T, 2, 1, false>>(lines, w, windows, items, room);
    if (axis == Along::y) sum_some<Sums<T, 3, 1, false>>(lines, w, windows, items, room);
    if (axis == Along::y_of_plane) sum_some<Sums<T, 4, 2, false>>(lines, w, windows, items, room);
    if (axis == Along::z) sum_some<Sums<T, 4, 1, false>>(lines, w, windows, items, room);
}

}  // namespace sums_kernel

// Dispatch tables take plain functions.
void collect_float(Along axis, const SomeLines& lines, int w, const float* items, float* windows,
                   Aligned<float>& room)
{
    sums_kernel::collect_any(axis, lines, w, items, windows, room);
}
void collect_double(Along axis, const SomeLines& lines, int w, const double* items, double* windows,
                    Aligned<double>& room)
{
    sums_kernel::collect_any(axis, lines, w, items, windows, room);
}
void spread_float(Along axis, const SomeLines& lines, int w, const float* windows, float* items,
                  Aligned<float>& room)
{
    sums_kernel::spread_any(axis, lines, w, windows, items, room);
}
void spread_double(Along axis, const SomeLines& lines, int w, const double* windows, double* items,
                   Aligned<double>& room)
{
    sums_kernel::spread_any(axis, lines, w, windows, items, room);
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

// Slots that are visited together: they stay in the nearest cache.
constexpr std::size_t slots_a_visit = 256;

template <class T>
void collect_some(Along axis, const SomeLines& lines, int w, const T* items, T* windows,
                  Aligned<T>& room)
{
    if constexpr (std::is_same_v<T, float>) {
        HWY_DYNAMIC_DISPATCH(collect_float)(axis, lines, w, items, windows, room);
    } else {
        HWY_DYNAMIC_DISPATCH(collect_double)(axis, lines, w, items, windows, room);
    }
}

template <class T>
void spread_some(Along axis, const SomeLines& lines, int w, const T* windows, T* items,
                 Aligned<T>& room)
{
    if constexpr (std::is_same_v<T, float>) {
        HWY_DYNAMIC_DISPATCH(spread_float)(axis, lines, w, windows, items, room);
    } else {
        HWY_DYNAMIC_DISPATCH(spread_double)(axis, lines, w, windows, items, room);
    }
}

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
    make_room(exceptional, 4 * regions.exceptions.nodes());
}

namespace {

// Sums over exceptional regions, and back, by their nodes' values about their own places: S and
// three moments, or an affine map.
template <class T> class Exceptional {
public:
    Exceptional(const LatticeRegions& regions, RegionSums<T>& sums)
        : e_(regions.exceptions), flat_(regions.flat), nodes_(sums.exceptional.data()),
          particles_(sums.particles.data())
    {}

    void collect()
    {
        geometry::parallel_for(e_.bars, entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                Node total = zero();
                for (std::uint32_t k = e_.child_at[n]; k < e_.child_at[n + 1]; ++k) {
                    const Quad<T>& f = particles_[e_.child[k]];
                    total[0] += f;
                    total[1] += T(k - e_.child_at[n]) * f;  // unbroken, and about its first
                }
                put(n, total);
            }
        });
        collect_nodes(e_.bars, first_region());
        collect_nodes(first_region(), e_.nodes());
    }

    // Calls move(slot, node) with the quads of those regions whose slots are some of first .. last.
    template <class Move> void with_slots(std::size_t first, std::size_t last, const Move& move)
    {
        auto i = std::size_t(std::lower_bound(e_.region.begin(), e_.region.end(), first) -
                             e_.region.begin());
        for (; i < e_.region.size() && e_.region[i] < last; ++i) {
            move(e_.region[i], nodes_ + 4 * (first_region() + i));
        }
    }

    // From regions down; to particles it is added.
    void spread()
    {
        spread_nodes(e_.bars, first_region());
        spread_nodes(0, e_.bars);
        geometry::parallel_for(
            e_.particle.size(), entries_a_task, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    Quad<T> total = Quad<T>::Zero();
                    for (std::uint32_t k = e_.bar_at[i]; k < e_.bar_at[i + 1]; ++k) {
                        const std::size_t bar = e_.bar[k] >> 8, along = e_.bar[k] & 255u;
                        total += nodes_[4 * bar] + T(along) * nodes_[4 * bar + 1];
                    }
                    particles_[e_.particle[i]] += total;
                }
            });
    }

private:
    using Node = std::array<Quad<T>, 4>;

    static Node zero()
    {
        return {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero()};
    }
    std::size_t first_region() const { return e_.bars + e_.plates; }
    void put(std::size_t n, const Node& total)
    {
        std::copy(total.begin(), total.end(), nodes_ + 4 * n);
    }

    void collect_nodes(std::size_t low, std::size_t high)
    {
        geometry::parallel_for(high - low, entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = low + begin; n < low + end; ++n) {
                Node total = zero();
                for (std::uint32_t k = e_.child_at[n]; k < e_.child_at[n + 1]; ++k) {
                    const std::size_t child = e_.child[k];
                    add_shifted<T>(flat_, e_.at[child] - e_.at[n], nodes_ + 4 * child,
                                   total.data());
                }
                put(n, total);
            }
        });
    }
    void spread_nodes(std::size_t low, std::size_t high)
    {
        geometry::parallel_for(high - low, entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = low + begin; n < low + end; ++n) {
                Node total = zero();
                for (std::uint32_t k = e_.parent_at[n]; k < e_.parent_at[n + 1]; ++k) {
                    const std::size_t parent = e_.parent[k];
                    add_moved<T>(flat_, e_.at[n] - e_.at[parent], nodes_ + 4 * parent,
                                 total.data());
                }
                put(n, total);
            }
        });
    }

    const LatticeExceptions& e_;
    bool flat_;
    Quad<T>* nodes_;
    Quad<T>* particles_;
};

enum class Way { collect, spread, both };

// From particles to slots, back, or there and back, a few lines of slots at a time.
template <class T>
void sum_over(const LatticeRegions& regions, RegionSums<T>& sums, Way way,
              const SlotVisit<T>& visit)
{
    const bool flat = regions.flat, collects = way != Way::spread, spreads = way != Way::collect;
    const int w = regions.half_width;
    const LatticeLines& last = flat ? regions.y : regions.z;
    const Along along_last = flat ? Along::y_of_plane : Along::z;
    Quad<T>* const particles = sums.particles.data();
    Quad<T>* const bars = sums.bars.data();
    Quad<T>* const plates = sums.plates.data();
    // What slots are sums of, and are spread over again in the same place.
    Quad<T>* const near = flat ? bars : plates;
    const auto for_slabs = [&](const auto& sum) {
        geometry::parallel_for(regions.slabs.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) {
                const LatticeSlab before = s > 0 ? regions.slabs[s - 1] : LatticeSlab{};
                const LatticeSlab& slab = regions.slabs[s];
                sum(SomeLines{regions.x, before.x_lines, slab.x_lines},
                    SomeLines{regions.y, before.y_lines, slab.y_lines});
            }
        });
    };
    Exceptional<T> exceptional(regions, sums);
    if (collects) {
        exceptional.collect();
        for_slabs([&](const SomeLines& x, const SomeLines& y) {
            collect_lines(Along::x, x, w, particles, bars);
            if (!flat) collect_lines(Along::y, y, w, bars, plates);
        });
    }
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
            const auto slot = [&](std::size_t s) { return slots.data() + 4 * (s - first); };
            const auto clear = [&] {
                const auto& dead = last.dead;
                for (auto d = std::lower_bound(dead.begin(), dead.end(), first);
                     d != dead.end() && *d < next; ++d) {
                    std::fill_n(slot(*d), 4, Quad<T>::Zero());
                }
            };
            if (collects) {
                collect_some(along_last, lines, w, near->data(), slots.data()->data(), room);
                clear();
                exceptional.with_slots(first, next, [&](std::size_t s, const Quad<T>* node) {
                    std::copy_n(node, 4, slot(s));
                });
            } else {
                std::fill_n(slots.data(), 4 * (next - first), Quad<T>::Zero());
            }
            visit(first, {slots.data(), 4 * (next - first)});
            if (spreads) {
                exceptional.with_slots(first, next, [&](std::size_t s, Quad<T>* node) {
                    std::copy_n(slot(s), 4, node);
                    std::fill_n(slot(s), 4, Quad<T>::Zero());
                });
                clear();
                spread_some(along_last, lines, w, slots.data()->data(), near->data(), room);
            }
        }
    });
    if (spreads) {
        if (!flat) {
            for (const std::uint32_t d : regions.y.dead) {
                std::fill_n(plates + 3 * d, 3, Quad<T>::Zero());
            }
        }
        for (const std::uint32_t d : regions.x.dead) std::fill_n(bars + 2 * d, 2, Quad<T>::Zero());
        for_slabs([&](const SomeLines& x, const SomeLines& y) {
            if (!flat) spread_lines(Along::y, y, w, plates, bars);
            spread_lines(Along::x, x, w, bars, particles);
        });
        exceptional.spread();
    }
}

}  // namespace

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

}  // namespace physics
#endif
