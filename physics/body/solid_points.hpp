#pragma once

// Contact of solids with sheets as the points of the solids find it: between the corners of its
// cells a sheet is met by points of what is smaller than a cell, or pointed, or comes fast. (What
// corners of sheets find in solids: posed_solids.hpp.)
//
//   cells in boxes along their way -> points of a solid's cube -> triangles
//     -> how they stand at the start, at the end, or where they meet on the way -> plane
//
// Which side of a sheet a point is kept on is told, in this order, by the grip that the step before
// left on the cell or on one beside it, by where it stands at the start when it is near, by the way
// that it comes through, and by where it stands at the end. Where it is so near that the solid may
// just have gone in, it is kept on the side that the solid lies on there.

#include "physics/body/collider_contact.hpp"
#include "physics/body/corner_body.hpp"
#include "physics/body/plane_touch.hpp"

#include <span>
#include <vector>

namespace physics {

// A step in which corners go from x0 to x1, by slot, four numbers each.
struct SolidPointStep {
    const double* x0;
    const double* x1;
    double dt = 0;                          // s
    const std::vector<Grip>& held;          // that it began with
    std::uint32_t first_other = 0;          // what is touched is numbered from there, by triangle
    std::span<const PosedCollider> solids;  // at x1
};

// The planes of all points of solids that meet a sheet of `body`, which has both, or come near,
// in_order(). They are numbered as points of the body's surface.
std::vector<PlaneTouch> find_solid_points(const CornerBody& body, const SolidPointStep& step);

}  // namespace physics
