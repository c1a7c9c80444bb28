#pragma once

// Impulses between particles that touch, of different bodies or of one, found for eight pairs at a
// time.

#include "geometry/base/vec.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace physics {

using geometry::Vec3;

// Pairs that share no body, side by side; the normal points from b to a. There can be very many of
// them, so they are kept small.
struct PairsAbreast {
    static constexpr std::size_t most = 8;

    float normal[3][most] = {};
    float drag[3][most] = {};  // N s, across the normal, so far
    float impulse[most] = {};  // N s, along the normal, so far
    float bias[most] = {};     // m/s, added to the speed along the normal: their sum closes the gap
                               // by the end of the step
    float mass[most] = {};     // kg, of both
    std::uint32_t a[most] = {}, b[most] = {};
    std::uint32_t count = 0;  // the first of them; the others are zeros
};

// The pairs of two bodies follow one another; those of up to eight that share no body go abreast,
// as a bunch. Bunches of one colour share no body, and can be worked on at the same time.
struct PairPushes {
    std::vector<PairsAbreast> row;
    std::vector<std::uint32_t> bunch_at;   // bunches + 1, into row
    std::vector<std::uint32_t> colour_at;  // colours + 1, into bunch_at
    bool last_alone = false;               // bunches of the last colour may share bodies
    float friction = 0;

    std::size_t colours() const { return std::max<std::size_t>(colour_at.size(), 1) - 1; }
};

// Adds to the velocities `v` (m/s) what those pairs want, a row after another; once. The bits do
// not depend on the processor.
void solve_rows(std::span<PairsAbreast> rows, float friction,
                const std::vector<double>& inverse_mass, std::vector<Vec3>& v);

}  // namespace physics
