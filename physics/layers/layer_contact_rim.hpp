#pragma once

// Samples at the rim of a contact: how much of what they stand for lies inside it.
//
//      pressure                    The force of a contact is the sum over its samples of pressure
//      |   *                       times area. Inside, where samples lie in a lattice, such a sum
//      | *   *                     errs by next to nothing. At the rim (r) each sample is in or out
//      *------r*------*--          as a whole, and the error is uneven: order 2.5 at best. So the
//                                  faces that the rim cuts are integrated as they are.
//
// With, at each sample,
//   w = 3 area / valence      what each of its faces would have of it, tripled
//   v = w p                   p: compression; below 0 outside the rim, where f_i = f_j goes on from
//                             values and slopes at the sample, to first order
// the sum gives a face  sum of v / 3 over its corners inside; the integral of the plane through v,
// cut at v = 0, is for a face of one corner inside, s and t the shares of its two edges inside,
//   1: s t v / 3      2: the whole less the same for the corner outside
// Each edge bends by D = v_k' + v_k - v_i - v_j, k and k' the corners to both its sides; along
// edges of a lattice the second derivatives are D_i + D_j, and what that takes from a corner of the
// face, or from all of it (sum D / 12), goes too. Over a closed lattice the sum of all D is 0, so
// what whole faces take is found at cut ones alone: each sample has +1 of D from an edge that it
// faces, -1 from its own.

#include "physics/layers/contact_types.hpp"

namespace physics {

// Sets `load` of all contacts, and `area` of those at rims to what lies inside. Contacts of one
// body must follow each other by sample. Those between parts of one body stay as they are, as do
// rims that end at a territory's border, and faces whose corners stand for areas more than four
// times as large as others'.
void weigh_rims(std::span<const ContactBody> bodies, std::vector<LayerContact>& contacts);

}  // namespace physics
