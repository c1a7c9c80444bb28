#pragma once

// The cubes near some points, kept so that many boxes are compared with one at a time.

#include "geometry/base/box_tree.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace physics {

struct NearCube {
    geometry::Box3f box;  // m
    std::uint32_t cube = 0;
};

class NearCubes {
public:
    bool empty() const { return cube_.empty(); }
    void clear();
    void add(const NearCube& cube);

    // Those whose boxes meet `span`, in the order that they were added in.
    void meeting(const geometry::Box3f& span, std::vector<NearCube>& out);

private:
    geometry::Box3f box_;  // of all
    std::vector<std::uint32_t> cube_;
    std::array<std::vector<float>, 3> lo_, hi_;  // by axis
    std::vector<std::uint32_t> meets_;           // room
};

}  // namespace physics
