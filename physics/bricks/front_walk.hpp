#pragma once

// Walks over the fronts of a dissection, with branches that are worth it on threads of their own.
// What visits compute must not depend on the order of branches.

#include "geometry/base/stop.hpp"
#include "physics/bricks/dissection.hpp"

#include <tbb/parallel_for.h>

namespace physics {

// Below this many 3 x 3 blocks a branch is not worth a thread of its own.
inline constexpr double branch_worth_a_thread = 20'000;

// child(c) for the children of a front.
template <class Child>
void for_children(const std::vector<Front>& fronts, std::uint32_t f, const Child& child)
{
    const auto& children = fronts[f].children;
    if (children.size() > 1 && fronts[f].entries > branch_worth_a_thread) {
        const std::stop_token* const stop = geometry::StopScope::current();
        tbb::parallel_for(std::size_t{0}, children.size(), [&](std::size_t i) {
            const geometry::StopScope scope(stop);
            child(children[i]);
        });
    } else {
        for (const auto c : children) child(c);
    }
}

// visit(f) after all fronts below it.
template <class Visit>
void children_first(const std::vector<Front>& fronts, std::uint32_t f, const Visit& visit)
{
    for_children(fronts, f, [&](std::uint32_t c) { children_first(fronts, c, visit); });
    geometry::stop_if_asked();
    visit(f);
}

// visit(f) before all fronts below it.
template <class Visit>
void parents_first(const std::vector<Front>& fronts, std::uint32_t f, const Visit& visit)
{
    geometry::stop_if_asked();
    visit(f);
    for_children(fronts, f, [&](std::uint32_t c) { parents_first(fronts, c, visit); });
}

}  // namespace physics
