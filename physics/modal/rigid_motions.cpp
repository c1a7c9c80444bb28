#include "physics/modal/rigid_motions.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "physics/state/hold_matter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>

namespace physics {
namespace {

using geometry::no_index;

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::Vec3;

// Displacement of a corner at r (in reaches from the centre) by the six unit motions, rotations
// about the centre.
Eigen::Matrix<double, 3, 6> unit_motions(const Vec3& r)
{
    Eigen::Matrix<double, 3, 6> m;
    m.leftCols<3>().setIdentity();
    for (int axis = 0; axis < 3; ++axis) m.col(3 + axis) = Vec3::Unit(axis).cross(r);
    return m;
}

// What springs resist unit motions of, `motion_at` those of the corners of their cube, as a share
// of what they resist of a shift.
template <class MotionAt> MatrixXd held_motions(const HeldCube& spring, const MotionAt& motion_at)
{
    MatrixXd sum = MatrixXd::Zero(6, 6);
    double whole = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < 8; ++b) {
            const double k = stiffness_at(spring, a, b);
            sum += k * motion_at(a).transpose() * motion_at(b);
            whole += k;
        }
    }
    return sum / whole;
}

// The rows of a piece's unknowns.
MatrixXd rows_of(const MatrixXd& all, const RigidMotions& piece)
{
    MatrixXd out(Index(3 * piece.unknown.size()), all.cols());
    for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
        out.middleRows<3>(Index(3 * i)) = all.middleRows<3>(Index(3 * piece.unknown[i]));
    }
    return out;
}

// Makes the motions of each piece orthonormal by M, from those over all corners.
void make_orthonormal(const StiffnessAndMass& matrices, MatrixXd& motions,
                      std::vector<RigidMotions>& all)
{
    // Twice, so that what rounding leaves is taken out too.
    for (int pass = 0; pass < 2; ++pass) {
        const MatrixXd weighed = matrices.times_mass(motions);
        for (RigidMotions& piece : all) {
            const Index free = piece.motion.cols();
            piece.weighed = rows_of(weighed, piece).leftCols(free);
            piece.motion = rows_of(motions, piece).leftCols(free);
            const Eigen::LLT<MatrixXd> root(piece.motion.transpose() * piece.weighed);
            for (MatrixXd* m : {&piece.motion, &piece.weighed}) {
                root.matrixU().solveInPlace<Eigen::OnTheRight>(*m);
            }
            for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
                motions.block(Index(3 * piece.unknown[i]), 0, 3, free) =
                    piece.motion.middleRows<3>(Index(3 * i));
            }
        }
    }
}

}  // namespace

std::vector<RigidMotions> rigid_motions(const geometry::Cubes& cubes, const Unknowns& unknowns,
                                        const StiffnessAndMass& matrices,
                                        std::span<const HeldCube> springs)
{
    geometry::Sets sets(cubes.corner_count());
    for (const auto& corners : cubes.corners) {
        for (const auto a : corners) sets.join(a, corners[0]);
    }
    std::map<std::uint32_t, std::vector<std::uint32_t>> pieces;  // corners by smallest corner
    for (std::uint32_t i = 0; i < cubes.corner_count(); ++i) pieces[sets.root(i)].push_back(i);

    std::vector<RigidMotions> all;
    MatrixXd motions = MatrixXd::Zero(matrices.rows(), 6);  // of all pieces: they share no corner
    for (const auto& [smallest, corners] : pieces) {
        RigidMotions piece;
        Vec3 centre = Vec3::Zero();
        double reach = 0;
        for (const auto i : corners) centre += cubes.corner_position(i) / double(corners.size());
        for (const auto i : corners) {
            reach = std::max(reach, (cubes.corner_position(i) - centre).norm());
            if (unknowns.at[i] != no_index) piece.unknown.push_back(unknowns.at[i]);
        }
        const auto motion_at = [&](std::uint32_t corner) {
            return unit_motions((cubes.corner_position(corner) - centre) / reach);
        };
        MatrixXd held = MatrixXd::Zero(6, 6);  // of any size, to share the solver below
        for (const auto i : corners) {
            if (unknowns.at[i] == no_index) held += motion_at(i).transpose() * motion_at(i);
        }
        for (const HeldCube& spring : springs) {
            const auto& at = cubes.corners[spring.cube];
            if (sets.root(at[0]) != sets.root(smallest)) continue;
            held += held_motions(spring, [&](std::size_t a) { return motion_at(at[a]); });
        }
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(held);
        const double h_over_reach = cubes.size / reach;
        Index free = 0;  // motions that leave every pin where it is
        while (free < 6 && eigen.eigenvalues()[free] < 1e-9 * h_over_reach * h_over_reach) ++free;
        if (free == 0 || piece.unknown.empty()) continue;
        for (const auto i : piece.unknown) {
            motions.block(Index(3 * i), 0, 3, free) =
                motion_at(unknowns.corner[i]) * eigen.eigenvectors().leftCols(free);
        }
        piece.motion.resize(Index(3 * piece.unknown.size()), free);
        all.push_back(std::move(piece));
    }
    make_orthonormal(matrices, motions, all);
    return all;
}

void take_out(const RigidMotions& piece, EightColumns& x)
{
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>;
    Rows part(piece.motion.rows(), 8);
    constexpr std::size_t wide = 3 * eight;
    for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
        std::copy_n(&x[wide * piece.unknown[i]], wide, part.data() + wide * i);
    }
    const MatrixXd along = piece.weighed.transpose() * part;
    part.noalias() -= piece.motion * along;
    for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
        std::copy_n(part.data() + wide * i, wide, &x[wide * piece.unknown[i]]);
    }
}

VectorXd spread_out(const RigidMotions& piece, const VectorXd& of, Index rows)
{
    VectorXd out = VectorXd::Zero(rows);
    for (std::size_t i = 0; i < piece.unknown.size(); ++i) {
        out.segment<3>(Index(3 * piece.unknown[i])) = of.segment<3>(Index(3 * i));
    }
    return out;
}

}  // namespace physics
