#pragma once

// The slopes across a shell's sides that make its bending energy least, for given places: one
// symmetric, positive, sparse matrix, the same for x, y and z, as the energy is a square of them.

#include "physics/bricks/factor_cache.hpp"
#include "physics/shell/triangle_shell.hpp"

#include <memory>
#include <span>
#include <vector>

namespace physics {

using SideVectors = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // S rows

class SlopeFactor {
public:
    // `weight` of each triangle's bending, T, above 0.
    SlopeFactor(const TriangleShell& shell, std::span<const double> weight);
    ~SlopeFactor();

    // Of what pulls at the slopes to what they are, in place.
    void solve(SideVectors& sides) const;

private:
    struct Cholesky;
    std::unique_ptr<Cholesky> factor_;
};

class SlopeCache : public PreparedCache<SlopeFactor> {};

}  // namespace physics
