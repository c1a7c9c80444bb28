#pragma once

// Where samples that touch nothing are on the surface that is drawn.
//
//   skeleton o---------->x->|   A sample waits where its ray leaves the undeformed layer (x), and
//            o--------->x-->|   goes on to D = c, the bulge (|), but not out of its skeleton's
//            o---------->x->|   territory. So volumes are those of the surface that is drawn, and
//                               the preview shows it.
//
// Where skeletons do not blend with each other, x lies on the field of those that blend with its
// own skeleton alone, as contact between parts needs it. The surface that is drawn is that of all,
// and differs where a third skeleton blends with two that do not: it may be inward from there.

#include "physics/layers/contact_types.hpp"

namespace physics {

// Fills `contacts.drawn`; its contacts are complete.
void find_drawn(std::span<const ContactBody> bodies, Contacts& contacts);

}  // namespace physics
