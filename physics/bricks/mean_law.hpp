#pragma once

// Another law for the mean deformation gradient of each brick, in place of the corotated one of
// brick_kernels.hpp: what it adds to that, its difference, in energy, forces and derivative. The
// other modes of a cube, bending, twist and hourglass, stay corotated, as an element with one point
// has hourglass control: a cube that is stretched evenly follows the law exactly, and a body of
// many cubes tends to it.
//
// With F = C / (4 h) of the monomials x, y, z and the volume V = h^3 times its share of stiffness,
// a brick has V W(F) in place of V (mu |S - I|^2 + lambda/2 tr(S - I)^2), S = R^T F.

#include "physics/bricks/brick_kernels.hpp"
#include "physics/bricks/bricks_body.hpp"

namespace physics {

class MeanLaw {
public:
    explicit MeanLaw(const BricksBody& body);  // which must outlive it

    bool on() const { return body_.law != BrickLaw::corotated; }
    // Of evaluate() from here on: whether it keeps all of the derivative as well.
    void keep_whole();

    // All of the derivative, or what of it is never negative.
    enum class Part { positive, whole };

    // What corotate() had of blocks [begin, end) of one piece, after it: `force`, `stress` and
    // `energy` become those of the law. With `force` the derivative is kept; all of it where `at`
    // has `strained`. Returns the energy that comes on top, J.
    double evaluate(const Corotation& at, std::size_t begin, std::size_t end, const double* x);

    // Adds `stiffness` times the difference of the derivatives times p to y, blocks [begin, end).
    void add_times(Part part, float stiffness, std::size_t begin, std::size_t end, const float* p,
                   float* y) const;
    void add_times(Part part, double stiffness, std::size_t begin, std::size_t end, const double* p,
                   double* y) const;
    // Adds to d (K by slot, of each axis) so much that no direction is stiffer, over d, than it
    // would be at rest.
    void add_diagonal(Part part, double stiffness, double* d) const;
    void add_matrices(Part part, double stiffness, std::vector<BrickMatrix>& out) const;

private:
    // V times the difference of the derivatives by F, N m: its lower triangle row by row.
    struct Matrices {
        Aligned<double> high;  // B x 45 x 16; empty: not kept
        Aligned<float> low;
    };
    void store(std::size_t lane, const Eigen::Matrix<double, 9, 9>& matrix, Matrices& to) const;
    const Matrices& of(Part part) const { return part == Part::whole ? whole_ : positive_; }

    const BricksBody& body_;
    Matrices positive_, whole_;
};

}  // namespace physics
