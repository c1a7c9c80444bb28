#pragma once

// The stiffness of a model of cubes as one sparse matrix over its free corners, scaled by their
// masses: D = M^-1/2 K M^-1/2, whose eigenvalues are the squares of the frequencies. Corners are
// numbered in the order in which a factorisation eliminates them (bricks/dissection.hpp).

#include "geometry/cubes/cubes.hpp"
#include "physics/body/stiffness.hpp"
#include "physics/bricks/brick_element.hpp"

#include <Eigen/SparseCore>

#include <map>
#include <memory>
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
    CubeStiffness(const geometry::Cubes& cubes, BrickElement element, Weighting weighting)
        : cubes_(cubes), element_(element), weighting_(weighting)
    {}

    // K of cube c, and the factor on it.
    std::pair<const BrickMatrix&, double> of(std::size_t c);

private:
    const geometry::Cubes& cubes_;
    BrickElement element_;
    Weighting weighting_;
    std::map<double, std::unique_ptr<BrickMatrix>> by_poisson_;
};

// The lower triangle of D, 3n x 3n. `root_mass` holds sqrt(kg) for each of its rows.
Eigen::SparseMatrix<double> stiffness_by_mass(const geometry::Cubes& cubes,
                                              const Unknowns& unknowns,
                                              const Eigen::VectorXd& root_mass,
                                              CubeStiffness& stiffness);

}  // namespace physics
