#pragma once

// The coarse half of a multigrid preconditioner for the cubes of a body: what smoothing of the
// cubes themselves (step_multigrid.hpp) leaves over. Brandt. Multi-level adaptive solutions to
// boundary-value problems. Math. Comp. 31, 1977; for cubes: McAdams and others. Efficient
// elasticity for character skinning with contact and collisions. SIGGRAPH 2011; Dick, Georgii,
// Westermann. A real-time multigrid finite hexahedra method for elasticity simulation. 2011.
//
//   cubes at rest   restrict, in cells of 4^3   nodes   restrict, in cells of 2^3   ..   inverse
//
// Coarse matrices are Galerkin products of the matrix at rest (coarse_energy.hpp). A cycle smooths
// before and after by Chebyshev polynomials in the matrix scaled by its 6 x 6 diagonal blocks
// (Adams, Brezina, Hu, Tuminaro. Parallel multigrid smoothing. J. Comp. Phys. 188, 2003), and the
// coarsest grid has its inverse: the whole is symmetric, and positive definite. The same bytes come
// from any number of threads: every sum has one owner and one order.

#include "physics/bricks/coarse_energy.hpp"
#include "physics/bricks/coarse_transfer.hpp"
#include "physics/math/aligned_memory.hpp"

namespace physics {

// Coefficients of a Chebyshev polynomial in steps: d = by_last d + by_rest D^-1 r, x += d.
struct ChebyshevStep {
    float by_last = 0, by_rest = 0;
};
// So that the error shrinks evenly where the eigenvalues of D^-1 A are in largest / span ..
// largest.
std::vector<ChebyshevStep> chebyshev_steps(double largest, double span, int degree);

class Multigrid {
public:
    // Of the sum over cubes and D = diagonal (K, by corner), without the held axes (K, bits as in
    // Pins, or empty).
    static Multigrid make(const geometry::Cubes& cubes, const CubeMatrices& matrices,
                          std::span<const double> diagonal, std::span<const std::uint8_t> held);

    struct Work {
        struct Level {
            Aligned<float> by_cell, r, z, d, y;
        };
        std::vector<Level> levels;
    };

    // z += P A_c^-1 P^T r, about: four numbers a slot, slot[corner] for each corner.
    void correct(const float* r, float* z, const std::uint32_t* slot, CornerTurns turns,
                 Work& work) const;

    std::size_t levels() const { return levels_.size(); }
    std::size_t nodes(std::size_t level) const { return levels_[level].grid.node.size(); }
    std::size_t bytes() const;

private:
    struct Level {
        CoarseGrid grid;  // of the cells below
        IndexLists near;  // of each node, those it shares cells with
        // Of each node six columns of matrix numbers, up to a 16th: those of its near nodes in
        // order, six each.
        std::vector<std::size_t> rows;
        Aligned<float> matrix;
        std::vector<float> block_inverse;  // 36 a node
        std::vector<ChebyshevStep> smoother;
        Aligned<float> inverse;  // of the coarsest: columns of inverse_rows numbers
        std::size_t inverse_rows = 0;
    };

    static void assemble(const std::vector<CellMatrix>& energies, Level& level);
    static void finish(bool coarsest, Level& level);
    static void take_product(const Level& level, Work::Level& at);
    static void smooth(const Level& level, Work::Level& at);
    static void apply_inverse(const Level& level, Work::Level& at);
    void cycle(std::size_t l, Work& work) const;

    std::vector<geometry::Vec3i> corner_;  // of the cubes
    std::vector<Level> levels_;
};

}  // namespace physics
