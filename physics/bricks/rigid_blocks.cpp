#include "physics/bricks/rigid_blocks.hpp"

#include <Eigen/SparseCholesky>

namespace physics {
namespace {

Mat3 cross_of(const Vec3& r)
{
    Mat3 out;
    out << 0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0;
    return out;
}

}  // namespace

RigidRows RigidSide::rows() const
{
    RigidRows out;
    out << weight * Mat3::Identity(), -cross_of(arm);
    return out;
}

Mat3 matrix_of(const ContactBlock<double>& contact)
{
    const auto& m = contact.matrix;
    Mat3 out;
    out << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5];
    return out;
}

RigidSides sides_of(const RigidBodies& bodies, const ContactBlock<double>& contact)
{
    RigidSides out;
    for (std::size_t a = 0; a < contact.count; ++a) {
        const auto slot = contact.corners[a];
        const auto body = bodies.of_corner(slot);
        if (body == RigidBodies::not_rigid) continue;
        std::size_t s = 0;
        while (s < out.count && out.side[s].body != body) ++s;
        if (s == out.side.size()) continue;
        if (s == out.count) out.side[out.count++].body = body;
        out.side[s].weight += contact.weight[a];
        out.side[s].arm += contact.weight[a] * bodies.arm(slot);
    }
    return out;
}

void RigidBlocks::add_between(std::uint32_t i, std::uint32_t j, const Matrix6& block)
{
    between.try_emplace({j, i}, Matrix6::Zero()).first->second += block.transpose();
}

void RigidBlocks::add(const RigidBodies& bodies, const ContactBlock<double>& contact)
{
    const RigidSides sides = sides_of(bodies, contact);
    const Mat3 matrix = matrix_of(contact);
    const std::array<RigidRows, 2> rows{sides.side[0].rows(), sides.side[1].rows()};
    for (std::size_t s = 0; s < sides.count; ++s) {
        const std::uint32_t body = sides.side[s].body, other = sides.side[1 - s].body;
        const RigidRows pushed = matrix * rows[s];
        own[body].noalias() += rows[s].transpose() * pushed;
        if (sides.count < 2 || other < body) continue;
        const auto at = between.try_emplace({other, body}, Matrix6::Zero()).first;
        at->second.noalias() += rows[1 - s].transpose() * pushed;
    }
}

struct RigidFactor::Cholesky {
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> of;
};

RigidFactor::RigidFactor() : all_(std::make_unique<Cholesky>()) {}
RigidFactor::~RigidFactor() = default;
RigidFactor::RigidFactor(RigidFactor&&) noexcept = default;
RigidFactor& RigidFactor::operator=(RigidFactor&&) noexcept = default;

bool RigidFactor::make(const RigidBlocks& blocks)
{
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](std::size_t i, std::size_t j, const Matrix6& block) {
        for (int a = 0; a < 6; ++a) {
            for (int b = 0; b < (i == j ? a + 1 : 6); ++b) {
                entries.emplace_back(static_cast<int>(6 * i) + a, static_cast<int>(6 * j) + b,
                                     block(a, b));
            }
        }
    };
    for (std::size_t i = 0; i < blocks.own.size(); ++i) add(i, i, blocks.own[i]);
    for (const auto& [pair, block] : blocks.between) add(pair.first, pair.second, block);
    const auto n = static_cast<Eigen::Index>(6 * blocks.own.size());
    Eigen::SparseMatrix<double> matrix(n, n);  // its lower half
    matrix.setFromTriplets(entries.begin(), entries.end());
    all_->of.compute(matrix);
    return all_->of.info() == Eigen::Success && (all_->of.vectorD().array() > 0).all();
}

void RigidFactor::solve(Eigen::VectorXd& f) const
{
    f = all_->of.solve(f).eval();
}

}  // namespace physics
