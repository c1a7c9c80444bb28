#pragma once

// From sums over regions to their rigid motions, one region a SIMD lane.

#include <algorithm>
#include <array>
#include <cstddef>

namespace physics {

// Turns the sums of `count` slots (S and its moments as LatticeRegions says) into what spread()
// wants: w_r R_r along axes[0], axes[1] ... times h, and w_r (c_r - R_r C_r). `rotation` holds the
// quaternions found last time, four numbers a slot.
struct MatchedSlots {
    std::size_t count = 0;
    float* slots = nullptr;         // 16 each
    const float* weight = nullptr;  // w_r
    float* rotation = nullptr;
    const float* twist = nullptr;   // of a plane, whose third axis is axes[2], a RegionTwist each
    const float* volume = nullptr;  // of a solid that keeps its volume, a RegionVolume each,
    const float* volume_share = nullptr;   // and K / k
    const float* stretch_share = nullptr;  // with volume: S / k, of what resists stretch apart
    std::array<int, 3> axes{};
    float h = 0;
};
void match_slots(const MatchedSlots& of);

}  // namespace physics
