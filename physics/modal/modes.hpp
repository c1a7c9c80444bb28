#pragma once

// Vibration modes of a model of cubes: the lowest solutions of K phi = omega^2 M phi, with K summed
// from brick elements and M the mass of bricks (state/cube_mass.hpp). Rigid motions of free pieces
// have omega = 0; they are known beforehand and left out of the search.
//
//   stiffness_matrix -> rigid_motions -> eigenpairs -> modes -> vibrate (a mesh that swings in
//   them)

#include "geometry/cubes/cubes.hpp"
#include "physics/body/stiffness.hpp"
#include "physics/bricks/brick_element.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <span>

namespace physics {

struct ModeSettings {
    int count = 20;
    bool keep_rigid = false;  // list the rigid motions too, first, with omega = 0
    Weighting weighting = Weighting::filled;
    BrickElement element = BrickElement::incompatible;
};

// k modes in ascending order, phi^T M phi = 1.
struct Modes {
    std::vector<double> omega_sq;          // k, rad^2/s^2; exactly 0 for rigid motions
    std::vector<double> damping;           // k, 1/s, phi^T C phi of the cubes' Rayleigh damping
    std::vector<std::vector<Vec3>> shape;  // k x K, kg^-1/2, zero at pinned corners
    int rigid = 0;                         // how many of them are rigid motions
    int rigid_left_out = 0;
    Report report;  // residual: the largest |K phi - omega^2 M phi| / |K phi|
};

// `pinned` are corners that do not move, sorted; `held` are springs that hold material, by cube,
// along all axes. Throws std::invalid_argument when there are no
// cubes, nothing is free, a free corner has no mass, or fewer than `count` modes exist.
Modes lowest_modes(const geometry::Cubes& cubes, const std::vector<std::uint32_t>& pinned,
                   const ModeSettings& settings, std::span<const HeldCube> held = {});

}  // namespace physics
