#pragma once

// The linear system of one backward Euler step of layered bodies, frame by frame; frames are
// numbered through all bodies, and after them the corners of cubes. Frames that cubes carry are no
// unknowns: they follow corners, and what they feel is handed on to those (cube_base.hpp). A pair
// term with 3x3 matrices C and K between points of two frames adds
//   J^T (dt C + dt^2 K) J      J: velocities to the relative velocity of the points
// to the left and its forces, with -dt K of that velocity, to the right.
//
// Where Bullet moves the rigid frames (layered_bullet.hpp) nothing is solved here: those are held,
// and the forces on them are added up, with how fast they would make them swing.

#include "physics/layered.hpp"

#include <memory>
#include <vector>

namespace physics {

using Vec6 = Eigen::Matrix<double, 6, 1>;  // a twist: velocity, spin; or a wrench
using Mat6 = Eigen::Matrix<double, 6, 6>;

class LayeredSystem {
public:
    // Without forces but those of cubes on their corners. Both must outlive it.
    LayeredSystem(const LayeredScene& scene, const LayeredMoment& moment, double dt,
                  RigidBodies rigid_bodies = RigidBodies::implicit);

    double dt() const { return dt_; }
    // The numbers of a body's frames and of its cubes' corners, and what either weighs.
    std::size_t frame(std::size_t body, std::size_t f) const { return first_[body] + f; }
    std::size_t corner(std::size_t body, std::size_t k) const { return first_corner_[body] + k; }
    const Mat6& mass(std::size_t f) const { return mass_[f]; }
    bool is_held(std::size_t f) const { return held_[f]; }

    // Force and torque on a held frame.
    Vec6 force(std::size_t f) const { return right_[f] / dt_; }
    // What held frames would do under the stiffness and the damping of the pairs that they are in:
    // swing at no more than `frequency` and slow down at no more than `decay`. A pair of two counts
    // twice in each: together they swing faster than either alone.
    struct Rates {
        double frequency = 0;  // rad/s
        double decay = 0;      // 1/s
    };
    Rates rates(std::size_t f) const;

    void add_force(std::size_t f, const Vec3& force, const Vec3& torque = Vec3::Zero());
    // `rate`: 1/s, of its speed.
    void add_drag(std::size_t f, double rate);

    // Only the matrix terms: forces come by add_force(). Arms reach from the frames' origins.
    void add_pair(std::size_t a, std::size_t b, const Vec3& arm_a, const Vec3& arm_b, const Mat3& C,
                  const Mat3& K);
    void add_angular_pair(std::size_t a, std::size_t b, const Mat3& C, const Mat3& K);

    // Points of two frames may not come nearer than this along `normal`, away from b, in the step:
    // what is left between them now is `gap` m more. At least one of the two is free.
    void add_stop(std::size_t a, std::size_t b, const Vec3& arm_a, const Vec3& arm_b,
                  const Vec3& normal, double gap);

    // dv of every frame and corner: the least of  dv^T A dv / 2 - dv . right + sum stiffness
    // min(0, u + room)^2 / 2  over stops, convex and quadratic in pieces. Newton's method: those
    // that would be passed are held, the others let go, until that is what comes out; a step that
    // does not go down is halved.
    std::vector<Vec6> solve(Report& report);

    // The rotations of a body's cubes as they were found; none where it has no cubes.
    std::vector<float> rotations(std::size_t body) const;

private:
    using Jacobian = Eigen::Matrix<double, 3, 6>;

    struct Pair {
        std::size_t a, b;
        Mat6 off;  // row a, column b
    };

    // Speed of parting u = along_a . v_a + along_b . v_b must be at least -room.
    struct Stop {
        std::size_t a, b;
        Vec6 along_a, along_b;
        double room;       // m/s
        double stiffness;  // kg: while held, stiffness (u + room)^2 / 2 joins what is minimised
        bool held = false;

        double speed(const std::vector<Vec6>& v) const
        {
            return along_a.dot(v[a]) + along_b.dot(v[b]);
        }
    };

    // Cubes that carry the frames from first_frame on.
    struct Carrier {
        const CubeBase* base = nullptr;
        std::size_t first_frame = 0, first_corner = 0;
        std::vector<FrameHold> holds;  // one a frame
        std::unique_ptr<Elasticity> elasticity;
        Aligned<double> diagonal;         // by slot, about, of its terms
        mutable Aligned<double> in, out;  // by slot, for add_elastic()

        const CornerBody& corner_body() const { return base->bricks().base; }
    };

    Jacobian point_jacobian(std::size_t f, const Vec3& arm) const;
    void add_terms(std::size_t a, std::size_t b, const Jacobian& Ja, const Jacobian& Jb,
                   const Mat3& C, const Mat3& K);
    // Corners as unknowns, with the forces of body b's cubes on them.
    void add_cubes(const LayeredScene& scene, std::size_t b);
    // One block a pair of frames, in their order.
    void merge_pairs();

    double beyond(const Stop& stop, const std::vector<Vec6>& dv) const;
    // Whether that changes which stops are held.
    bool hold_passed(const std::vector<Vec6>& dv);
    double potential(const std::vector<Vec6>& dv) const;
    // By conjugate gradients preconditioned by the frames' own blocks.
    std::vector<Vec6> solve_held(Report& report) const;
    Vec6 free(std::size_t f, Vec6 v) const;
    // y = A x. Frames that cubes carry go along in x, whatever it has for them.
    void multiply(std::vector<Vec6>& x, std::vector<Vec6>& y) const;
    // Every carried frame's part of x from its corners'.
    void take_along(std::vector<Vec6>& x) const;
    // What y has for carried frames goes to their corners.
    void hand_to_corners(std::vector<Vec6>& y) const;
    // The same of the diagonal's blocks, as far as it stays on the diagonal, and the cubes' own.
    void add_to_corner_blocks(std::vector<Mat6>& blocks) const;
    // y += (dt C + dt^2 K) x of cubes.
    void add_elastic(const std::vector<Vec6>& x, std::vector<Vec6>& y) const;

    double dt_;
    std::vector<std::size_t> first_, first_corner_;  // of each body
    std::vector<Vec6> velocity_, right_;
    std::vector<BaseKind> kind_;  // of held frames: still
    std::vector<char> held_;
    std::vector<Mat6> mass_, diagonal_;
    std::vector<Mat6> held_stiffness_, held_damping_;  // sums of J^T K J, J^T C J
    std::vector<Pair> pairs_;
    std::vector<Stop> stops_;
    std::vector<Carrier> carriers_;
    std::size_t merged_ = 0;
};

}  // namespace physics
