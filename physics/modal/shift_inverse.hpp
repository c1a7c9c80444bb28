#pragma once

// (D - shift I)^-1 of the D of stiffness_matrix.hpp, by one factorisation. With a shift below all
// that is sought, the lowest modes of D become its largest eigenvalues; with a shift that is
// next to nothing it also gives the displacement under a load of what moves freely.

#include "physics/bricks/direct_factor.hpp"
#include "physics/modal/rigid_motions.hpp"

#include <Eigen/SparseCholesky>

#include <optional>

namespace physics {

// What D is summed from: its factors are made cube by cube (bricks/direct_factor.hpp).
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
    Eigen::VectorXd solve(const Eigen::VectorXd& r);

private:
    std::vector<std::uint32_t> slot_;
    std::vector<double> b_, x_;  // four numbers an unknown
    std::optional<DirectFactor> fronts_;
    // Elimination in the order of the unknowns: no other is needed.
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
        columns_;
};

// On what is orthogonal to the rigid motions and to the modes found so far.
class ShiftInverse {
public:
    using Scalar = double;

    // All must outlive it. The shift is far below the lowest mode (a slender model has it at 1e-8
    // of the highest), and enough to keep the matrix definite where pieces move freely.
    ShiftInverse(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                 const ModalCubes& of);
    bool factored() const { return inverse_.factored(); }
    Eigen::Index rows() const { return size_; }
    Eigen::Index cols() const { return size_; }
    void perform_op(const double* from, double* to) const;
    void project(Eigen::Ref<Eigen::VectorXd> x) const;

    const double shift;
    Eigen::MatrixXd found;  // orthonormal modes that are known already
    mutable int solves = 0;

private:
    mutable ShiftedInverse inverse_;  // with room to work in
    const StiffnessAndMass& matrices_;
    const std::vector<RigidMotions>& rigid_;
    Eigen::Index size_;
};

}  // namespace physics
