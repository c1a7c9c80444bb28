#pragma once

// Where skeletons come near to other bodies.
//
//      ,------------.        Contact is exact as long as skeletons (o) stay out of other bodies:
//     (   i   o<-gap-|---.   there the layer has nothing left to give. A stop tells how far the
//      '------------'  j  )  point of a skeleton may still go against `normal`.
//                    '---'
//
// Only points whose samples' rays end on the inner half of the layer are looked at.

#include "physics/layers/meeting.hpp"

namespace physics {

// Adds where `origins`, points of one skeleton, stand to what its rays meet on their inner half.
void find_stops(const Meeting& meeting, std::uint32_t skeleton, const std::vector<Vec3>& origins,
                std::vector<LayerStop>& stops);

// How point p stands to a rigid body; the gap infinite where it has no skeleton near.
LayerStop stop_at_rigid(const Field& field, const Party& other, const Vec3& p);

// Tells a stop at p whose skeleton it is of, against whom, and how fast that closes in by itself.
void tell_parties(const Meeting& meeting, std::uint32_t skeleton, const Party& other, const Vec3& p,
                  LayerStop& stop);

// Adds a stop, or keeps the nearer one of two of one skeleton against one body. Stops of one
// skeleton follow each other.
void add_stop(const LayerStop& stop, std::vector<LayerStop>& stops);

}  // namespace physics
