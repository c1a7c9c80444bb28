#pragma once

// Parts that touch each other in a stage, as it is or as it will be: they move as one.

#include "geometry/base/union_find.hpp"
#include "physics/bricks/stage.hpp"

#include <cstdint>
#include <vector>

namespace physics {

struct PartGroups {
    explicit PartGroups(const Stage& stage);  // of stage.contacts

    void add(const Stage& stage, const std::vector<PointContact>& contacts);
    // Bits of each part: of all parts of its group together.
    std::vector<std::uint8_t> with_all(const std::vector<std::uint8_t>& of);

    std::vector<std::uint8_t> held;  // of each part, axes along which pins and colliders hold it
    geometry::UnionFind sets;

private:
    void add_touching(const Stage& stage);
};

}  // namespace physics
