#pragma once

// Lattice shape matching: fast, unconditionally stable, and as stiff as its regions are wide.
// Rivers, James. FastLSM: fast lattice shape matching for robust real-time deformation. SIGGRAPH
// 2007. After Mueller, Heidelberger, Teschner, Gross. Meshless deformations based on shape
// matching. SIGGRAPH 2005.
//
// Particles sit on the corners of the cubes, linked along the cubes' edges. (Not on their centres:
// embedding, pins and contact speak of corners, a region is never flat or a line, and a single cube
// is a body.) With M_i = m_i / |R_i| and sums over the particles of region r,
//   c_r = (1/M_r) sum M_i x_i        A_r = sum M_i x_i (X_i - C_r)^T        R_r = rotation of A_r
//   T_r X = c_r + R_r (X - C_r)      d_i = mean over the regions of i of w_r (T_r X_i - x_i)
//   v_i <- v_i + (alpha d_i + beta (d_i - d_i before)) / dt + dt f_i / m_i ;  x_i <- x_i + dt v_i
// d sums to no force and no torque in every region, whatever the weight w_r of the region.
//
// alpha = 1 - exp(-s^2 dt^2), so that the acceleration s^2 d does not depend on the step as long as
// s dt is small, and s without bound is as stiff as the method gets. A long wave sees d as
// -k^2 h^2 w (w + 1) / 3 of its displacement, so the lattice is an elastic solid with
//   E = rho s^2 h^2 w (w + 1) / 3 and Poisson ratio 0,
// and s follows from the material. (A rate -ln(1 - alpha) / dt, as in position-based methods, would
// keep relaxation but not inertia: frequencies would rise with 1 / sqrt(dt).) beta = 1 - exp(-c
// dt).

#include "physics/brick_element.hpp"
#include "physics/corner_body.hpp"
#include "physics/implicit_step.hpp"
#include "physics/lattice_regions.hpp"
#include "physics/loads.hpp"
#include "physics/state.hpp"

namespace physics {

enum class Precision { single, full };
enum class Stiffness { material, rate };

struct LatticeOptions {
    int half_width = 2;  // w, of regions, in cubes
    Weighting weighting = Weighting::filled;
    Stiffness stiffness = Stiffness::material;  // s from the material, or `rate` everywhere
    double rate = 100;                          // s, 1/s; infinite: as stiff as the regions allow
    double damping = 0;  // tau, s, on top of the material's own stiffness damping
    int substeps = 4;    // a frame
    Precision precision = Precision::single;  // of the sums over regions; motion is kept in double
};

// All that depends on the cubes, the half width and the weighting alone.
struct LatticeBody {
    CornerBody base;         // slots are the corners themselves
    LatticeOptions options;  // as it was made
    LatticeRegions regions;
    std::vector<float> mass;     // N, kg, M_i
    std::vector<float> held_by;  // N, 1 / |R_i|
    std::vector<float> rate_sq;  // slots, 1/s^2, s^2 from the material
    double damping = 0;          // tau, s, the mean of the cubes' stiffness damping
    int flat_axis = -1;          // the axis that all particles lie across, where they do

    std::size_t bytes() const;
};

// Throws std::invalid_argument when the cubes are no body. Contact and wind act on `surface`, or on
// the outside of the cubes when it is null.
LatticeBody make_lattice(const geometry::Cubes& cubes, const LatticeOptions& options = {},
                         const geometry::TriMesh* surface = nullptr);

// The corners of cubes and their links.
Lattice corner_lattice(const geometry::Cubes& cubes);

State rest_state(const LatticeBody& body);

// The state `dt` seconds later. Throws std::invalid_argument when state or loads do not fit; any
// finite state is accepted, and what goes wrong is told in the report.
State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const LatticeOptions& options);
// With the body's own options and the step's number of substeps.
State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const StepOptions& step);

}  // namespace physics
