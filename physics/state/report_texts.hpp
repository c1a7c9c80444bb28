#pragma once

// Warnings that several methods put into their reports. No number in them changes from frame to
// frame, because each new text is printed again.

#include "physics/state/state.hpp"

#include <algorithm>
#include <string>

namespace physics {

// How steps become shorter: where their number is the user's, or chosen by their error.
inline constexpr const char* by_substeps = "raise step.substeps.";
inline constexpr const char* by_substeps_or_error =
    "raise step.substeps; where it is 0, lower step.error.";

// Of `inverted` > 0 cubes of all. `fast`: corners move by more than a cube in a step, so that a
// stiffer material would make it worse.
inline std::string told_of_inverted(std::size_t inverted, std::size_t all, bool fast = false,
                                    const char* shorter = by_substeps_or_error)
{
    const bool few = 4 * inverted < all;
    return std::string(few ? "Some cubes" : "A quarter of the cubes or more") +
           " are inverted or pressed flat" +
           (fast ? ", and corners move more than a cube per step. Use shorter steps: "
                 : ". Use a stiffer material or shorter steps: ") +
           shorter;
}

// Of a step that could not be taken.
inline const char* told_of_divergence()
{
    return "The step diverged; the last state was kept. Check for very large forces or pin "
           "targets.";
}

// Of steps whose solve ended before its tolerance was met.
inline constexpr const char* short_linear_solve =
    "The linear solver did not converge to step.tolerance. Raise step.solver_iterations.";
inline constexpr const char* short_of_speed =
    "The motion is too fast for the time step: the forces are not balanced to step.tolerance. "
    "Raise step.substeps; where it is 0, lower step.error.";
inline constexpr const char* short_newton =
    "Newton's method did not converge to step.tolerance. Raise step.newton_iterations or "
    "step.substeps; where that is 0, lower step.error.";
inline constexpr const char* short_contact =
    "Contact did not converge to step.tolerance. Raise step.contact_iterations or step.substeps; "
    "where that is 0, lower step.error.";

// Of corners that are so far away that single precision, in which meshes are written, cannot hold
// the squares of their distances.
inline const char* told_of_distance()
{
    return "The simulation diverged: corners are more than 1e15 m away. Check for very large "
           "forces, velocities or pin targets.";
}
inline constexpr double farthest = 1e15;  // m

// Whether a report tells of such a solve, or of a step that could not be taken. Of linear forces
// alone (newton_iterations = 1) the residual says little: `converged` tells of it.
inline bool stopped_short(const Report& report)
{
    return std::any_of(report.warnings.begin(), report.warnings.end(), [](const auto& text) {
        return text == short_linear_solve || text == short_of_speed || text == short_newton ||
               text == short_contact || text == told_of_divergence() || text == told_of_distance();
    });
}

}  // namespace physics
