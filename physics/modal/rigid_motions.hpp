#pragma once

// The rigid motions of the free pieces of a model: they are known beforehand, so that the search
// for modes can leave them out exactly instead of finding them.

#include "physics/modal/stiffness_matrix.hpp"

namespace physics {

// The rigid motions that pins leave to one connected piece: orthonormal columns over its unknowns.
struct RigidMotions {
    std::vector<std::uint32_t> unknown;  // corners of the piece, into Unknowns::corner
    Eigen::MatrixXd motion;              // 3 |unknown| x (0..6), L^T times the displacement
};

// Of every piece that has any. `springs` hold material as pins do.
std::vector<RigidMotions> rigid_motions(const geometry::Cubes& cubes, const Unknowns& unknowns,
                                        const StiffnessAndMass& matrices,
                                        std::span<const HeldCube> springs = {});

// x without its parts along the piece's motions.
void take_out(const RigidMotions& piece, Eigen::Ref<Eigen::VectorXd> x);

// Motion `m` of a piece over all `rows` unknowns.
Eigen::VectorXd spread_out(const RigidMotions& piece, Eigen::Index m, Eigen::Index rows);

}  // namespace physics
