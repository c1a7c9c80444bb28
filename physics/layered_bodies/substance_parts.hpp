#pragma once

// Soft substances come apart and fuse: which of a body's skeletons blend with each other.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, VI.
//
//     (o o)(o o)        (o o) (o o)        (o o)|(o o)         (o o : o o)
//      one part     ->   out of reach  ->    collide     ->    press hard: links grow
//                        of each other:      as two            to 1, then one part again
//                        two parts           bodies do

#include "physics/layered_bodies/layered_moment.hpp"

namespace physics {

// Parts of a soft substance. A part falls into what chains of overlapping spheres of influence hold
// together; what once came apart comes together by fusion only. Where two parts press harder than
// the threshold, the pair of skeletons there starts to blend, over `fusion_time`; from the first
// pair that blends fully the others in reach follow; parts of which all pairs in reach blend fully
// become one, which changes nothing in the field. `number`: of the body, in the moment.
void update_parts(const LayeredBody& body, std::uint32_t number, const LayeredMoment& moment,
                  double dt, LayeredState& state);

// Particles of soft substances whose state is a number, and the pieces that they make.
std::size_t particle_count(const LayeredScene& scene);
std::size_t piece_count(const LayeredScene& scene);

}  // namespace physics
