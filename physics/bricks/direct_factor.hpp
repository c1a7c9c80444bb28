#pragma once

// The matrix of one round of Newton's method, factored (Cholesky, front by front) and solved with
// in double precision. Each front holds the columns L11, L21 of its pivots, with
//   F11 = L11 L11^T,   L21 = F21 L11^-T,   F22 - L21 L21^T handed to the parent
// Duff, Reid. The multifrontal solution of indefinite sparse symmetric linear equations. ACM TOMS
// 9(3), 1983. A long body of n cubes takes n operations where conjugate gradients take n^3: a
// beam's condition grows by n^4. The inverse at rest (corner_factor.hpp) does not serve there, as
// what it makes of a beam that is bent is stiff in the wrong places by the same ratio.

#include "physics/bricks/brick_element.hpp"
#include "physics/bricks/dissection.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/math/eight_columns.hpp"

#include <memory>
#include <optional>
#include <span>

namespace physics {

class DirectFactor {
public:
    // Of the sum of a matrix a cube and `diagonal`: four numbers a slot, slot[corner] for each
    // corner. Corners beyond these are inner ones: nothing acts on them, their diagonal is 0, and
    // where they move is kept here. Corners that the dissection left out are held, and axes of
    // others as in `held` (K, or empty: none), whose numbers are tied to nothing. Nothing when a
    // pivot is not positive.
    static std::optional<DirectFactor> make(std::shared_ptr<const Dissection> dissection,
                                            const std::vector<BrickMatrix>& cubes,
                                            std::span<const double> diagonal,
                                            std::span<const std::uint32_t> slot,
                                            std::span<const std::uint8_t> held = {});

    // x = A^-1 b. Numbers of corners that are held stay as they are in x.
    void solve(const double* b, double* x);
    // Whether any corner is an inner one.
    bool has_inner() const { return !inner_.empty(); }
    // The same for eight right-hand sides: three rows a slot. No corner may be an inner one.
    void solve(const EightColumns& b, EightColumns& x);

private:
    struct Panel {
        Eigen::Index pivots = 0, border = 0;  // numbers, 3 a corner
        std::size_t at = 0;                   // into work_: pivots, then border
        Aligned<double> columns;              // L11 over L21
    };

    friend class DirectFactorizer;

    bool is_inner(std::uint32_t corner) const { return corner >= slot_.size(); }
    std::size_t inner_at(std::uint32_t corner) const { return 3 * (corner - slot_.size()); }
    void forward(std::uint32_t f, const double* b);
    void back(std::uint32_t f, double* x);
    void forward_eight(std::uint32_t f, const double* b);
    void back_eight(std::uint32_t f, double* x);

    std::shared_ptr<const Dissection> tree_;
    std::vector<std::uint32_t> slot_;
    std::vector<Panel> panels_;
    Aligned<double> work_;
    EightColumns eight_work_;    // rows as work_ has numbers; none before it is needed
    std::vector<double> inner_;  // 3 for each inner corner, as solve() moved it last
};

}  // namespace physics
