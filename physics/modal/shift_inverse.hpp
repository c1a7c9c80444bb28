#pragma once

// (K - shift M)^-1 M by one factorisation, K and M of stiffness_matrix.hpp. With a shift below all
// that is sought, the lowest modes are those of its largest eigenvalues; with a shift that is next
// to nothing it also gives the displacement of what moves freely under a load.

#include "physics/bricks/direct_factor.hpp"
#include "physics/modal/rigid_motions.hpp"

#include <Eigen/SparseCholesky>

#include <optional>

namespace physics {

// What K and M are summed from: the factors are made cube by cube (bricks/direct_factor.hpp).
struct ModalCubes {
    const geometry::Cubes& cubes;
    const Unknowns& unknowns;
    CubeStiffness& stiffness;
};

// (K - shift M)^-1, by fronts; where rounding makes a pivot of that negative, by columns.
class ShiftedInverse {
public:
    ShiftedInverse(const StiffnessAndMass& d, double shift, const ModalCubes& of);

    bool factored() const { return fronts_ || columns_.info() == Eigen::Success; }
    void solve(const EightColumns& r, EightColumns& x);

private:
    std::optional<DirectFactor> fronts_;
    // Elimination in the order of the unknowns: no other is needed.
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
        columns_;
};

// On what is orthogonal by M to the rigid motions and to the modes found so far.
class ShiftInverse {
public:
    // All must outlive it. The shift is far below the lowest mode (a slender model has it at 1e-8
    // of the highest), and enough to keep the matrix definite where pieces move freely.
    ShiftInverse(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                 const ModalCubes& of);
    bool factored() const { return inverse_.factored(); }
    Eigen::Index rows() const { return matrices_.rows(); }
    // How many dimensions are left beside rigid motions and modes found.
    Eigen::Index dimensions() const;
    // The displacements (K - shift M)^-1 load.
    void apply(const EightColumns& load, EightColumns& x);
    void weigh(const EightColumns& x, EightColumns& to) const { matrices_.times_mass(x, to); }
    void project(EightColumns& x) const;
    // Modes are known: columns phi with phi^T M phi = I.
    void leave_out(const Eigen::MatrixXd& modes);

    const double shift;
    int solves = 0;  // right-hand sides

private:
    ShiftedInverse inverse_;
    const StiffnessAndMass& matrices_;
    const std::vector<RigidMotions>& rigid_;
    Eigen::MatrixXd found_, weighed_;
};

}  // namespace physics
