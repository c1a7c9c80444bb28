#pragma once

// A mass-spring lattice on the corners of cubes, stepped implicitly.
//
// Each cube has springs along its 12 edges (stretch) and the 12 diagonals of its faces (shear), all
// linear in their length l against the rest length L:
//   f = k (l - L) n        df/dx = k (n n^T + max(0, 1 - L / l) (I - n n^T))
// the max keeps the matrix positive semi-definite (Choi, Ko. Stable but responsive cloth. SIGGRAPH
// 2002). With edges k_e and diagonals k_d a full lattice has the moduli
//   C11 = (k_e + 2 k_d) / h    C12 = C44 = k_d / h
// so it is isotropic for k_e = k_d = k alone, where E = 5/2 k / h and nu = 1/4. That is what is
// used: k = 2/5 E h for a full cube and its fill of it else; every cube adds a quarter of k to each
// of its edges and half of k to each diagonal, so that a bar of any section stretches by exactly E
// and thins by exactly 1/4. What central forces cannot do: any other Poisson ratio (it is ignored),
// and thin bodies that bend rightly (all their stiffness sits at their surface: a beam one cube
// thick is up to three times too stiff). Nor can springs tell a shape from its mirror image.
// Springs over two cubes in a row resist bending; a share of the edges' stiffness is moved to them,
// which leaves E as it is.

#include "physics/body/corner_body.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"
#include "physics/state/step_options.hpp"

#include <vector>

namespace physics {

struct SpringOptions {
    double bending = 0.1;  // share of the edges' stiffness, 0 <= bending < 1
    PartContactOptions contact = {.on = false};
};

struct Spring {
    std::uint32_t a = 0, b = 0;  // corners
    double length = 0;           // m, at rest
    double stiffness = 0;        // N/m
    double damping = 0;          // N s/m, along it
};

struct SpringsBody {
    CornerBody base;  // slots are corners
    std::vector<Spring> springs;
    std::vector<std::uint32_t> end_at;  // K + 1, into end
    std::vector<std::uint32_t> end;     // 2 * spring, + 1 at its b, of each corner in turn
    CornerRuns cubes;                   // C, corners of each

    std::size_t bytes() const;
};

// Throws std::invalid_argument when the cubes are no body.
SpringsBody make_springs(const BodyModels& models, const SpringOptions& options = {});

// Of one model. Contact and wind act on `surface`, or on the outside of the cubes when it is null.
SpringsBody make_springs(const geometry::Cubes& cubes, const SpringOptions& options = {},
                         const geometry::TriMesh* surface = nullptr);

State rest_state(const SpringsBody& body);

// The state dt seconds later, as advance() of BricksBody, with the same warnings. Springs give no
// stress.
State advance(const SpringsBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options = {});

// The forces of the springs on corners at x. N, K.
std::vector<Vec3> spring_forces(const SpringsBody& body, const std::vector<Vec3>& x);

}  // namespace physics
