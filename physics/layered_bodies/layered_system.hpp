#pragma once

// The linear system of one backward Euler step of layered bodies, frame by frame; frames are
// numbered through all bodies, and after them the corners of cubes. Frames that corners or masses
// carry are no unknowns: they follow, and what they feel is handed on (cube_carrier.hpp). A
// pair term with 3x3 matrices C and K between points of two frames adds
//   J^T (dt C + dt^2 K) J      J: velocities to the relative velocity of the points
// to the left and its forces, with -dt K of that velocity, to the right.
//
//   make_system()  ->  add_forces() (layered_forces.hpp)  ->  solve() (layered_solve.hpp)
//
// Where Bullet moves the rigid frames (layered_bullet.hpp) nothing is solved: those are held, and
// the forces on them are added up, with how fast they would make them swing.

#include "physics/layered_bodies/cube_carrier.hpp"
#include "physics/layered_bodies/layered_moment.hpp"

#include <span>
#include <vector>

namespace physics {

// What two frames, or corners, do to each other.
struct SystemPair {
    std::size_t a, b;
    Mat6 off;  // row a, column b
};

// A frame's part of a speed  u = sum along . v.
struct FrameRow {
    std::uint32_t body = 0;
    std::size_t frame = 0;
    Vec6 along = Vec6::Zero();
};

// Speed of parting u = along_a . v_a + along_b . v_b must be at least -room.
struct SystemStop {
    std::size_t a, b;
    Vec6 along_a, along_b;
    double room;       // m/s
    double stiffness;  // kg: while held, stiffness (u + room)^2 / 2 joins what is minimised
    bool held = false;
    // The body whose skeleton it is, where that has a layer with nothing left to give, and the one
    // that presses it.
    std::uint32_t body = geometry::no_index, other = geometry::no_index;

    double speed(const std::vector<Vec6>& v) const { return along_a.dot(v[a]) + along_b.dot(v[b]); }
};

struct LayeredSystem {
    double dt = 0;                                       // s
    double longest = 0;                                  // s, of a step that is not cut short
    std::vector<std::size_t> first_frame, first_corner;  // of each body
    std::vector<Vec6> velocity, right;                   // of each frame and corner, as all below
    std::vector<BaseKind> kind;                          // of held frames: still
    std::vector<char> held;
    std::vector<Mat6> mass, diagonal;
    std::vector<double> drag;                        // kg/s, by air
    std::vector<Mat6> held_stiffness, held_damping;  // sums of J^T K J, J^T C J
    std::vector<SystemPair> pairs;
    std::vector<SystemStop> stops;
    std::vector<CarriedFrame> carried;
    std::vector<CubeCarrier> carriers;
    std::size_t merged = 0;  // how many pairs are merged already

    // The numbers of a body's frames and of its cubes' corners.
    std::size_t frame(std::size_t body, std::size_t f) const { return first_frame[body] + f; }
    std::size_t corner(std::size_t body, std::size_t k) const { return first_corner[body] + k; }
};

// Without forces but those of cubes on their corners. The scene must outlive it.
LayeredSystem make_system(const LayeredScene& scene, const LayeredMoment& moment, double dt,
                          RigidBodies rigid_bodies = RigidBodies::implicit);

void add_force(LayeredSystem& system, std::size_t f, const Vec3& force,
               const Vec3& torque = Vec3::Zero());

// `rate`: 1/s, of its speed.
void add_drag(LayeredSystem& system, std::size_t f, double rate);

// Only the matrix terms: forces come by add_force(). Arms reach from the frames' origins.
void add_pair(LayeredSystem& system, std::size_t a, std::size_t b, const Vec3& arm_a,
              const Vec3& arm_b, const Mat3& C, const Mat3& K);
void add_angular_pair(LayeredSystem& system, std::size_t a, std::size_t b, const Mat3& C,
                      const Mat3& K);

// The same of a damping c and a stiffness k of  u = sum along . v  over rows.
void add_along(LayeredSystem& system, std::span<const FrameRow> rows, double c, double k);

// The same against the world: a point of the frame, or its turning.
void add_hold(LayeredSystem& system, std::size_t f, const Vec3& arm, const Mat3& C, const Mat3& K);
void add_angular_hold(LayeredSystem& system, std::size_t f, const Mat3& C, const Mat3& K);

// Points of two frames may not come nearer than this along `normal`, away from b, in the step: what
// is left between them now is `gap` m more. At least one of the two is free.
void add_stop(LayeredSystem& system, std::size_t a, std::size_t b, const Vec3& arm_a,
              const Vec3& arm_b, const Vec3& normal, double gap);

// One block a pair of frames, in their order.
void merge_pairs(LayeredSystem& system);

// Force and torque on a held frame.
Vec6 held_force(const LayeredSystem& system, std::size_t f);

// What held frames would do under the stiffness and the damping of the pairs that they are in:
// swing at no more than `frequency` and slow down at no more than `decay`. A pair of two counts
// twice in each: together they swing faster than either alone.
struct Rates {
    double frequency = 0;  // rad/s
    double decay = 0;      // 1/s
};
Rates held_rates(const LayeredSystem& system, std::size_t f);

// The rotations of a body's cubes as they were found; none where it has no cubes.
std::vector<float> cube_rotations(const LayeredSystem& system, std::size_t body);

}  // namespace physics
