#pragma once

// Rigid frames of a layered scene as Bullet's bodies, their hinges as its joints.
// Bullet finds no collisions here: what layers do to each other comes as forces and torques, taken
// where the bodies stand in the middle of a step,
//   x += h/2 v,   v += h M^-1 f(x) and what joints and stops need,   x += h/2 v,
// which falls exactly under weight whatever h is, so that a frame's steps may be as many as contact
// needs, and keeps energy to second order as long as h is well below 2 / sqrt(K/m).
// Bullet's own way with turning bodies is left out (it loses momentum): a turn keeps a body's
// angular momentum to round-off, and the spin follows from it.
// Everything Bullet keeps from step to step is in the scene's state: bodies made from a state go on
// as those that made it. In double precision.

#include "physics/layered.hpp"
#include "physics/layered_system.hpp"

#include <memory>

namespace physics {

class BulletBodies {
public:
    explicit BulletBodies(const LayeredScene& scene, const LayeredWorld& world);
    ~BulletBodies();
    BulletBodies(const BulletBodies&) = delete;
    BulletBodies& operator=(const BulletBodies&) = delete;

    // Moves them on as they go and turn; `scene` follows.
    void drift(LayeredScene& scene, double dt);

    // Changes their velocities by `share` of the system's forces on them, by weight and air, in dt
    // seconds; hinges hold, and skeletons do not pass stops.
    void push(LayeredScene& scene, const LayeredMoment& moment, const LayeredSystem& system,
              double share, double dt);

private:
    struct World;
    std::unique_ptr<World> world_;
};

}  // namespace physics
