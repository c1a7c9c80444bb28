#pragma once

// What Simulate tells of a state: how well its equations were solved, how deep the body is in what
// it touches, and the energy that it has.

#include "geometry/cubes/cubes.hpp"
#include "graph/types/figure.hpp"
#include "physics/body/plane_touch.hpp"
#include "physics/bricks/bricks_body.hpp"
#include "physics/bricks/elastic_energy.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/report_texts.hpp"

#include <algorithm>
#include <vector>

namespace nodes {

struct Energies {
    double own = graph::Figure::unknown;     // J, of motion and deformation
    double lifted = graph::Figure::unknown;  // J, in gravity
};

// Of all models of the body together. What contacts store is left out.
inline Energies energies(const physics::BricksBody& body, const physics::State& state,
                         const physics::Vec3& gravity)
{
    if (!state.held.empty()) return {};  // springs that hold points have some
    Energies out{physics::elastic_energy(body, state), 0};
    out.own += physics::kinetic_energy(state, *body.rest);
    const std::vector<double> mass = geometry::corner_masses(*body.rest);
    for (std::size_t k = 0; k < mass.size(); ++k) out.lifted -= mass[k] * gravity.dot(state.x[k]);
    return out;
}

// `solved` by equations that leave a residual, with so many Newton iterations a step at most, and
// with contacts that are known: by all methods but the lattice. After one iteration the residual is
// what linear forces leave of the true ones, however well they were solved. The balance of energy
// says something where only gravity does work. `edge`: m, of the largest cubes.
inline graph::Figures simulation_figures(const physics::State& state, bool solved,
                                         const physics::StepOptions& step, const Energies& energy,
                                         double edge)
{
    constexpr double unknown = graph::Figure::unknown;
    const bool timed = solved && step.integrator == physics::Integrator::implicit_euler;
    const double ended_early = physics::stopped_short(state.report) ? 1 : 0;
    const double depth =
        std::max(physics::deepest_of(state.holds), physics::deepest_of(state.grips));
    return {"simulation",
            {{"nonlinear residual, of the forces at work", solved ? state.report.residual : unknown,
              unknown, graph::Over::largest},
             {"Newton iterations a step", solved ? double(step.newton_iterations) : unknown},
             {"time step error, in cubes", timed ? state.report.step_error : unknown,
              step.substeps == 0 ? step.error : unknown, graph::Over::largest},
             {"energy", energy.own + energy.lifted, energy.own, graph::Over::balance},
             {"contact depth, m", solved ? depth : unknown, edge, graph::Over::largest},
             {"did not converge, frames", solved ? ended_early : unknown, unknown,
              graph::Over::frames}}};
}

}  // namespace nodes
