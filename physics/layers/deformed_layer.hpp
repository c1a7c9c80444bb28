#pragma once

// The surface of a layer as contacts deform it.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, III; the formulas are restated or our own (their copies are lost).
//
//     undeformed            deformed
//    .---.  .---.          .---.|.---.     |: where i meets a soft j both end at f_i = f_j
//   /     \/     \        /    ,|.    \    , .: past the contact's border each bulges, where
//  (  i   /\  j   )      (   i  |  j   )    what is pressed away goes
//   \     \/     /        \    '|'    /
//    '---'  '---'          '---'|'---'     A rigid j keeps f_j = c, and i fits it.
//
// With m(P) = max f_j over the other soft objects and q(P) = max f_j over the rigid ones, all of
// isovalue c, the deformed field of object i is
//   D_i = min(f_i + G, 2c - q),   G = c - m inside a soft object (m >= c): compression
//                                 G = 0 inside a rigid one
//                                 G = A(t) outside all: the bulge (bulge.hpp)
//
// Where i meets a soft j, D_i = c is f_i + (c - f_j) = c, that is f_i = f_j, and so is D_j = c: one
// surface, whatever else happens. Where it meets a rigid j it is f_j = c: i fits j. Where three
// meet, each keeps the part of space where its own field is the largest.
// G is C1 where m = c, so a soft surface leaves the contact without a crease.
//
// Parts of i that do not blend, where they collide, are each other's j: at a point in the territory
// of one skeleton all that it does not blend with is another soft object. They do not cut each
// other, since what both hold belongs to i, but they bulge.

#include "geometry/fields/iso_field.hpp"
#include "physics/layers/bulge.hpp"

namespace physics {

// D at a block's points, and what made it so.
struct DeformedValues {
    static constexpr std::size_t capacity = geometry::FieldBlock::capacity;
    geometry::BlockValues D;
    std::uint32_t soft[capacity], rigid[capacity];  // the party of the largest m, q, or no_party
    double f[capacity], m[capacity], q[capacity];   // of D's equation
    double m_slope[capacity], q_slope[capacity];    // |grad m|, |grad q|
    bool fits[capacity];                            // to a rigid one: D = 2c - q
};

void evaluate(const Meeting& meeting, const Bulges& bulges, const geometry::FieldBlock& block,
              DeformedValues& out);

// How high the bulges of `body` are: a share of the largest compression between it and each.
Bulges bulges_of(std::span<const ContactBody> bodies, std::uint32_t body,
                 std::span<const LayerContact> contacts);

// D_i of body `i`, to polygonize or to ask. The bodies must outlive it.
struct DeformedLayer {
    std::span<const ContactBody> bodies;
    std::uint32_t body = 0;
    Bulges bulges;
};
DeformedLayer deformed(std::span<const ContactBody> bodies, std::uint32_t body,
                       const Contacts& contacts);
geometry::FieldValue value_at(const DeformedLayer& layer, const Vec3& p);
geometry::IsoField iso_field(const DeformedLayer& layer);

}  // namespace physics
