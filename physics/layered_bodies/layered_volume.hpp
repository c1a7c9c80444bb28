#pragma once

// What a step sees of each body's volume, and how controllers keep it (volume_control.hpp).

#include "physics/layered_bodies/layered_moment.hpp"

namespace physics {

// What the samples of body number b saw: distances, volumes, how deep it stands in others.
void keep_seen(const LayeredMoment& moment, std::uint32_t b, LayeredState& state);

// What a part is told to seek of each territory's volume, on the way from one frame to the next.
std::vector<double> sought(const LayeredPart& from, const LayeredPart& to, double share);

// Moves the contributions as the controllers of `control` do in dt seconds, in which the inflation
// sought goes from state.inflation to `after`.
void keep_volume(const LayeredBody& body, const VolumeControl& control, const SampleWalk& walk,
                 const std::vector<double>& after, double dt, LayeredState& state);

// The last step's motion has changed volumes since the controllers saw them. Mends that before
// anybody looks, by Newton steps in which nothing moves; leaves what the last walk saw. Warns of
// bodies that do not reach the volume that they seek.
void settle_volumes(LayeredScene& now, double mesh_seconds);

}  // namespace physics
