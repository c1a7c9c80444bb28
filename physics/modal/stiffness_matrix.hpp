#pragma once

// The stiffness K and the mass M of a model of cubes as sparse matrices over its free corners.
// Modes are the solutions of K phi = omega^2 M phi. M is that of the bricks that move
// (state/cube_mass.hpp), the same for x, y and z. Corners are numbered in the order in which a
// factorisation eliminates them (bricks/dissection.hpp).

#include "geometry/cubes/cubes.hpp"
#include "physics/body/stiffness.hpp"
#include "physics/bricks/brick_element.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/math/eight_columns.hpp"

#include <Eigen/SparseCore>

#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace physics {

// The free corners in the order in which they are eliminated.
struct Unknowns {
    std::vector<std::uint32_t> corner;  // n, of the cubes
    std::vector<std::uint32_t> at;      // K, into corner, or no_index where pinned
    std::size_t count() const { return corner.size(); }
};

// Throws std::invalid_argument when a pinned corner is none of the cubes'.
Unknowns order_unknowns(const geometry::Cubes& cubes, const std::vector<std::uint32_t>& pinned);

// Stiffness matrices of the materials that occur, each made when it is first asked for.
class CubeStiffness {
public:
    // `held` (springs, by cube) must outlive it.
    CubeStiffness(const geometry::Cubes& cubes, BrickElement element, Weighting weighting,
                  std::span<const HeldCube> held = {})
        : cubes_(cubes), element_(element_of(cubes, element)), weighting_(weighting), held_(held)
    {}

    // K of cube c, with the springs that hold it, until the next call, and the factor on it.
    std::pair<const BrickMatrix&, double> of(std::size_t c);

private:
    std::pair<const BrickMatrix&, double> material(std::size_t c);

    const geometry::Cubes& cubes_;
    BrickElement element_;
    Weighting weighting_;
    std::span<const HeldCube> held_;
    std::map<double, std::unique_ptr<BrickMatrix>> by_poisson_;
    BrickMatrix own_, sum_;
};

struct StiffnessAndMass {
    Eigen::SparseMatrix<double> stiffness;              // lower triangle of K, 3n x 3n
    Eigen::SparseMatrix<double, Eigen::RowMajor> mass;  // M, n x n, with the blocks of K

    Eigen::Index rows() const { return stiffness.rows(); }
    double largest_ratio() const;  // of the diagonals of K and M, 1/s^2
    // The lower triangle of K - shift M.
    Eigen::SparseMatrix<double> shifted(double shift) const;
    Eigen::MatrixXd times_mass(const Eigen::MatrixXd& v) const;  // M v, of 3n rows
    void times_mass(const EightColumns& v, EightColumns& to) const;
};

// Throws std::invalid_argument when masses are too far apart to be added up.
StiffnessAndMass sum_matrices(const geometry::Cubes& cubes, const Unknowns& unknowns,
                              CubeStiffness& stiffness);

}  // namespace physics
