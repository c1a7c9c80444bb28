#pragma once

// How a frame is cut into steps, and each solved: what the methods on cubes share.

namespace physics {

enum class Integrator { implicit_euler, implicit_midpoint, sdirk2 };

inline constexpr int most_substeps = 10'000;

struct StepOptions {
    Integrator integrator = Integrator::implicit_euler;
    // A frame. 0: as many as keep the error of each, and at least one (of other integrators than
    // implicit Euler, one); of lattices enough_substeps() (lattice.hpp).
    int substeps = 1;
    double error = 0.1;            // cubes, of a step (step_error.hpp), where substeps = 0
    int newton_iterations = 1;     // linearisations a stage
    int contact_iterations = 30;   // solves a stage while what touches still changes
    double tolerance = 1e-4;       // of the residual, relative to the forces at work
    int solver_iterations = 2000;  // conjugate gradient iterations a solve
    bool sleep = true;             // what is at rest is not stepped
    bool leaps = false;            // whole Newton steps first: the end is far from the start
};

// The least number of steps a frame, of other methods than lattices.
inline int least_steps(const StepOptions& options)
{
    return options.substeps > 0 ? options.substeps : 1;
}

}  // namespace physics
