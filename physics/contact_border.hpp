#pragma once

// Where contact ends: the curve on an object's surface at which it leaves another one.
//
// Object i's surface f_i = c enters the deformed contact surface where f_j = c too, so the border
// is the curve f_i = f_j = c, whatever the seeds. Neighbouring seeds of which one is in contact and
// one is not have it between them: on each such edge of the seeds' mesh the point is found to
// round-off, and with it the curve's tangent, grad f_i x grad f_j. A face of the seeds' mesh that
// the curve cuts gives one piece of it, from point p to point q with tangents t0, t1: the cubic
// with those ends and derivatives L t0, L t1,
//   L = |q - p| / cos^2(delta / 4)     delta: angle between t0 and t1
// (a circle's arc to order 6; any other smooth curve to order 4). The area between chord and cubic
//   1/2 int (P - p) x P' = L (q - p) x (t1 - t0) / 10 - L^2 t0 x t1 / 60
// completes the flat polygon of the face's corners in contact. So a plane contact's area, and its
// radius sqrt(area / pi), converge as the curve does; a curved contact's as flat triangles do, with
// order 2.

#include "physics/layer_contact.hpp"

namespace physics {

// A piece of border inside one face of the seeds' mesh; the contact lies to its left, seen from
// outside the body whose seeds they are.
struct BorderPiece {
    std::uint32_t body, other;
    std::array<Vec3, 2> point;    // m, on both undeformed surfaces
    std::array<Vec3, 2> tangent;  // unit
};

// All that one body has in common with another.
struct ContactPatch {
    std::uint32_t body, other;
    double area = 0;    // m^2, of the common surface
    double length = 0;  // m, of its border
    // Whether every face of the seeds' mesh at this patch lies in one territory: the strips between
    // territories are in no face, and their area is not counted.
    bool whole = true;
};

struct ContactBorder {
    std::vector<BorderPiece> pieces;    // by body, then by face
    std::vector<ContactPatch> patches;  // by body, then by other
};

// `contacts` are those of these bodies. Contact between parts of one body is left out.
ContactBorder find_border(std::span<const ContactBody> bodies, const Contacts& contacts);

}  // namespace physics
