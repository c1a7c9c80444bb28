#include "physics/bricks/rigid_system.hpp"

#include <Eigen/LU>

namespace physics {

void RigidSystem::look(const RigidBodies& bodies,
                       const std::function<void(const double*, double*)>& multiply,
                       std::size_t room, const Aligned<double>& diagonal)
{
    bodies_ = &bodies;
    if (looks_ == bodies.looks()) return;
    looks_ = bodies.looks();
    own_.assign(bodies.count(), Matrix6::Zero());
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
            own_[i].col(j) << force, torque;
        }
    }
    for (Matrix6& own : own_) own = (0.5 * (own + own.transpose())).eval();
}

void RigidSystem::make(const std::vector<ContactBlock<double>>& contacts)
{
    blocks_ = {own_, {}};
    for (const auto& contact : contacts) blocks_.add(*bodies_, contact);
    inverse_.clear();
    if (factor_.make(blocks_)) return;
    for (const auto& block : blocks_.own) inverse_.push_back(block.inverse());
}

template <class T> void RigidSystem::solve(const T* r, T* z) const
{
    Eigen::VectorXd f(static_cast<Eigen::Index>(6 * bodies_->count()));
    for (std::size_t i = 0; i < bodies_->count(); ++i) {
        Vec3 force, torque;
        bodies_->gather(i, r, force, torque);
        f.segment<6>(static_cast<Eigen::Index>(6 * i)) << force, torque;
    }
    if (inverse_.empty()) {
        factor_.solve(f);
    } else {
        for (std::size_t i = 0; i < bodies_->count(); ++i) {
            auto own = f.segment<6>(static_cast<Eigen::Index>(6 * i));
            own = (inverse_[i] * own).eval();
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
