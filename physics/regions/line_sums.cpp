#include "physics/regions/line_sums.hpp"

// From the inside out: two lines that are summed abreast (Side, Slide); their windows, by blocks or
// item by item (slide_blocks, slide_item_by_item); items of lines of unequal length (gather); all
// lines of an axis (sum_lines, collect_any, spread_any). At the end the choice of the processor.
// What is added up stands in window_sums-inl.hpp.

#include <hwy/cache_control.h>

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/regions/line_sums.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "physics/regions/window_sums-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace sums_kernel {

static_assert(abreast <= most_abreast);

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

template void collect_some(Along, const SomeLines&, int, const float*, float*, Aligned<float>&);
template void collect_some(Along, const SomeLines&, int, const double*, double*, Aligned<double>&);
template void spread_some(Along, const SomeLines&, int, const float*, float*, Aligned<float>&);
template void spread_some(Along, const SomeLines&, int, const double*, double*, Aligned<double>&);

}  // namespace physics
#endif
