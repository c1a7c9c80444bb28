#pragma once

// Where contact ends: the curve on which two surfaces part, and the area that it encloses.
//
//     o-------o-------o
//      \     / \     /       o: samples on i's surface, free of j     #: in contact with j
//     --*---*---*---*--      *: points of the border, where f_i = f_j = c: one on each edge between
//        \ /     \ /         a # and an o, found to round-off. In each face that the border cuts
//         #-------#          one piece of it joins two such points. The contact's area is that of
//                            faces of three #, and of what is inside of the faces that are cut.
//
// Object i's surface f_i = c enters the deformed contact surface where f_j = c too, so the border
// is the curve f_i = f_j = c, whatever the samples. Its tangent is grad f_i x grad f_j. A piece
// from point p to point q with tangents t0, t1 is the cubic with those ends and derivatives L t0,
// L t1,
//   L = |q - p| / cos^2(delta / 4)     delta: angle between t0 and t1
// (a circle's arc to order 6; any other smooth curve to order 4). The area between chord and cubic
//   1/2 int (P - p) x P' = L (q - p) x (t1 - t0) / 10 - L^2 t0 x t1 / 60
// completes the flat polygon of the face's corners in contact. So a plane contact's area, and its
// radius sqrt(area / pi), converge as the curve does; a curved contact's as flat triangles do, with
// order 2.

#include "physics/layers/contact_types.hpp"

namespace physics {

// A piece of border inside one face of the samples' mesh; the contact lies to its left, seen from
// outside the body whose samples they are.
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
    // Whether every face of the samples' mesh at this patch lies in one territory: the strips
    // between territories are in no face, and their area is not counted.
    bool whole = true;
};

struct LayerContactBorder {
    std::vector<BorderPiece> pieces;    // by body, then by face
    std::vector<ContactPatch> patches;  // by body, then by other
};

// `contacts` are those of these bodies. Contact between parts of one body is left out.
LayerContactBorder find_border(std::span<const ContactBody> bodies, const Contacts& contacts);

}  // namespace physics
