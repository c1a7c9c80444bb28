#pragma once

// The cells of sheets in the surface of a body, and which of them a corner belongs to.

#include "physics/body/corner_body.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace physics {

struct FlatCells {
    std::vector<std::uint32_t> cell;                   // C, among all cubes of the surface
    std::vector<std::array<std::uint32_t, 4>> corner;  // C, slots: (0, 0), (1, 0), (0, 1), (1, 1)
    std::vector<std::uint32_t> first, of;  // of each slot: into cell, of[first[slot]] ..

    std::span<const std::uint32_t> at(std::uint32_t slot) const
    {
        return std::span(of).subspan(first[slot], first[slot + 1] - first[slot]);
    }
};

// Those cubes of the surface of which one side lies on the opposite one.
FlatCells flat_cells(const CornerBody& body);

}  // namespace physics
