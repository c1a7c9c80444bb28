#pragma once

// Solids on the corners and edges of colliders, between the points of their own surface.
//
// A point of a collider (collider_features.hpp) that lies in a cube of a part, or just before it,
// is found in the part's shape at rest as a point of another part is (part_contact.hpp): by its gap
// g and the normal N there, out of the part. The place of the cube where it lies is then kept
// before a plane of the collider, as a point of the surface would be:
//   n = -N,   g(x) = g + n . (sum w_a x_a - c)
// with c the point's place and w the weights of the place in the cube.

#include "physics/body/collider_contact.hpp"

#include <vector>

namespace physics {

// Corners at x that move at v (four numbers a slot), which came there within dt seconds.
struct SolidsOverEdges {
    const CornerBody& body;
    const double* x;
    const double* v;
    const std::vector<PosedCollider>&
        colliders;    // and solids behind them, which touch sheets alone
    double dt;        // s
    double stiffest;  // N/m, of a point at rest
};

// Adds the planes of all such points that are inside, or nearer than known_before cubes. They are
// numbered behind all that are there, and stay in_order().
void add_feature_touches(const SolidsOverEdges& scene, std::vector<PlaneTouch>& out);

}  // namespace physics
