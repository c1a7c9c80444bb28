// What a window adds up as it slides: its items and their moments about the place it is seen from,
// and how those change as the place does. Included once for each Highway target.

#if defined(PHYSICS_WINDOW_SUMS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef PHYSICS_WINDOW_SUMS_INL_HPP
#undef PHYSICS_WINDOW_SUMS_INL_HPP
#else
#define PHYSICS_WINDOW_SUMS_INL_HPP
#endif

#include <hwy/highway.h>

#include "physics/regions/rows-inl.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace sums_kernel {

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

}  // namespace sums_kernel
}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#endif
