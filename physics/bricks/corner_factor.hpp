#pragma once

// The stiffness of cubes at rest, factored once (Cholesky, front by front) and solved with in
// single precision: the preconditioner of every step in a stiff body. It factors A + D, A the sum
// over the cubes and D a diagonal, mostly masses. With the pivots' block F11 of a front, W = F21
// F11^-1 and the Schur complement F22 - W F12 handed to the parent,
//   forward, children first:   b2 -= W b1
//   back, parents first:       x1 = F11^-1 b1 - W^T x2
// Both are dense products that read each number once; fronts of different branches run at a time.

#include "physics/bricks/cube_matrices.hpp"
#include "physics/bricks/dissection.hpp"
#include "physics/math/aligned_memory.hpp"

#include <optional>
#include <span>

namespace physics {

class CornerFactor {
public:
    // Of the sum over cubes and D = diagonal (K, by corner). Corners that the dissection left out
    // are held. `held` are axes of others (K, or empty: none): their numbers are tied to nothing.
    // Nothing when a pivot is not positive.
    static std::optional<CornerFactor> make(Dissection dissection, const CubeMatrices& cubes,
                                            const std::vector<double>& diagonal,
                                            std::span<const std::uint8_t> held = {});

    // x = (A + D)^-1 b: four numbers a slot, slot[corner] for each corner. Numbers of corners that
    // are held stay as they are in x. `work` is room that is kept between solves.
    void solve(const float* b, float* x, const std::uint32_t* slot, Aligned<float>& work) const;

    double entries() const { return tree_.entries; }  // 3 x 3 blocks
    std::size_t bytes() const;

private:
    struct Block {
        std::size_t pivots = 0;               // numbers, 3 a corner
        std::size_t rows = 0, border = 0;     // numbers of pivots and border, up to a 16th
        std::size_t inverse = 0, across = 0;  // into numbers_: F11^-1 and -W, by columns
        std::size_t at = 0;                   // into work: pivots, then border
    };

    friend class Factorizer;

    void forward(std::uint32_t f, const float* b, const std::uint32_t* slot, float* work) const;
    void back(std::uint32_t f, float* x, const std::uint32_t* slot, float* work) const;

    Dissection tree_;
    std::vector<Block> blocks_;
    Aligned<float> numbers_;
    std::size_t work_ = 0;
};

}  // namespace physics
