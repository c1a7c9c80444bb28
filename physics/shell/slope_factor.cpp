#include "physics/shell/slope_factor.hpp"

#include <Eigen/SparseCholesky>

#include <stdexcept>

namespace physics {

struct SlopeFactor::Cholesky {
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> llt;
};

SlopeFactor::SlopeFactor(const TriangleShell& shell, std::span<const double> weight)
    : factor_(std::make_unique<Cholesky>())
{
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(9 * shell.triangle.size());
    for (std::size_t t = 0; t < shell.triangle.size(); ++t) {
        const ShellTriangle& own = shell.triangle[t];
        const Eigen::Matrix3d k = weight[t] * own.by_slope.transpose() * own.plate * own.by_slope;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                entries.emplace_back(static_cast<int>(own.side[i]), static_cast<int>(own.side[j]),
                                     k(Eigen::Index(i), Eigen::Index(j)));
            }
        }
    }
    const auto n = static_cast<Eigen::Index>(shell.side.size());
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor_->llt.compute(matrix);
    if (factor_->llt.info() != Eigen::Success) {
        throw std::invalid_argument("method shell: the triangles are too thin to bend: expected "
                                    "sides that are more alike. Remesh the surface");
    }
}

SlopeFactor::~SlopeFactor() = default;

void SlopeFactor::solve(SideVectors& sides) const
{
    const SideVectors pulled = sides;
    sides = factor_->llt.solve(pulled);
}

}  // namespace physics
