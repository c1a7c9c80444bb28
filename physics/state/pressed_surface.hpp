#pragma once

// A surface that cubes carry and something presses on, in faces of six nodes: their corners in
// order, then the middles of the sides from the first to the second, the second to the third and
// the third to the first.

#include <array>
#include <cstdint>
#include <vector>

namespace physics {

struct PressedSurface {
    std::vector<std::array<std::uint32_t, 8>> corners;  // N, of the cube that carries each node
    std::vector<std::array<double, 8>> weight;          // N, of these corners; their sum is 1
    std::vector<std::array<std::uint32_t, 6>> faces;    // F, nodes
    std::uint64_t cubes = 0;                            // mark of the cubes
};

}  // namespace physics
