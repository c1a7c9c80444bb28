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
//   D_i = min(f_i + G(c - max(m, min(q, c))), 2c - q)
//
//   G(s) |        a .-"-.             s < 0          G = s: compression
//        |       .'      '.           0 <= s <= h    G = h u (1 - u)^2 + a u^2 (3 - 2u), u = s / h:
//        |     .'          '.                        the bulge, rises with slope 1 to a
//   -----+---.'---------------'._--   h <= s <= 2h   G = a (1 - v)^2 (1 + 2v), v = s / h - 1:
//        | .' 0       h        2h s                  falls to 0
//        |'
//
// Where i meets a soft j, D_i = c is f_i + (c - f_j) = c, that is f_i = f_j, and so is D_j = c: one
// surface, whatever else happens. Where it meets a rigid j it is f_j = c: i fits j. Where three
// meet, each keeps the part of space where its own field is the largest.
// G is C1 at s = 0, so a soft surface leaves the contact without a crease. The bulge takes its
// distance in units of the field, s = c - f_j, in place of the metres along j's gradient to its
// surface: near it the same to first order, without a search, and the gradient of D_i is exact.
// Its reach is 2h = min(k w, c, 6 a), its height a = min(alpha * largest compression, h): beyond
// 6a the cubic would overshoot a, so that a bulge grows from nothing as a contact begins.
// Then G(s) <= s, so bulges of two objects do not meet: on i's surface c - f_i = G(c - f_j) <=
// c - f_j, that is f_i >= f_j; on j's it is the other way round.

#include "geometry/fields/iso_field.hpp"
#include "physics/layers/meeting.hpp"

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

// `a`, `h`: height of the bulge and half its reach, in units of the field; 0 for none.
void evaluate(const Meeting& meeting, double a, double h, const geometry::FieldBlock& block,
              DeformedValues& out);

// D_i of body `i`, to polygonize or to ask; `compression` is that of Contacts. The bodies must
// outlive it.
struct DeformedLayer {
    std::span<const ContactBody> bodies;
    std::uint32_t body = 0;
    double bulge = 0, half_reach = 0;  // a, h
};
DeformedLayer deformed(std::span<const ContactBody> bodies, std::uint32_t body,
                       const Contacts& contacts);
geometry::FieldValue value_at(const DeformedLayer& layer, const Vec3& p);
geometry::IsoField iso_field(const DeformedLayer& layer);

}  // namespace physics
