#pragma once

// Contact between implicit layers: exact common surfaces, and the forces they carry.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, III and V.A; the formulas are restated or our own (their copies are lost).
//
// With m(P) = max f_j over the other soft objects and q(P) = max f_j over the rigid ones, all of
// isovalue c, the deformed field of object i is
//   D_i = min(f_i + G(c - max(m, min(q, c))), 2c - q)
//   G(s) = s                               s < 0: compression
//   G(s) = h u (1 - u)^2 + a u^2 (3 - 2u)  0 <= s <= h, u = s / h: bulge, rises with slope 1 to a
//   G(s) = a (1 - v)^2 (1 + 2v)            h <= s <= 2h, v = s / h - 1: falls to 0
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
//
// Response: stiffness is |grad f|, so the radial force on i is, per area of the deformed surface,
//   K g N,  g = c - f_j = c - f_i < 0 (rigid j: g = c - f_i), N outward normal: it pushes inward
//   K = 2 K_i K_j / (K_i + K_j) (two layers in series; equal ones keep their own), rigid j: K_i
// and lambda (V_j - V_i), friction and damping; against a rigid j its part along the surface is no
// more than `grip` times the pressure. Both objects' seeds sample a common surface: each
// carries half, and every force acts on both objects, at the same point, with opposite signs. What
// a seed at the contact's rim stands for is cut there (contact_rim.hpp).

#include "geometry/polygonize.hpp"
#include "physics/seeds.hpp"

#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace physics {

// How a layer behaves in contact.
struct LayerMatter {
    double stiffness = 1e4;     // K, N/m^2 per unit of the field
    double friction = 100;      // lambda, N s/m^3: per area and relative velocity
    double bulge_width = 0.1;   // w, m, how far beyond a contact the layer bulges
    double bulge_height = 0.5;  // alpha, of the largest compression
    // Of rigid ones: the largest traction along the surface, as a share of the pressure (Coulomb).
    double grip = std::numeric_limits<double>::infinity();
    bool rigid = false;         // does not deform, others fit it; needs no seeds
    bool self_contact = false;  // skeletons that do not blend with each other collide
};

// A mesh that changes its shape: where its vertices were `seconds` ago.
struct MovingMesh {
    std::shared_ptr<const geometry::SkeletonMesh> now;
    std::shared_ptr<const geometry::TriMesh> before;  // of the same topology
    double seconds = 0;
};

// Velocity of a carrier's frame.
struct Twist {
    Vec3 linear = Vec3::Zero();   // m/s, of the frame's origin
    Vec3 angular = Vec3::Zero();  // rad/s
};

// One object, as it stands now. What the pointers name must outlive the call.
struct ContactBody {
    const Field* field = nullptr;
    const Seeds* seeds = nullptr;    // null: emits none
    const SeedWalk* walk = nullptr;  // of those seeds on that field
    std::span<const Transform> frames;
    std::span<const Twist> twists;            // one a frame
    std::span<const std::uint32_t> frame_of;  // S, frame of each skeleton
    LayerMatter matter;
    const MovingMesh* moving = nullptr;  // null: moves with its frames alone
};

// A seed on a common surface.
struct LayerContact {
    std::uint32_t body, seed;             // whose seed it is
    std::uint32_t skeleton;               // which one emitted it
    std::uint32_t other, other_skeleton;  // what it touches: body and territory
    Vec3 position;                        // m, on the deformed surface
    Vec3 normal;                          // outward from `body`
    double area;                          // m^2, of the deformed surface, inside the contact
    double compression;                   // -g, units of the field
    double load;                          // m^2, of -g over what the seed stands for
    double distance;                      // m, along the seed's ray
    Vec3 force;                           // N, on `body`; its opposite acts on `other`
};

// A point of a skeleton that another body comes near to: there the layer has nothing left to give.
// Contact is exact only while skeletons themselves stay out of other bodies: f_i >= f_j on them,
// f_j <= c for a rigid j. To first order the point may move by `gap` against `normal` until then.
struct LayerStop {
    std::uint32_t body = 0, skeleton = 0;
    std::uint32_t other = 0, other_skeleton = 0;           // body and territory
    Vec3 position = Vec3::Zero();                          // m, on the skeleton
    Vec3 normal = Vec3::Zero();                            // outward from `other`
    double gap = std::numeric_limits<double>::infinity();  // m; below 0: it is inside
    // m/s: how fast a mesh that changes its shape comes on along `normal` by doing so.
    double closing = 0;
};

struct Wrench {
    Vec3 force = Vec3::Zero();   // N
    Vec3 torque = Vec3::Zero();  // N m, about the frame's origin
};

struct Contacts {
    std::vector<LayerContact> contacts;  // by body, then by seed
    // By body, then by skeleton: of each that a seed's ray meets another body on its inner half,
    // the point of least gap to that body.
    std::vector<LayerStop> stops;
    std::vector<std::vector<Wrench>> wrenches;  // one a body and frame
    std::vector<double> compression;            // one a body: the largest, units of the field
    // One a body: how deep, m, its deformed surface stands inside another's at worst, at its seeds.
    // By construction round-off, except where a skeleton itself has gone into another body.
    std::vector<double> penetration;
};

// Which contacts there are now. All bodies must share one isovalue. Throws std::invalid_argument
// where they do not, or where a body's parts do not fit each other.
Contacts find_contacts(std::span<const ContactBody> bodies);

// The response's K and lambda along the normal and along the surface, at a contact.
struct ContactLaw {
    double stiffness = 0;           // K, N/m^2 per unit of the field
    double damping = 0, along = 0;  // N s/m^3
};
ContactLaw contact_law(std::span<const ContactBody> bodies, const LayerContact& contact);

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

// Volume of each of a body's territories as contacts leave it, bulges not counted. m^3
std::vector<double> local_volumes(std::span<const ContactBody> bodies, std::uint32_t body,
                                  const Contacts& contacts);

// The seeds with those in contact moved onto their common surfaces, for preview_mesh().
SeedWalk deformed(const SeedWalk& walk, std::uint32_t body, const Contacts& contacts);

}  // namespace physics
