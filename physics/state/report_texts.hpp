#pragma once

// Warnings that several methods put into their reports. No number in them changes from frame to
// frame, because each new text is printed again.

#include <string>

namespace physics {

// Of `inverted` > 0 cubes of all. `fast`: corners move by more than a cube in a step, so that a
// stiffer material would make it worse.
inline std::string told_of_inverted(std::size_t inverted, std::size_t all, bool fast = false)
{
    const bool few = 4 * inverted < all;
    return std::string(few ? "Some cubes" : "A quarter of the cubes or more") +
           " are inverted or pressed flat" +
           (fast ? ", and corners move more than a cube per step. Use more substeps."
                 : ". Use a stiffer material or more substeps.");
}

// Of a step that could not be taken.
inline const char* told_of_divergence()
{
    return "The step diverged; the last state was kept. Check for very large forces or pin "
           "targets.";
}

// Of corners that are so far away that single precision, in which meshes are written, cannot hold
// the squares of their distances.
inline const char* told_of_distance()
{
    return "The simulation diverged: corners are more than 1e15 m away. Check for very large "
           "forces, velocities or pin targets.";
}
inline constexpr double farthest = 1e15;  // m

}  // namespace physics
