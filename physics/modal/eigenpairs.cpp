#include "physics/modal/eigenpairs.hpp"

#include "geometry/base/random.hpp"

#include <Eigen/Eigenvalues>
#include <Spectra/SymEigsSolver.h>

#include <algorithm>
#include <numeric>

namespace physics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void sort_pairs(Eigenpairs& pairs)
{
    std::vector<Index> order(pairs.value.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
        return pairs.value[std::size_t(a)] < pairs.value[std::size_t(b)];
    });
    Eigenpairs sorted = pairs;
    for (std::size_t i = 0; i < order.size(); ++i) {
        sorted.value[i] = pairs.value[std::size_t(order[i])];
        sorted.vector.col(Index(i)) = pairs.vector.col(order[i]);
    }
    pairs = std::move(sorted);
}

}  // namespace

Eigenpairs dense_eigenpairs(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                            Index count)
{
    MatrixXd full = MatrixXd(d.stiffness).selfadjointView<Eigen::Lower>();
    for (int side = 0; side < 2; ++side) {
        for (Index j = 0; j < full.cols(); ++j) full.col(j) = d.without_root(full.col(j));
        full.transposeInPlace();
    }
    full = (0.5 * (full + full.transpose())).eval();
    // Rigid motions are moved out of the way, above everything else.
    const double top = 2 * full.cwiseAbs().rowwise().sum().maxCoeff();
    for (const auto& piece : rigid) {
        for (Index m = 0; m < piece.motion.cols(); ++m) {
            const VectorXd motion = spread_out(piece, m, d.rows());
            full += top * motion * motion.transpose();
        }
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(full);
    Eigenpairs pairs;
    pairs.vector = eigen.eigenvectors().leftCols(count);
    pairs.value.assign(eigen.eigenvalues().data(), eigen.eigenvalues().data() + count);
    return pairs;
}

Eigenpairs lanczos_eigenpairs(const StiffnessAndMass& d, Index count, ShiftInverse& inverse)
{
    Eigenpairs pairs;
    pairs.vector.resize(d.rows(), 0);
    if (!inverse.factored()) {
        pairs.converged = false;
        return pairs;
    }
    Index wanted = count;
    for (std::uint64_t round = 0; round < 16; ++round) {
        const Index krylov = std::min<Index>(d.rows(), std::max<Index>(2 * wanted + 8, 20));
        Spectra::SymEigsSolver<ShiftInverse> solver(inverse, wanted, krylov);
        VectorXd start(d.rows());
        const geometry::Random random(round);
        for (Index i = 0; i < start.size(); ++i) start[i] = random.unit(std::uint64_t(i)) - 0.5;
        inverse.project(start);
        solver.init(start.data());
        const Index got = solver.compute(Spectra::SortRule::LargestAlge, 300, 1e-12);
        if (got < wanted) pairs.converged = false;
        const VectorXd values = solver.eigenvalues();
        const MatrixXd vectors = solver.eigenvectors();
        const double highest = pairs.value.empty() ? 0 : pairs.value.back();
        Index lower = 0;
        for (Index i = 0; i < got; ++i) {
            const double value = inverse.shift + 1 / values[i];
            if (round > 0 && value >= highest * (1 - 1e-9)) continue;
            pairs.vector.conservativeResize(Eigen::NoChange, pairs.vector.cols() + 1);
            VectorXd vector = vectors.col(i);
            inverse.project(vector);
            pairs.vector.rightCols<1>() = vector.normalized();
            pairs.value.push_back(value);
            ++lower;
        }
        sort_pairs(pairs);
        inverse.found = pairs.vector;
        if (round > 0 && lower == 0) break;
        wanted = std::min<Index>({2, count, d.rows() - pairs.vector.cols() - 1});
        if (wanted < 1) break;
    }
    const Index kept = std::min(count, pairs.vector.cols());
    pairs.value.resize(std::size_t(kept));
    pairs.vector.conservativeResize(Eigen::NoChange, kept);
    pairs.solves = inverse.solves;
    return pairs;
}

}  // namespace physics
