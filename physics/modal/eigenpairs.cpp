#include "physics/modal/eigenpairs.hpp"

#include "geometry/base/random.hpp"
#include "geometry/base/stop.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace physics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index wide = Index(eight);

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

// A basis V, V^T M V = I, in blocks of eight columns, and what the inverse, called S, is on it:
//
//     S M V = V product + W next E^T        E: the last eight columns of the identity
//
// with a block W that continues the basis. product is symmetric.
struct Krylov {
    std::vector<EightColumns> basis;  // with W as the last
    MatrixXd product;
    Eights next;
    std::uint64_t random = 0;  // blocks of random numbers taken
    EightColumns weighed;      // M W

    Index columns() const { return product.rows(); }
};

void fill_randomly(Krylov& krylov, const Eights& share, EightColumns& x)
{
    const geometry::Random random(krylov.random++);
    EightColumns noise(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) noise[i] = random.unit(i) - 0.5;
    subtract_times(noise, -share, x);
}

// x <- x by
void multiply(EightColumns& x, const Eights& by)
{
    EightColumns out(x.size(), 0);
    subtract_times(x, -by, out);
    x = std::move(out);
}

// Makes a block orthonormal by M, and orthogonal to the basis, of which it had `along`: before, the
// block was V along + the block now times the matrix that is returned. Directions that are but
// rounding become random ones. The dots of the columns tell sizes down to 1e-8 of the largest:
// what is smaller is enlarged by less than it needs, and told by the next pass. After three passes
// nothing is smaller than what can be told.
Eights make_orthonormal(Krylov& krylov, const ShiftInverse& inverse, EightColumns& x,
                        MatrixXd& along)
{
    Eights before = Eights::Identity();
    along = MatrixXd::Zero(wide * Index(krylov.basis.size()), wide);
    inverse.weigh(x, krylov.weighed);
    const double scale = transposed_times(x, krylov.weighed).trace();
    constexpr int most_passes = 10;
    for (int pass = 0, passes = 2; pass < passes; ++pass) {
        for (std::size_t k = 0; k < krylov.basis.size(); ++k) {
            const Eights part = transposed_times(krylov.basis[k], krylov.weighed);
            subtract_times(krylov.basis[k], part, x);
            along.middleRows<wide>(wide * Index(k)) += part * before;
        }
        inverse.project(x);
        inverse.weigh(x, krylov.weighed);
        const Eights dots = transposed_times(x, krylov.weighed);
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> eigen(dots);
        const double least = std::max(1e-15 * eigen.eigenvalues()[wide - 1], 1e-300);
        Eights unit = eigen.eigenvectors(), root = unit.transpose(), lost = Eights::Zero();
        for (Index i = 0; i < wide; ++i) {
            const double size = std::sqrt(std::max(least, eigen.eigenvalues()[i]));
            unit.col(i) /= size;
            root.row(i) *= size;
        }
        before = root * before;
        for (Index i = 0; i < wide; ++i) {
            if (pass > 2 || before.row(i).squaredNorm() > 1e-28 * scale) continue;
            unit.col(i).setZero(), before.row(i).setZero();
            lost(i, i) = 1;
        }
        multiply(x, unit);
        multiply(krylov.weighed, unit);
        if (lost.trace() > 0) {
            fill_randomly(krylov, lost, x);
            inverse.weigh(x, krylov.weighed);
            passes = pass + 3;
        } else if ((dots - Eights::Identity()).cwiseAbs().maxCoeff() > 1e-8) {
            passes = std::min(std::max(passes, pass + 2), most_passes);
        }
    }
    return before;
}

// Multiplies the last block, and continues the basis.
void extend(Krylov& krylov, ShiftInverse& inverse)
{
    EightColumns x;
    inverse.apply(krylov.weighed, x);
    MatrixXd along;
    krylov.next = make_orthonormal(krylov, inverse, x, along);
    const Index before = krylov.columns(), now = before + wide;
    krylov.product.conservativeResize(now, now);
    krylov.product.rightCols<wide>() = along;
    krylov.product.bottomLeftCorner(wide, before) = along.topRows(before).transpose();
    krylov.basis.push_back(std::move(x));
}

// V times the combinations, by blocks of eight columns.
std::vector<EightColumns> combined(const Krylov& krylov, const MatrixXd& combinations)
{
    std::vector<EightColumns> out;
    for (Index from = 0; from < combinations.cols(); from += wide) {
        const Index n = std::min(wide, combinations.cols() - from);
        EightColumns& block = out.emplace_back(krylov.basis.front().size(), 0.0);
        for (Index k = 0; k * wide < combinations.rows(); ++k) {
            Eights part = Eights::Zero();
            part.leftCols(n) = -combinations.block(wide * k, from, wide, n);
            subtract_times(krylov.basis[std::size_t(k)], part, block);
        }
    }
    return out;
}

struct Ritz {
    VectorXd value;       // descending
    MatrixXd vector;      // by columns, combinations of the basis
    Index converged = 0;  // the first so many are
};

Ritz ritz_pairs(const Krylov& krylov, double tolerance)
{
    const MatrixXd product = 0.5 * (krylov.product + krylov.product.transpose());
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(product);
    Ritz out{eigen.eigenvalues().reverse(), eigen.eigenvectors().rowwise().reverse()};
    while (out.converged < out.value.size()) {
        const VectorXd left = krylov.next * out.vector.col(out.converged).tail<wide>();
        if (!(left.norm() <= tolerance * out.value[out.converged])) break;
        ++out.converged;
    }
    return out;
}

// Keeps the best so many columns, and the block that continues the basis.
void restart(Krylov& krylov, const Ritz& ritz, Index keep)
{
    std::vector<EightColumns> basis = combined(krylov, ritz.vector.leftCols(keep));
    basis.push_back(std::move(krylov.basis.back()));
    krylov.basis = std::move(basis);
    krylov.product = ritz.value.head(keep).asDiagonal();
}

// The largest `count` eigenvalues of S M and their vectors, as those of K and M.
Eigenpairs largest(Index count, ShiftInverse& inverse, std::uint64_t seed)
{
    constexpr double tolerance = 1e-10;
    constexpr int most_steps = 2000;
    const Index most = std::max<Index>(wide, inverse.dimensions() / wide * wide);
    const Index room = std::min<Index>(most, (2 * count + 160) / wide * wide);
    const Index kept = std::min<Index>((count + 23) / wide * wide, room - wide);
    Krylov krylov;
    krylov.random = seed << 32;
    EightColumns start(std::size_t(inverse.rows()) * eight, 0.0);
    fill_randomly(krylov, Eights::Identity(), start);
    inverse.project(start);
    MatrixXd along;
    make_orthonormal(krylov, inverse, start, along);
    krylov.basis.push_back(std::move(start));
    Ritz ritz;
    Index ask_at = std::min(most, count + wide);
    for (int step = 0; step < most_steps; ++step) {
        extend(krylov, inverse);
        const Index columns = krylov.columns();
        if (columns < ask_at && columns < room) continue;
        geometry::stop_if_asked();
        ritz = ritz_pairs(krylov, tolerance);
        if (ritz.converged >= count || columns >= most) break;
        ask_at = columns + columns / 10;
        if (columns >= room && step + 1 < most_steps) {
            restart(krylov, ritz, kept);
            ask_at = kept + wide;
        }
    }
    Eigenpairs pairs;
    const Index got = std::min(ritz.converged, count);
    pairs.converged = got == count;
    pairs.vector.resize(inverse.rows(), got);
    const auto vectors = combined(krylov, ritz.vector.leftCols(got));
    for (Index j = 0; j < got; ++j) {
        const EightColumns& block = vectors[std::size_t(j / wide)];
        for (Index i = 0; i < inverse.rows(); ++i) {
            pairs.vector(i, j) = block[std::size_t(wide * i + j % wide)];
        }
        pairs.value.push_back(inverse.shift + 1 / ritz.value[j]);
    }
    return pairs;
}

// Whether an eigenvalue has as many copies as one block can find, so that there may be more.
bool may_be_missing(const std::vector<double>& ascending, double shift)
{
    for (std::size_t i = 0; i + eight <= ascending.size(); ++i) {
        if (ascending[i + eight - 1] - shift <= (ascending[i] - shift) * (1 + 1e-6)) return true;
    }
    return false;
}

}  // namespace

Eigenpairs dense_eigenpairs(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                            Index count)
{
    MatrixXd full = MatrixXd(d.stiffness).selfadjointView<Eigen::Lower>();
    const MatrixXd mass = d.times_mass(MatrixXd(MatrixXd::Identity(d.rows(), d.rows())));
    // Rigid motions are moved out of the way, above everything else.
    const double top = 100 * d.largest_ratio();
    for (const auto& piece : rigid) {
        for (Index m = 0; m < piece.motion.cols(); ++m) {
            const VectorXd weighed = spread_out(piece, piece.weighed.col(m), d.rows());
            full += top * weighed * weighed.transpose();
        }
    }
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(full, mass);
    Eigenpairs pairs;
    pairs.vector = eigen.eigenvectors().leftCols(count);
    pairs.value.assign(eigen.eigenvalues().data(), eigen.eigenvalues().data() + count);
    return pairs;
}

Eigenpairs lanczos_eigenpairs(Index count, ShiftInverse& inverse)
{
    Eigenpairs pairs;
    pairs.vector.resize(inverse.rows(), 0);
    if (!inverse.factored()) {
        pairs.converged = false;
        return pairs;
    }
    Index wanted = count;
    bool all = false;
    for (std::uint64_t round = 0; round < 64 && !all && wanted > 0; ++round) {
        const Eigenpairs more = largest(wanted, inverse, round);
        pairs.converged = pairs.converged && more.converged;
        const std::size_t known = std::min(std::size_t(count), pairs.value.size());
        const double highest = known > 0 ? pairs.value[known - 1] : 0;
        bool lower = false;
        for (std::size_t i = 0; i < more.value.size(); ++i) {
            if (round > 0 && more.value[i] >= highest * (1 - 1e-9)) continue;
            pairs.vector.conservativeResize(Eigen::NoChange, pairs.vector.cols() + 1);
            pairs.vector.rightCols<1>() = more.vector.col(Index(i));
            pairs.value.push_back(more.value[i]);
            lower = true;
        }
        sort_pairs(pairs);
        inverse.leave_out(pairs.vector);
        all = (round > 0 && !lower) || !may_be_missing(pairs.value, inverse.shift);
        wanted = std::min<Index>({wide, count, inverse.dimensions() - 1});
    }
    pairs.converged = pairs.converged && (all || wanted < 1);
    const Index kept = std::min(count, pairs.vector.cols());
    pairs.value.resize(std::size_t(kept));
    pairs.vector.conservativeResize(Eigen::NoChange, kept);
    return pairs;
}

}  // namespace physics
