#pragma once

// Lattice shape matching: fast, unconditionally stable, and as stiff as its regions are wide.
// Rivers, James. FastLSM: fast lattice shape matching for robust real-time deformation. SIGGRAPH
// 2007. After Mueller, Heidelberger, Teschner, Gross. Meshless deformations based on shape
// matching. SIGGRAPH 2005.
//
//     at rest          where they are           where they want to go, T_r X
//
//     o---o---o           o--o----o                o---o---o
//     |   |   |          /  /     |               /   /   /
//     o---r---o         o--r---o  |              o---r---o
//     |   |   |         |   |   | o             /   /   /
//     o---o---o         o---o---o              o---o---o
//
// Particles sit on the corners of the cubes, linked along the cubes' edges. (Not on their centres:
// embedding, pins and contact speak of corners, a region is never flat or a line, and a single cube
// is a body.) With M_i = m_i / |R_i| and sums over the particles of region r,
//   c_r = (1/M_r) sum M_i x_i        A_r = sum M_i x_i (X_i - C_r)^T        R_r = rotation of A_r
//   T_r X = c_r + R_r (X - C_r)      d_i = mean over the regions of i of w_r (T_r X_i - x_i)
//   v_i <- v_i + (alpha d_i + beta (d_i - d_i before)) / dt + dt f_i / m_i ;  x_i <- x_i + dt v_i
// In every region the d sum to zero force and zero torque, whatever its weight w_r.
//
// alpha = min(1, s^2 dt^2), so that the acceleration s^2 d does not depend on the step as long as
// s dt <= 1, and s without bound is as stiff as the method gets. A long wave sees d as
// -k^2 h^2 m2 of its displacement, m2 = w (w + 1) / 3 the mean square of the places -w .. w, so the
// lattice is an elastic solid with
//   E = rho s^2 h^2 m2 and Poisson ratio 0,
// and s follows from the material; what Poisson's ratio adds is a pull to the region's volume
// (region_volume.hpp). (A rate -ln(1 - alpha) / dt, as in position-based methods, would
// keep relaxation but not inertia: frequencies would rise with 1 / sqrt(dt).) beta = 1 - exp(-c
// dt), and where a solid's volume takes more than a quarter of what steps can bear
// (region_volume.hpp) up to 0.02 at least.
//
// A plane (geometry/cubes/plane.hpp) is one layer of particles. A_r lacks the normal's direction,
// and the cross product of the other two stands in. In space its regions resist bending, at a rate
// b, and stretch with that same rate; the rest of the stretch is a membrane's (membrane.hpp). A
// region lies in its best plane, so what it sees of a surface z = (kxx x^2 + kyy y^2) / 2 + kxy x y
// (in lattice steps) is the rest, and its pull has the energy
//   U = 1/2 b^2 mean |rest|^2 = 1/8 b^2 ((m4 - m2^2) (kxx^2 + kyy^2) + 4 m2^2 kxy^2),
// m4 the mean fourth power of places, against D / 2 (kxx^2 + kyy^2 + 2 kxy^2) of a plate of D = E
// t^3 / (12 (1 - nu^2)) (what nu adds is a curvature of Gauss, which only free borders feel). So
// b^2 = s^2 (t / h)^2 m2 / (3 (1 - nu^2) (m4 - m2^2)): at w = 1, t = h and nu = 0 just s, and
// nothing is left to the membrane; but twist would be resisted 1 / phi times too much,
//   phi = (m4 - m2^2) / (2 m2^2), a quarter at w = 1 and two fifths for wide regions.
// So a region may stay bent like a saddle, but for phi of it. With psi = x y - a - b x - c y, the
// part of x y that is no rigid motion of the rest shape (sums of M psi, M psi x and M psi y are 0),
//   P_r = sum M_i psi_i x_i        T_r X_i <- T_r X_i + (1 - phi) / B P_r psi_i,  B = sum M psi^2.
// That is the force of -(1 - phi) |P_r|^2 / 2B, a potential that turns with the body and is never
// more than what the region's rest costs: no force, no torque, no energy from nothing. P_r needs
// one moment more a region, that of x y. A membrane's steps are as long as E <= rho h^2 / (4 dt^2)
// allows. Or the plane moves in its plane only, with rate s and rotations in closed form.
//
// A held corner of a plane stands for its mirror image behind the rim too, and weighs twice: then a
// plate that is held from x = 0 on bends as if clamped there (at w = 1 exactly; at 0.1, 0.3 and 0.5
// h before it with w = 2, 3 and 4, where single weights clamp it at 1.1, 1.7 and 2.3 h before).
//
// Plastic flow (Mueller et al.): where a region's strain beyond its rotation, E = R^T A B^-1 S^-1 -
// I with B = sum M X X^T, is above the yield strain, its rest shape S grows towards it, and T_r X =
// c_r + R_r S_r (X - C_r). Fracture: links longer than they can bear are gone, for good; the
// regions around find out.

#include "physics/lattice/lattice_body.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/step_options.hpp"

namespace physics {

// Throws std::invalid_argument when the cubes are no body. Contact and wind act on `surface`, or on
// the outside of the cubes when it is null.
LatticeBody make_lattice(const geometry::Cubes& cubes, const LatticeOptions& options = {},
                         const geometry::TriMesh* surface = nullptr);

// The state `dt` seconds later. Throws std::invalid_argument when state or loads do not fit; any
// finite state is accepted, and what goes wrong is told in the report. What shapes the body (half
// width, weighting, plane, plastic.yield, tear, contact.on, contact.self and with it
// contact.distance) is as it was made.
State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const LatticeOptions& options);
// How many substeps a frame of `dt` seconds takes at least for the body to be as stiff as its
// material.
int least_substeps(const LatticeBody& body, double dt);
// ... and to keep its volume as its material does; 1,000 at most.
int enough_substeps(const LatticeBody& body, double dt);
// With the body's own options and the step's number of substeps; where that is 0, with as many as
// are enough.
State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const StepOptions& step);

}  // namespace physics
