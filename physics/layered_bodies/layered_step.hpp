#pragma once

// Moves layered scenes: base structures and the layers that coat them, stepped together.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997. What is ours is said where it stands.
//
// A step of dt seconds:
//   1. fields from frames and translations, samples walk      layered_moment.hpp, sample_walk.hpp
//   2. contacts and their forces                              layer_contact.hpp
//   3. controllers move the contributions by tau so that territories, as contacts leave them, keep
//      their volume                                           layered_volume.hpp
//   4. the base: all forces with their stiffness and damping in one backward Euler step,
//        (M + dt C + dt^2 K) dv = dt (f - dt K v)             layered_system.hpp,
//        layered_forces.hpp
//      K, C from contacts, joints, springs, particles and squashing cubes, each a symmetric pair
//      term, so that what one body gets the other loses: momentum is kept to the solver's 1e-10.
//      (The paper integrates explicitly; this stays stable for stiff layers and long steps.)
//      Or, chosen by the scene, Bullet moves rigid bodies explicitly: layered_bullet.hpp.
//   5. soft substances: who may blend with whom               substance_parts.hpp
// What comes on so fast that it could cross a layer between two steps gets more of them:
// step_length.hpp. After the last step of a frame bodies that control their volume are walked once
// more, and what the last motion changed of it is mended, by Newton steps in which nothing moves.

#include "physics/layered_bodies/layered.hpp"

#include <span>

namespace physics {

// Everything where its part's pose puts it, at its velocity, with the volume that it seeks.
LayeredScene start(std::vector<LayeredPart> parts);

// Throws std::invalid_argument where Bullet is to move what it cannot: particles, cubes, led
// bodies.
void check_rigid_bodies(std::span<const LayeredPart> parts, RigidBodies rigid_bodies);

// The scene dt seconds later, in at least `substeps` equal steps: in more where bodies near each
// other would come on by more than two fifths of a layer in one, or where they swing too fast for
// Bullet; the report warns where 64 times as many are not enough. `parts` are told for its end:
// still and led ones move there, straight and at constant spin. Throws std::invalid_argument where
// they are not the bodies of the scene (as many, with the same frames and skeletons), and as
// check_rigid_bodies() does; never for what happens.
LayeredScene advance(const LayeredScene& scene, std::vector<LayeredPart> parts,
                     const LayeredWorld& world, double dt, int substeps);

}  // namespace physics
