#pragma once

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
