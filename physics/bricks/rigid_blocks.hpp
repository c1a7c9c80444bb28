#pragma once

// The matrix of a stage's linear equations between its rigid parts, six unknowns each
// (rigid_bodies.hpp): the blocks of each part alone and between two that touch, and what a contact
// adds to them. With W a contact's weights and K its matrix, and P_i the motion of part i,
//   W P_i = (w 1, -[a]),   w = the sum of its weights there, a = that of weights times arms
//   block(i, j) += (W P_i)^T K (W P_j)

#include "physics/bricks/contact_block.hpp"
#include "physics/bricks/rigid_bodies.hpp"

#include <Eigen/Core>

#include <array>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace physics {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using RigidRows = Eigen::Matrix<double, 3, 6>;

// The corners of a contact that are of one rigid part.
struct RigidSide {
    std::uint32_t body = 0;
    double weight = 0;        // the sum of theirs
    Vec3 arm = Vec3::Zero();  // m, the sum of their weights times their arms

    RigidRows rows() const;  // W P: how fast the point is there, by the six unknowns
};
struct RigidSides {
    std::array<RigidSide, 2> side;
    std::size_t count = 0;
};
RigidSides sides_of(const RigidBodies& bodies, const ContactBlock<double>& contact);

Mat3 matrix_of(const ContactBlock<double>& contact);  // K

struct RigidBlocks {
    std::vector<Matrix6> own;                                            // of each part
    std::map<std::pair<std::uint32_t, std::uint32_t>, Matrix6> between;  // second < first

    void add(const RigidBodies& bodies, const ContactBlock<double>& contact);
    // What a block adds between parts i and j, i < j: that of their unknowns in this order.
    void add_between(std::uint32_t i, std::uint32_t j, const Matrix6& block);
};

// Their factor.
class RigidFactor {
public:
    RigidFactor();
    ~RigidFactor();
    RigidFactor(RigidFactor&&) noexcept;
    RigidFactor& operator=(RigidFactor&&) noexcept;

    // False: the matrix is not positive.
    bool make(const RigidBlocks& blocks);
    void solve(Eigen::VectorXd& f) const;

private:
    struct Cholesky;
    std::unique_ptr<Cholesky> all_;
};

}  // namespace physics
