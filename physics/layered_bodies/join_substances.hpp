#pragma once

// Soft substances that several bodies are of: pieces of one substance come apart and fuse by the
// pressure between them, whichever body they began in.
//
//     body 0 "dough"   body 1 "dough"         one body
//        (o o)            (o o)        ->    (o o) | (o o)      parts that collide, until they
//                                                                fuse: substance_parts.hpp

#include "physics/layered_bodies/layered.hpp"

namespace physics {

// The parts, of which those whose substances have one name are one part, in the place of the first
// of them: its parts for blending are theirs. The colour is the first one's. Throws
// std::invalid_argument, naming the parts and what differs, where two of one name are not of one
// matter, or blend wherever they meet.
std::vector<LayeredPart> join_substances(std::vector<LayeredPart> parts);

}  // namespace physics
