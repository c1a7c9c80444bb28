#include "physics/modal/eigenpairs.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/random.hpp"
#include "geometry/base/stop.hpp"
#include "physics/bricks/direct_factor.hpp"
#include "physics/state/cube_mass.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <Spectra/SymEigsSolver.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

namespace physics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using SparseMatrix = Eigen::SparseMatrix<double>;

// (K - shift M)^-1, by fronts; where rounding makes a pivot of that negative, by columns.
class ShiftedInverse {
public:
    ShiftedInverse(const StiffnessAndMass& d, double shift, const ModalCubes& of)
        : slot_(of.unknowns.at.begin(), of.unknowns.at.end()), b_(four(d)), x_(four(d))
    {
        std::vector<char> pinned(slot_.size(), 0);
        for (std::size_t k = 0; k < slot_.size(); ++k) {
            if (slot_[k] == geometry::no_index) pinned[k] = 1;
        }
        auto tree = std::make_shared<const Dissection>(
            dissect(of.cubes, pinned, std::numeric_limits<double>::infinity()));
        // Pinned corners are read and written nowhere.
        const std::vector<double> nothing(four(d), 0.0);
        fronts_ = DirectFactor::make(std::move(tree), shifted_cubes(shift, of), nothing, slot_);
        if (!fronts_) columns_.compute(d.shifted(shift));
    }

    bool factored() const { return fronts_ || columns_.info() == Eigen::Success; }

    VectorXd solve(const VectorXd& r)
    {
        if (!fronts_) return columns_.solve(r);
        const std::size_t n = b_.size() / 4;
        for (std::size_t i = 0; i < n; ++i) std::copy_n(r.data() + 3 * i, 3, b_.data() + 4 * i);
        fronts_->solve(b_.data(), x_.data());
        VectorXd out(r.size());
        for (std::size_t i = 0; i < n; ++i) std::copy_n(x_.data() + 4 * i, 3, out.data() + 3 * i);
        return out;
    }

private:
    static std::size_t four(const StiffnessAndMass& d) { return std::size_t(d.rows()) / 3 * 4; }

    static std::vector<BrickMatrix> shifted_cubes(double shift, const ModalCubes& of)
    {
        const CubeMass mass = cube_mass_matrix();
        std::vector<BrickMatrix> matrices(of.cubes.count());
        for (std::size_t c = 0; c < matrices.size(); ++c) {
            const auto [k, factor] = of.stiffness.of(c);
            matrices[c] = factor * k;
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = 0; b < 8; ++b) {
                    const double m = shift * of.cubes.mass[c] * mass[a][b];
                    for (std::size_t j = 0; j < 3; ++j) {
                        matrices[c](Index(3 * a + j), Index(3 * b + j)) -= m;
                    }
                }
            }
        }
        return matrices;
    }

    std::vector<std::uint32_t> slot_;
    std::vector<double> b_, x_;  // four numbers an unknown
    std::optional<DirectFactor> fronts_;
    // Elimination in the order of the unknowns: no other is needed.
    Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> columns_;
};

// (D - shift I)^-1 on what is orthogonal to the rigid motions and to the modes found so far: the
// lowest modes of D become its largest eigenvalues.
class ShiftInverse {
public:
    using Scalar = double;

    ShiftInverse(const StiffnessAndMass& d, double shift, const std::vector<RigidMotions>& rigid,
                 const ModalCubes& of)
        : inverse_(d, shift, of), matrices_(d), rigid_(rigid), size_(d.rows())
    {}
    bool factored() const { return inverse_.factored(); }
    Index rows() const { return size_; }
    Index cols() const { return size_; }
    void perform_op(const double* from, double* to) const
    {
        geometry::stop_if_asked();
        const Eigen::Map<const VectorXd> x(from, size_);
        Eigen::Map<VectorXd> y(to, size_);
        VectorXd work = x;
        project(work);
        y = matrices_.times_root_transposed(inverse_.solve(matrices_.times_root(work)));
        project(y);
        ++solves;
    }
    void project(Eigen::Ref<VectorXd> x) const
    {
        for (const auto& piece : rigid_) take_out(piece, x);
        if (found.cols() > 0) x -= found * (found.transpose() * x);
    }

    MatrixXd found;  // orthonormal modes that are known already
    mutable int solves = 0;

private:
    mutable ShiftedInverse inverse_;  // with room to work in
    const StiffnessAndMass& matrices_;
    const std::vector<RigidMotions>& rigid_;
    Index size_;
};

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

Eigenpairs lanczos_eigenpairs(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                              Index count, const ModalCubes& of)
{
    // Far below the lowest mode (a slender model has it at 1e-8 of the highest), and enough to keep
    // the matrix definite where pieces move freely.
    const double shift = -1e-12 * d.largest_ratio();
    ShiftInverse inverse(d, shift, rigid, of);
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
            const double value = shift + 1 / values[i];
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
