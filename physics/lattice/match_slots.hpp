#pragma once

// From sums over regions to their rigid motions, one region a SIMD lane.

#include <algorithm>
#include <array>
#include <cstddef>

namespace physics {

// Turns the sums of `count` slots (S and its moments as LatticeRegions says) into what spread()
// wants: w_r R_r along axes[0], axes[1] ... times h, and w_r (c_r - R_r C_r). `rotation` holds the
// quaternions found last time, four numbers a slot. Of a plane, whose third axis is axes[2],
// `twist` holds three numbers a slot (RegionTwist); null for solids.
void match_slots(std::size_t count, float* slots, const float* weight, const float* twist,
                 float* rotation, const std::array<int, 3>& axes, float h);

}  // namespace physics
