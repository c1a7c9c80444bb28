#pragma once

// Implicit time steps of any method that moves the corners of cubes.
//
// One stage is implicit Euler over tau seconds: the velocities w at its end are those with
//   M (w - v0) = tau (f(x0 + tau w) + f_out - D w),     x = x0 + tau w
// and every integrator is made of such stages:
//   implicit Euler       one of dt; x1 = x, v1 = w. Damps what it cannot resolve, never rings.
//   implicit midpoint    one of dt/2; x1 = 2x - x0, v1 = 2w - v0. Second order; damps nothing, so
//   it
//                        conserves momentum and (with Newton to convergence) angular momentum.
//   sdirk2               two of (1 - 1/sqrt 2) dt (Alexander 1977). Second order, and damps only
//                        what it cannot resolve.
// A stage is linearised where it starts and solved once (Baraff, Witkin. Large steps in cloth
// simulation. SIGGRAPH 1998); more Newton iterations if asked. Contact is solved with it by a
// semismooth Newton iteration over the points that touch.
// Where that would turn or stretch a cube by a large part of itself in one stage, the linear forces
// mean nothing, and stiff parts on soft ones would be flung out. Such a stage goes down the
// potential whose minimum it is (Martin, Thomaszewski, Grinspun, Gross. Example-based elastic
// materials. SIGGRAPH 2011),
//   Phi(w) = 1/2 (w - v0)^T M (w - v0) + U(x0 + tau w) - tau f_out . w + 1/2 tau w^T D w
// by Newton steps with a line search, so that it can only lose energy.

#include "physics/corner_body.hpp"
#include "physics/loads.hpp"
#include "physics/state.hpp"

namespace physics {

enum class Integrator { implicit_euler, implicit_midpoint, sdirk2 };

inline constexpr int most_substeps = 10'000;

struct StepOptions {
    Integrator integrator = Integrator::implicit_euler;
    int substeps = 1;              // a frame
    int newton_iterations = 1;     // linearisations a stage
    int contact_iterations = 30;   // solves a stage while what touches still changes
    double tolerance = 1e-4;       // of the residual, relative to the forces at work
    int solver_iterations = 2000;  // conjugate gradient iterations a solve
};

// What a method contributes: its forces and their derivative. Vectors hold four numbers a slot.
class Elasticity {
public:
    virtual ~Elasticity() = default;

    // Numbers in a vector that forces are added up in.
    virtual std::size_t room() const = 0;
    // f = the elastic forces at x, of which the derivative is kept.
    virtual void forces(const double* x, double* f) = 0;
    // The elastic energy at x, J. What was kept of a derivative is lost.
    virtual double energy(const double* x) = 0;
    // The largest difference of a field between two corners that the method ties together, about.
    virtual double largest_difference(const double* w) const = 0;
    // From here on K stands for stiffness * K + damping * (Rayleigh's part of) K.
    virtual void weigh(double stiffness, double damping) = 0;
    virtual void multiply(const float* p, float* y) const = 0;  // y = K p
    virtual void multiply(const double* p, double* y) const = 0;
    virtual void add_diagonal(double* d) const = 0;  // of K, about

    // What a state keeps so that the next one starts from there: State::rotation.
    virtual std::vector<float> rotations() const { return {}; }

    // Makes ready an approximate inverse of stiffness * K + damping * (Rayleigh's) + mass (K by
    // slot) with the corners `held` (sorted) left out. Returns what it costs to apply, in products
    // with K; infinity when the method has none.
    virtual double prepare_inverse(double stiffness, double damping,
                                   const std::vector<double>& mass,
                                   const std::vector<std::uint32_t>& held);
    // z = that inverse of r, 0 at held corners; symmetric and positive.
    virtual void apply_inverse(const float* r, float* z);
};

// The state `dt` seconds later. Throws std::invalid_argument when state or loads do not fit the
// body or are not finite; whatever else goes wrong is told in the report of a finite state.
State advance_implicitly(const CornerBody& body, Elasticity& elasticity, State state,
                         const Loads& loads, double dt, const StepOptions& options);

// The cubes at rest with their first corner positions moved by nothing: x = rest, v = 0.
State rest_state(const CornerBody& body);

}  // namespace physics
