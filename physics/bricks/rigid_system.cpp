#include "physics/bricks/rigid_system.hpp"

#include <Eigen/SparseCholesky>

#include <array>
#include <map>
#include <utility>

namespace physics {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Rows = Eigen::Matrix<double, 3, 6>;

Mat3 cross_of(const Vec3& r)
{
    Mat3 out;
    out << 0, -r[2], r[1], r[2], 0, -r[0], -r[1], r[0], 0;
    return out;
}

// The corners of a contact that are of one rigid part.
struct Side {
    std::uint32_t body = 0;
    double weight = 0;        // the sum of theirs
    Vec3 arm = Vec3::Zero();  // m, the sum of their weights times their arms

    // How fast the point is there, by the six unknowns.
    Rows rows() const
    {
        Rows out;
        out << weight * Mat3::Identity(), -cross_of(arm);
        return out;
    }
};

// Those of the rigid parts that a contact has corners of: two at most.
std::size_t sides_of(const RigidBodies& bodies, const ContactBlock<double>& contact,
                     std::array<Side, 2>& sides)
{
    std::size_t count = 0;
    for (std::size_t a = 0; a < contact.count; ++a) {
        const auto slot = contact.corners[a];
        const auto body = bodies.of_corner(slot);
        if (body == RigidBodies::not_rigid) continue;
        std::size_t s = 0;
        while (s < count && sides[s].body != body) ++s;
        if (s == sides.size()) continue;
        if (s == count) sides[count++] = {body};
        sides[s].weight += contact.weight[a];
        sides[s].arm += contact.weight[a] * bodies.arm(slot);
    }
    return count;
}

Mat3 symmetric(const std::array<double, 6>& m)
{
    Mat3 out;
    out << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5];
    return out;
}

}  // namespace

struct RigidSystem::Factor {
    std::vector<Matrix6> own;  // of each part alone, without contacts
    std::uint64_t looks = 0;   // of the arms that these are of
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> all;
    std::vector<Matrix6> inverse;  // of each part's block, where all of them have no factor
};

RigidSystem::RigidSystem() : factor_(std::make_unique<Factor>()) {}
RigidSystem::~RigidSystem() = default;
RigidSystem::RigidSystem(RigidSystem&&) noexcept = default;
RigidSystem& RigidSystem::operator=(RigidSystem&&) noexcept = default;

void RigidSystem::look(const RigidBodies& bodies,
                       const std::function<void(const double*, double*)>& multiply,
                       std::size_t room, const Aligned<double>& diagonal)
{
    bodies_ = &bodies;
    if (factor_->looks == bodies.looks()) return;
    factor_->looks = bodies.looks();
    factor_->own.assign(bodies.count(), Matrix6::Zero());
    Aligned<double> p(room, 0), y(room, 0);
    for (Eigen::Index j = 0; j < 6; ++j) {
        const Vec3 v = j < 3 ? Vec3(Vec3::Unit(j)) : Vec3(Vec3::Zero());
        const Vec3 s = j < 3 ? Vec3(Vec3::Zero()) : Vec3(Vec3::Unit(j - 3));
        for (std::size_t i = 0; i < bodies.count(); ++i) bodies.spread(i, v, s, p.data());
        multiply(p.data(), y.data());
        for (std::size_t k = 0; k < diagonal.size(); ++k) y[k] += diagonal[k] * p[k];
        for (std::size_t i = 0; i < bodies.count(); ++i) {
            Vec3 force, torque;
            bodies.gather(i, y.data(), force, torque);
            factor_->own[i].col(j) << force, torque;
        }
    }
    for (Matrix6& own : factor_->own) own = (0.5 * (own + own.transpose())).eval();
}

void RigidSystem::make(const std::vector<ContactBlock<double>>& contacts)
{
    std::vector<Matrix6> blocks = factor_->own;
    std::map<std::pair<std::uint32_t, std::uint32_t>, Matrix6> between;  // second < first
    std::array<Side, 2> sides;
    for (const auto& contact : contacts) {
        const std::size_t count = sides_of(*bodies_, contact, sides);
        const Mat3 matrix = symmetric(contact.matrix);
        const std::array<Rows, 2> rows{sides[0].rows(), sides[1].rows()};
        for (std::size_t s = 0; s < count; ++s) {
            const std::uint32_t own = sides[s].body;
            const Rows pushed = matrix * rows[s];
            blocks[own].noalias() += rows[s].transpose() * pushed;
            if (count < 2) continue;
            const std::uint32_t other = sides[1 - s].body;
            if (other < own) continue;
            const auto at = between.try_emplace({other, own}, Matrix6::Zero()).first;
            at->second.noalias() += rows[1 - s].transpose() * pushed;
        }
    }
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](std::size_t i, std::size_t j, const Matrix6& block) {
        for (int a = 0; a < 6; ++a) {
            for (int b = 0; b < (i == j ? a + 1 : 6); ++b) {
                entries.emplace_back(static_cast<int>(6 * i) + a, static_cast<int>(6 * j) + b,
                                     block(a, b));
            }
        }
    };
    for (std::size_t i = 0; i < blocks.size(); ++i) add(i, i, blocks[i]);
    for (const auto& [pair, block] : between) add(pair.first, pair.second, block);
    const auto n = static_cast<Eigen::Index>(6 * blocks.size());
    Eigen::SparseMatrix<double> matrix(n, n);  // its lower half
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor_->all.compute(matrix);
    factor_->inverse.clear();
    if (factor_->all.info() == Eigen::Success && (factor_->all.vectorD().array() > 0).all()) return;
    for (const auto& block : blocks) factor_->inverse.push_back(block.inverse());
}

template <class T> void RigidSystem::solve(const T* r, T* z) const
{
    Eigen::VectorXd f(static_cast<Eigen::Index>(6 * bodies_->count()));
    for (std::size_t i = 0; i < bodies_->count(); ++i) {
        Vec3 force, torque;
        bodies_->gather(i, r, force, torque);
        f.segment<6>(static_cast<Eigen::Index>(6 * i)) << force, torque;
    }
    if (factor_->inverse.empty()) {
        f = factor_->all.solve(f).eval();
    } else {
        for (std::size_t i = 0; i < bodies_->count(); ++i) {
            auto own = f.segment<6>(static_cast<Eigen::Index>(6 * i));
            own = (factor_->inverse[i] * own).eval();
        }
    }
    for (std::size_t i = 0; i < bodies_->count(); ++i) {
        const auto own = f.segment<6>(static_cast<Eigen::Index>(6 * i));
        bodies_->spread(i, Vec3(own.head<3>()), Vec3(own.tail<3>()), z);
    }
}

template void RigidSystem::solve(const float*, float*) const;
template void RigidSystem::solve(const double*, double*) const;

}  // namespace physics
