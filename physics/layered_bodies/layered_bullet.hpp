#pragma once

// Rigid frames of a layered scene as Bullet's bodies, their hinges as its joints.
// Bullet finds no collisions here: what layers do to each other comes as forces and torques, found
// where the bodies stand in the middle of a step,
//   x += h/2 v,   v += h M^-1 f(x) and what joints and stops need,   x += h/2 v.
// Under weight alone this is exact for every h, so that a frame may have as many steps as contact
// needs; it keeps energy to second order as long as h is well below 2 / sqrt(K/m).
// Bullet's own integration of rotation is left out (it loses momentum): here a rotation keeps a
// body's angular momentum to round-off, and the spin follows from it.
// Everything Bullet keeps from step to step is in the scene's state: bodies made from a state
// continue exactly as those that made it. In double precision.

#include "physics/layered_bodies/layered_system.hpp"

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
