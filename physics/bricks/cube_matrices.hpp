#pragma once

// The stiffness of each cube of a body, as what is made of them all asks for it: one of three
// matrices in three shares, or the cube's own.

#include "physics/bricks/brick_element.hpp"

#include <array>
#include <vector>

namespace physics {

struct CubeMatrices {
    std::array<BrickMatrix, 3> parts;
    std::vector<std::array<double, 3>> weights;  // C: K is the sum of weights times parts
    // Where it is not null, cubes of these that have a stiffness of their own have that, times a
    // factor (C, N/m).
    const geometry::Cubes* cubes = nullptr;
    std::vector<double> own_factor;

    bool is_own(std::size_t c) const { return cubes && cubes->is_own(c); }

    BrickMatrix of(std::size_t c) const
    {
        if (is_own(c)) return own_factor[c] * stiffness_of(cubes->elements[cubes->own[c]]);
        const auto& w = weights[c];
        return w[0] * parts[0] + w[1] * parts[1] + w[2] * parts[2];
    }
};

}  // namespace physics
