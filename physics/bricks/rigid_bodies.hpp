#pragma once

// Rigid parts of a body in a stage of an implicit time step (stage.hpp).
//
// The corners of a rigid part move as one. Its unknowns are the velocity v of its centre and its
// spin s at the end of the stage:
//   w_a = v + s x r_a,   x_a = c + tau v + r_a,   r_a = R (x_a - c, as it began)
// R is the turn by the midpoint rule whose angular momentum is that of s (rigid_part.hpp). The
// stage's equations stay as they are: for a guess of v and s it has x0 = x - tau w of these
// corners, and v0 turned to the momenta that the part began with, as of elastic parts that turn
// freely (free_parts.hpp). Rounds of Newton's method then change w linearly about that guess, with
// arms r_a that stay, so that contacts converge as of elastic parts; and a new guess is made of
// what they found, until it is where they end.
//
// Of forces on the corners of a rigid part only their sum and their torque count, P^T f with
// P = (1, -[r_a]). They are kept in the form that has both and the least norm in M^-1:
//   m_a (b + t x r_a)
// so that residuals and directions of a solver are vectors over corners as before.

#include "physics/body/corner_body.hpp"
#include "physics/bricks/rigid_part.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace physics {

// One of them, as it moves in the stage.
struct RigidMotion {
    RigidPart began;
    Mat3 by = Mat3::Identity();  // turn since then
    Vec3 v = Vec3::Zero();       // m/s
    Vec3 s = Vec3::Zero();       // rad/s
    // It goes to its place with less than v and than its angular momentum, by these: 0, or half of
    // what both gain in the stage (rigid_energy.hpp).
    Vec3 less_v = Vec3::Zero();         // m/s
    Vec3 less_momentum = Vec3::Zero();  // N m s
};

class RigidBodies {
public:
    explicit RigidBodies(const CornerBody& body);

    bool none() const { return parts_.empty(); }
    bool all() const { return parts_.size() == body_->parts; }
    std::size_t count() const { return parts_.size(); }
    std::uint32_t part(std::size_t i) const { return parts_[i]; }
    std::span<const std::uint32_t> corners(std::size_t i) const  // slots
    {
        return std::span(slots_).subspan(first_[i], first_[i + 1] - first_[i]);
    }
    // Which of these has a corner.
    static constexpr std::uint32_t not_rigid = 0xffffffff;
    std::uint32_t of_corner(std::uint32_t slot) const
    {
        return none() ? not_rigid : number_[body_->part_of(slot)];
    }

    std::vector<RigidMotion> motion;  // of each

    // Arms r_a are those at x from now on.
    void look_at(const double* x);
    std::uint64_t looks() const { return looks_; }  // how often
    const Vec3& arm(std::uint32_t slot) const { return arm_[slot]; }

    // The sum of forces on the corners of one, and their torque about its centre.
    template <class T> void gather(std::size_t i, const T* f, Vec3& force, Vec3& torque) const
    {
        force = torque = Vec3::Zero();
        for (const auto slot : corners(i)) {
            const T* const at = f + 4 * std::size_t{slot};
            const Vec3 here(static_cast<double>(at[0]), static_cast<double>(at[1]),
                            static_cast<double>(at[2]));
            force += here;
            torque += arm_[slot].cross(here);
        }
    }
    // Each corner's v + s x r_a.
    template <class T> void spread(std::size_t i, const Vec3& v, const Vec3& s, T* to) const
    {
        for (const auto slot : corners(i)) {
            const Vec3 here = v + s.cross(arm_[slot]);
            for (std::size_t a = 0; a < 3; ++a) {
                to[4 * std::size_t{slot} + a] = static_cast<T>(here[static_cast<Eigen::Index>(a)]);
            }
        }
    }
    // Forces in the form above, in place of those there.
    template <class T> void even_out(T* f) const
    {
        for (std::size_t i = 0; i < count(); ++i) {
            Vec3 force, torque;
            gather(i, f, force, torque);
            spread(i, force / mass_[i], by_lumped(i, torque), f);
            for (const auto slot : corners(i)) {
                for (std::size_t a = 0; a < 3; ++a) {
                    f[4 * std::size_t{slot} + a] *= static_cast<T>(body_->mass[slot]);
                }
            }
        }
    }
    // The motion of one that is nearest to a field, in the norm of the lumped M.
    void nearest(std::size_t i, const double* w, Vec3& v, Vec3& s) const;

    // Takes corners back to the rest shape, where it lies nearest to x, and the velocity that is
    // nearest to v: they may be off by rounding, or by a change of v along a line.
    void straighten(double* x, double* v);

private:
    Vec3 by_lumped(std::size_t i, const Vec3& torque) const { return inverse_[i] * torque; }

    const CornerBody* body_;
    std::vector<std::uint32_t> parts_, number_, first_, slots_;
    std::uint64_t looks_ = 0;
    std::vector<double> mass_;       // kg, of each
    std::vector<Vec3> centre_;       // m
    std::vector<Mat3> inverse_;      // of the inertia of the lumped masses, where it has one
    std::vector<Vec3> arm_;          // K by slot, m
    std::vector<Vec3> rest_centre_;  // m, of each at rest
};

}  // namespace physics
