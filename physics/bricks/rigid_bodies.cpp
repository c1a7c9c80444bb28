#include "physics/bricks/rigid_bodies.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace physics {
namespace {

Vec3 at(const double* v, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(v + 4 * std::size_t{slot});
}

// As spin_of(): nothing about an axis without inertia.
Mat3 inverse_of(const Mat3& inertia)
{
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
    const Vec3& value = solver.eigenvalues();
    Vec3 inverse = Vec3::Zero();
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (value[i] > 1e-9 * value[2]) inverse[i] = 1 / value[i];
    }
    const Mat3& axes = solver.eigenvectors();
    return axes * inverse.asDiagonal() * axes.transpose();
}

}  // namespace

RigidBodies::RigidBodies(const CornerBody& body) : body_(&body)
{
    if (body.rigid.empty()) return;
    number_.assign(body.parts, not_rigid);
    for (std::uint32_t p = 0; p < body.parts; ++p) {
        if (body.rigid[p] == 0) continue;
        number_[p] = static_cast<std::uint32_t>(parts_.size());
        parts_.push_back(p);
    }
    first_.assign(count() + 1, 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        const auto i = number_[body.part_of(k)];
        if (i != not_rigid) ++first_[i + 1];
    }
    for (std::size_t i = 0; i < count(); ++i) first_[i + 1] += first_[i];
    slots_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    mass_.assign(count(), 0);
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        const auto i = number_[body.part_of(k)];
        if (i == not_rigid) continue;
        slots_[next[i]++] = k;
        mass_[i] += body.mass[k];
    }
    motion.resize(count());
    centre_.resize(count()), inverse_.resize(count());
    arm_.assign(body.corners, Vec3::Zero());
    look_at(body.rest.data());
    rest_centre_ = centre_;
}

void RigidBodies::look_at(const double* x)
{
    ++looks_;
    for (std::size_t i = 0; i < count(); ++i) {
        Vec3 centre = Vec3::Zero();
        for (const auto slot : corners(i)) centre += body_->mass[slot] * at(x, slot);
        centre_[i] = centre / mass_[i];
        Mat3 inertia = Mat3::Zero();
        for (const auto slot : corners(i)) {
            const Vec3 arm = arm_[slot] = at(x, slot) - centre_[i];
            inertia +=
                body_->mass[slot] * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
        }
        inverse_[i] = inverse_of(inertia);
    }
}

void RigidBodies::nearest(std::size_t i, const double* w, Vec3& v, Vec3& s) const
{
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (const auto slot : corners(i)) {
        const Vec3 here = body_->mass[slot] * at(w, slot);
        sum += here;
        moment += arm_[slot].cross(here);
    }
    v = sum / mass_[i], s = by_lumped(i, moment);
}

void RigidBodies::straighten(double* x, double* v)
{
    if (none()) return;
    look_at(x);
    for (std::size_t i = 0; i < count(); ++i) {
        Mat3 sum = Mat3::Zero();
        for (const auto slot : corners(i)) {
            const Vec3 rest = at(body_->rest.data(), slot) - rest_centre_[i];
            sum += body_->mass[slot] * arm_[slot] * rest.transpose();
        }
        const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Mat3 u = svd.matrixU();
        if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
        const Mat3 turn = u * svd.matrixV().transpose();
        for (const auto slot : corners(i)) {
            arm_[slot] = turn * (at(body_->rest.data(), slot) - rest_centre_[i]);
            Eigen::Map<Vec3>(x + 4 * std::size_t{slot}) = centre_[i] + arm_[slot];
        }
        Vec3 velocity, spin;
        nearest(i, v, velocity, spin);
        spread(i, velocity, spin, v);
    }
}

}  // namespace physics
