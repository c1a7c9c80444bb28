#pragma once

// How a frame is cut into steps, and each solved: what the methods on cubes share.

namespace physics {

enum class Integrator { implicit_euler, implicit_midpoint, sdirk2 };

inline constexpr int most_substeps = 10'000;

struct StepOptions {
    Integrator integrator = Integrator::implicit_euler;
    int substeps = 1;              // a frame; of lattices 0: enough_substeps() (lattice.hpp)
    int newton_iterations = 1;     // linearisations a stage
    int contact_iterations = 30;   // solves a stage while what touches still changes
    double tolerance = 1e-4;       // of the residual, relative to the forces at work
    int solver_iterations = 2000;  // conjugate gradient iterations a solve
    bool sleep = true;             // what is at rest is not stepped
    bool leaps = false;            // whole Newton steps first: the end is far from the start
};

}  // namespace physics
