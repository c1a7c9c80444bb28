#pragma once

// A state as a frame of steps takes it, and what is told of one that it leaves.

#include "physics/body/corner_body.hpp"
#include "physics/state/report_texts.hpp"
#include "physics/state/state.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace physics {

inline bool is_far(const State& state)
{
    return std::any_of(state.x.begin(), state.x.end(),
                       [](const Vec3& x) { return !(x.cwiseAbs().maxCoeff() <= farthest); });
}

// Throws std::invalid_argument where it does not fit the body or is not finite.
inline void check_state(const CornerBody& body, const State& state)
{
    const auto expected = std::to_string(body.corners);
    if (state.x.size() != body.corners || state.v.size() != body.corners) {
        throw std::invalid_argument("state: expected " + expected + " corners, found " +
                                    std::to_string(state.x.size()) +
                                    ". Was it made with other cubes?");
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        if (!state.x[k].allFinite() || !state.v[k].allFinite()) {
            throw std::invalid_argument("state: corner " + std::to_string(k) +
                                        " has a position or velocity that is not finite");
        }
    }
}

}  // namespace physics
