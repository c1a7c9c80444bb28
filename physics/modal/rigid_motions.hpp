#pragma once

// The rigid motions of the free pieces of a model: they are known beforehand, so that the search
// for modes can leave them out exactly instead of finding them.

#include "physics/modal/stiffness_matrix.hpp"

namespace physics {

// The rigid motions R that pins leave to one connected piece, R^T M R = I, over its unknowns.
struct RigidMotions {
    std::vector<std::uint32_t> unknown;  // corners of the piece, into Unknowns::corner
    Eigen::MatrixXd motion, weighed;     // R and M R, 3 |unknown| x (0..6)
};

// Of every piece that has any. `springs` hold material as pins do.
std::vector<RigidMotions> rigid_motions(const geometry::Cubes& cubes, const Unknowns& unknowns,
                                        const StiffnessAndMass& matrices,
                                        std::span<const HeldCube> springs = {});

// x without its parts along the piece's motions, by M: x - R R^T M x.
void take_out(const RigidMotions& piece, EightColumns& x);

// A vector over the unknowns of a piece as one over all `rows`.
Eigen::VectorXd spread_out(const RigidMotions& piece, const Eigen::VectorXd& of, Eigen::Index rows);

}  // namespace physics
