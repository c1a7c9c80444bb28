#pragma once

// Puts the lists that the pieces of a parallel loop have filled one after the other.

#include <vector>

namespace physics {

// What pieces of a loop have found, in order.
template <class Found> std::vector<Found> joined(const std::vector<std::vector<Found>>& parts)
{
    std::vector<Found> all;
    for (const auto& some : parts) all.insert(all.end(), some.begin(), some.end());
    return all;
}

}  // namespace physics
