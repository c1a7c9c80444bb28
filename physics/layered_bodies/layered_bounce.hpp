#pragma once

// Bounces of layers: what a contact took on the way in it gives back on the way out, but for what
// its restitution takes.
//
//     | F      .'|       The work of the elastic forces on two skeletons' frames is counted: taken
//     |      .' .|       on the way in (upper curve), given on the way out (lower curve). Less is
//     |    .' .' |       given than was taken by (1 - e^2) of the energy with which they came on:
//     |  .'.-'   |       they part with e times the speed of their approach,
//     '-----------> depth        u' = -e u,
//                        whatever the step, the stiffness, the mass and the weight. None is made.
//
// The energetic coefficient of restitution: Stronge. Rigid body collisions with friction. Proc. R.
// Soc. A 431, 1990. Of two layers in series each gives back e_i^2 of what it stores, and stores the
// more the softer it is:  e^2 = (e_i^2 k_j + e_j^2 k_i) / (k_i + k_j)
//
// Half a swing of w in steps of backward Euler keeps exp(-pi w dt) of its energy: 73 % where w dt
// is 0.1, 4 % where it is 1. So contacts that bounce push explicitly, in steps of w dt <= 0.6 while
// they last, and all others stay in the implicit system. What explicit steps err by is in the
// count, and is mended on the way out.
//
// u: speed of parting, along the forces' sum: what u is multiplied with gives their power.

#include "physics/layered_bodies/contact_rows.hpp"

namespace physics {

// A frame that a contact pushes.
struct ImpactFrame {
    std::uint32_t body = 0;
    std::size_t frame = 0;  // in the system
    Vec6 along = Vec6::Zero();
    Vec6 gives = Vec6::Zero();  // dv by an impulse of 1; 0 where it is not free
};

// A contact of two skeletons in a step.
struct Impact {
    std::uint32_t body = 0;           // whose state keeps the count
    LayerBounce bounce;               // as it is kept for the next step
    std::size_t a = 0, b = 0;         // frames in the system
    std::vector<ImpactFrame> frames;  // u = sum along . v
    double force = 0;                 // N, of elasticity
    double energy = 0;                // J, that elasticity holds at this depth
    double depth = 0;                 // m, at its deepest
    double stiffness = 0;             // N/m
    double damping = 0;               // N s/m, by friction
    double restitution_sq = 0;
    double mass = 0;     // kg, that takes part; of several contacts of a frame each one's
    double rate = 0;     // rad/s, of all contacts of its frames
    double speed = 0;    // m/s, u as the step begins
    double shape = 0;    // m/s, of that, by skeletons that change their shape
    double weight = 0;   // m/s^2, du/dt by weight
    double push = 0;     // N, what it gives in this step
    bool known = false;  // touched in the step before

    bool bounces() const { return bounce.struck; }
    double parting(const std::vector<Vec6>& v) const;  // m/s
    bool held(const LayeredSystem& system) const;      // whether Bullet moves any of its frames
};

struct Impacts {
    std::vector<Impact> all;                // by bodies and skeletons
    std::vector<std::uint32_t> of_contact;  // of each contact of the moment; no_index: none
    std::vector<ContactRows> rows;          // of each contact
    std::vector<char> on_weight;  // of each body: contacts that rest, or stops, bear its weight

    std::vector<double> lag;  // see BounceTimes

    const Impact* of(std::size_t contact) const
    {
        return of_contact.empty() || of_contact[contact] == geometry::no_index
                   ? nullptr
                   : &all[of_contact[contact]];
    }
};

struct BounceTimes {
    double asked = 0;         // s, longest step
    std::vector<double> lag;  // s, by half of which the velocities of each body are behind places
};

// The contacts of a moment, and which of them bounce: what hits at more than twice the speed that
// weight gives in the longest step, and at more than 2.4 times the thickness
// of its layer in a second.
Impacts find_impacts(const LayeredScene& scene, const LayeredMoment& moment,
                     const LayeredSystem& system, const Vec3& gravity, const BounceTimes& times);

// How long a step may be so that those that bounce swing by no more than 0.6 rad in it, s.
double longest_step(const Impacts& impacts);

// Whether a step of `last` s went so far into a contact that it should be taken in parts.
bool too_deep(const Impacts& impacts, double last);

// Decides what those that bounce give in a step of system.dt s.
void aim(Impacts& impacts, LayeredSystem& system);

// Counts what they gave, with the frames' new velocities, and keeps the counts in the scene.
void keep(const Impacts& impacts, const LayeredSystem& system, const std::vector<Vec6>& dv,
          LayeredScene& scene);

}  // namespace physics
