#pragma once

// Which frames a contact pushes, and how.
//
//      o  a           The surface at p is that of the blend of a and b, and moves with both:
//      |\  .--.         df/dt = -(df/df_a) grad f_a . v_a - (df/df_b) grad f_b . v_b
//    -p----o b  )     So a force there pushes both, each by its share of the slope of f. Were it to
//          '--'       push b alone, a would press the layer for nothing, and b would fly off.
//
// Where all that blends at p is on one frame, that frame is pushed.

#include "physics/layered_bodies/layered_system.hpp"

namespace physics {

// Of a contact's speed of parting; a force f that parts it pushes each frame by f along.
struct ContactRows {
    std::vector<FrameRow> rows;
    bool blended = false;  // more than the frames of the two skeletons
};

ContactRows contact_rows(const LayeredScene& scene, const LayeredMoment& moment,
                         const LayeredSystem& system, const LayerContact& contact);

}  // namespace physics
