#pragma once

// The energies of coarse cells in multigrid, as matrices over the motions of their nodes.
//
// A node has six numbers: a translation t and a turn w about itself, the turn times the cell's edge
// L. Between the nodes, rigid motions are blended with trilinear weights:
//   u(x) = sum_j N_j(x) (t_j + w_j x (x - x_j) / L)
// The blend of two motions that turn apart is a bend: coarse cells do not lock where trilinear ones
// do, in bars and sheets thinner than they are. (Rigid motions as the coarse space: Vanek, Mandel,
// Brezina. Algebraic multigrid by smoothed aggregation. Computing 56, 1996; blended by partitions
// of unity: Melenk, Babuska. The partition of unity finite element method. 1996.)
// A coarse matrix is the Galerkin product Q^T K Q, Q this map, summed over what the cell holds.

#include "physics/bricks/coarse_grid.hpp"
#include "physics/bricks/cube_matrices.hpp"

#include <vector>

namespace physics {

using CellMatrix = Eigen::Matrix<double, 48, 48>;  // node j's t at 6 j, w at 6 j + 3
using CellVector = Eigen::Matrix<double, 48, 1>;

// How the corner at a place (0 .. ratio) of a coarse cell moves with its nodes.
Eigen::Matrix<double, 3, 48> corner_motion(const geometry::Vec3i& place, int ratio);

// Fine cubes in a cell of ratio^3: their matrices for each place that they can have.
class CubeEnergies {
public:
    CubeEnergies(int ratio, const CubeMatrices& cubes);  // which must outlive it

    // Adds to `sum` the energy of the cubes of cell `c` and of the corners' diagonal (by corner).
    // Corners that are left out do not move.
    void add_cell(const GridView& fine, const CoarseGrid& grid, std::size_t c,
                  std::span<const double> diagonal, std::span<const std::uint8_t> held,
                  CellMatrix& sum) const;

private:
    bool add_full_cell(const GridView& fine, const CoarseGrid& grid, std::size_t c,
                       std::span<const double> diagonal, CellMatrix& sum) const;
    std::size_t cube_at(const geometry::Vec3i& place) const;
    std::size_t corner_at(const geometry::Vec3i& place) const;

    int ratio_;
    const CubeMatrices& cubes_;
    std::vector<std::array<CellMatrix, 3>> cube_;  // by place
    std::vector<CellMatrix> corner_;               // by place
    std::array<CellMatrix, 3> full_;               // sum over the places of cubes
    CellMatrix full_corners_;                      // sum over the places below ratio
};

// Adds to a coarse cell's `sum` the energy of the cell of the grid below at `place` (0 .. ratio - 1
// along each axis).
void add_cell_of_cells(const CellMatrix& energy, const geometry::Vec3i& place, int ratio,
                       CellMatrix& sum);

}  // namespace physics
