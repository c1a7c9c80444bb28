#pragma once

// Sheets on the edges and corners of colliders, between the points of the sheet. Points that lie on
// both sides of an edge do not keep it from standing through the cell between them.
//
// Near each point the collider lies behind a plane, g_i(p) = n_i . (p - q_i). Along a side of a
// cell, from p in direction d, two planes of which one falls and one rises hold
//   n = sum l_i n_i / |sum l_i n_i|,  l_i >= 0,  n . d = 0,   g = sum l_i g_i(p) / |sum l_i n_i|
// where n is across the side and the edge in which the planes meet, and g is how far they are
// apart there. Three planes do the same for a corner within a triangle, with n across that. Where
// the collider is not what the planes tell, as where it is round, it is asked at the place found,
// and the plane there takes the place of one of them (Kelley. The cutting-plane method for solving
// convex programs. J. SIAM 8(4), 1960).

#include "physics/body/collider_contact.hpp"

#include <vector>

namespace physics {

// Of a vector over corners, that of one slot.
inline Vec3 corner_place(const double* field, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{slot});
}

// Where a corner of a sheet stands to a collider.
struct CornerStand {
    std::uint32_t slot = 0, other = 0;  // the corner and the collider
    Vec3 normal = Vec3::UnitY();        // out of the collider, on the sheet's side of it
    double gap = 0;                     // m, to the collider, whatever the thickness of both
    Vec3 velocity = Vec3::Zero();       // m/s, of the collider there
};

// Corners of sheets at x that move at v.
struct SheetOverEdges {
    const CornerBody& body;
    const double* x;
    const double* v;
    const std::vector<PosedCollider>& colliders;
    double dt;        // s
    double stiffest;  // N/m, of a point at rest
    const std::vector<CornerStand>& stands;
};

// Adds that of a point that stands to a collider as `touch` tells, where it is a corner.
void add_stand(const PosedCollider& collider, const PlaneTouch& point, const Touch& touch,
               std::vector<CornerStand>& out);

// Adds the planes of all edges and corners that are inside, or nearer than known_before cells.
// Sides of cells and triangles are numbered as points are, behind all of the surface: what is
// in_order() stays so.
void add_edge_touches(const SheetOverEdges& scene, std::vector<PlaneTouch>& out);

}  // namespace physics
