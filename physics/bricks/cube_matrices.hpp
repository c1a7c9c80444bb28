#pragma once

// The stiffness of each cube of a body, as what is made of them all asks for it: one of three
// matrices in three shares, or the cube's own, with the springs that hold it.

#include "physics/bricks/brick_element.hpp"
#include "physics/bricks/held_corners.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace physics {

struct CubeMatrices {
    std::array<BrickMatrix, 3> parts;
    std::vector<std::array<double, 3>> weights;  // C: K is the sum of weights times parts
    // Where it is not null, cubes of these that have a stiffness of their own have that, times a
    // factor (C, N/m).
    const geometry::Cubes* cubes = nullptr;
    std::vector<double> own_factor;

    // Springs that hold the material of cubes, by cube, and the factor on them.
    std::span<const HeldCube> held = {};
    double held_factor = 0;

    bool is_own(std::size_t c) const { return cubes && cubes->is_own(c); }
    // The springs of cube c.
    std::span<const HeldCube> held_in(std::size_t c) const
    {
        const auto [begin, end] = std::equal_range(held.begin(), held.end(), c, ByCube{});
        return {begin, end};
    }
    // Whether K of cube c is a sum of the parts.
    bool is_shared(std::size_t c) const { return !is_own(c) && held_in(c).empty(); }

    BrickMatrix of(std::size_t c) const
    {
        BrickMatrix sum;
        if (is_own(c)) {
            sum = own_factor[c] * stiffness_of(cubes->elements[cubes->own[c]]);
        } else {
            const auto& w = weights[c];
            sum = w[0] * parts[0] + w[1] * parts[1] + w[2] * parts[2];
        }
        for (const HeldCube& cube : held_in(c)) add_held(cube, held_factor, sum);
        return sum;
    }
};

}  // namespace physics
