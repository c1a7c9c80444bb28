#pragma once

// What every solver steps: positions and velocities of corners, and how the last step went.

#include "geometry/base/vec.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace physics {

using geometry::Mat3;
using geometry::Vec3;

// How an advance() went: data, never an exception.
struct Report {
    bool converged = true;
    bool slept = false;                 // nothing would have moved: no step was taken
    int steps = 0;                      // time steps taken
    int iterations = 0;                 // inner iterations, all steps together
    double residual = 0;                // largest relative residual left over
    double step_error = 0;              // largest of a step, in cubes; of implicit Euler alone
    std::vector<std::string> warnings;  // each a sentence for a person
};

// Where a rigid ball is and how it moves.
struct BallState {
    Vec3 x = Vec3::Zero();             // m
    Vec3 v = Vec3::Zero();             // m/s
    Vec3 spin = Vec3::Zero();          // rad/s
    Eigen::Vector4d turn{1, 0, 0, 0};  // unit quaternion w, x, y, z
};

// What is known of a point of a body's surface that touched something at the end of a step: how far
// it has been dragged along that, as far as friction holds, and from which side it came. Of one
// that let go within the frame the force alone is known, and the normal is 0.
struct Grip {
    std::uint32_t point = 0, other = 0;                 // as in PlaneTouch
    Eigen::Vector3f stretch = Eigen::Vector3f::Zero();  // m
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();   // unit, out of what it touches
    float depth = 0;                                    // m, how deep it was in that; >= 0
    float firmness = 1;  // how many times stiffer it has become since it touched first
    float slack = 0;     // m, how deep it may be without a push
    float at_rest = 0;   // N/m, how stiff it is where it rests, less its firmness; 0: not known
    // N, by which it was held in the mean over the frame: on the first of the two corners beside
    // it, and against that on the second, if what it touches has corners.
    Eigen::Vector3f force = Eigen::Vector3f::Zero();
    std::array<std::uint32_t, 2> corners{no_corner, no_corner};

    static constexpr std::uint32_t no_corner = std::numeric_limits<std::uint32_t>::max();
};

// The force by which a pin held its corner, in the mean over the last frame.
struct Reaction {
    std::uint32_t corner = 0;
    Eigen::Vector3f force = Eigen::Vector3f::Zero();  // N, on the body
};

// Where the corners and cubes of one of several models lie among those of a state.
struct StateModel {
    std::uint64_t mark = 0;  // of the cubes, see state_models.hpp
    std::uint32_t corner = 0, corners = 0;
    std::uint32_t cube = 0, cubes = 0;
};

// What has a rest shape that flows.
enum class PlasticOf : std::uint8_t { nothing, regions, bricks, triangles };

// A moment of a simulation. A value: copying it is a checkpoint.
struct State {
    double time = 0;              // s since the first frame
    std::vector<Vec3> x;          // K, m
    std::vector<Vec3> v;          // K, m/s
    bool brick_mass = false;      // cubes have the mass of bricks (cube_mass.hpp), not lumped mass
    std::vector<float> rotation;  // what a method keeps to warm-start its rotations; may be empty
    std::vector<float> plastic;   // what flowed for good, as its method keeps it; empty: nothing
    PlasticOf plastic_of = PlasticOf::nothing;
    // C, strain that the rest shape of each cube has come to, root of the mean square in bricks and
    // triangles, the mean of its regions' in a lattice; empty where none may flow.
    std::vector<float> plastic_strain;
    std::vector<std::uint32_t> broken;  // links that broke, 3 * corner + axis, sorted
    std::vector<BallState> balls;       // those in Loads, in their order
    std::vector<Grip> grips;            // of parts; ascending by (point, other)
    std::vector<Grip> holds;            // of colliders; likewise
    // C, Pa and J, von Mises stress and elastic energy of each cube; empty when the method knows
    // none, not a number where it knows none of a cube.
    std::vector<float> stress, energy;
    std::vector<Reaction> reactions;  // by corner; of bricks, springs and shells
    // H, m, where the targets of pins that hold points of the material were, as HeldMatter has
    // them; and what these springs pushed at each corner with.
    std::vector<Vec3> held;
    std::vector<Reaction> held_forces;
    std::vector<StateModel> models;  // empty: one
    double energy_owed = 0;  // J, that steps of the midpoint rule have too much, still to take out
    int still_frames = 0;    // in a row in which no corner moved; of bricks, springs and shells
    Vec3 gravity = Vec3::Zero();  // m/s^2, of Simulate where the next frame starts
    Report report;
};

}  // namespace physics
