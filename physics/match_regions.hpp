#pragma once

// From sums over regions to their rigid motions, one region a SIMD lane.

#include <algorithm>
#include <array>
#include <cstddef>

namespace physics {

// Turns the sums of `count` slots (S and its moments as LatticeRegions says, `quads` quads each, 3
// of a plane) into what spread() wants: w_r R_r along axes[0], axes[1] ... times h, and w_r (c_r -
// R_r C_r). `rotation` holds the quaternions found last time, four numbers a slot. A plane's third
// axis is axes[2].
void match_slots(std::size_t count, std::size_t quads, float* slots, const float* weight,
                 float* rotation, const std::array<int, 3>& axes, float h);

}  // namespace physics
