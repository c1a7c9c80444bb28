#pragma once

// The slopes across a shell's sides that make its bending energy least, for given places: one
// symmetric, positive, sparse matrix, the same for x, y and z, as the energy is a square of them.
// It is factored front by front (dissection.hpp), each with the columns L11, L21 of its pivots.

#include "physics/bricks/dissection.hpp"
#include "physics/bricks/factor_cache.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/shell/triangle_shell.hpp"

#include <span>
#include <vector>

namespace physics {

using SideVectors = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // S rows

class SlopeFactor {
public:
    // `weight` of each triangle's bending, T, above 0. `rest` has four numbers a slot, m. Throws
    // std::invalid_argument where triangles are too thin for it.
    SlopeFactor(const TriangleShell& shell, const double* rest, std::span<const double> weight);

    // Of what pulls at the slopes to what they are, in place. `work` is room that is kept between
    // solves.
    void solve(SideVectors& sides, Aligned<double>& work) const;

private:
    struct Panel {
        std::size_t pivots = 0, border = 0;
        std::size_t columns = 0;  // into numbers_: L11 over L21
        std::size_t at = 0;       // into work, rows of four: pivots, then border
    };
    using Dense = std::vector<double>;  // border x border, by columns

    bool eliminate(std::uint32_t f, const TriangleShell& shell, std::span<const double> weight,
                   std::vector<Dense>& rests);
    void down(std::uint32_t f, const SideVectors& sides, double* work) const;
    void up(std::uint32_t f, SideVectors& sides, double* work) const;

    Dissection tree_;  // of sides, as if they were corners
    std::vector<Panel> panels_;
    Aligned<double> numbers_;
    std::size_t rows_ = 0;  // of work
};

class SlopeCache : public PreparedCache<SlopeFactor> {};

}  // namespace physics
