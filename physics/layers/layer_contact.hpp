#pragma once

// Contact between implicit layers: which samples touch, and the forces they carry.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, V.A. The common surfaces are those of deformed_layer.hpp.
//
//   skeleton o---------->x     A sample waits where its ray leaves the undeformed layer (x). Where
//            o------>|   x     D < c there it goes back along the ray to D = c, the common surface
//            o------>|   x     (|): that is a contact.
//            o---------->x
//
// Response: stiffness is |grad f|, so the radial force on i is, per area of the deformed surface,
//   K g N,  g = c - f_j = c - f_i < 0 (rigid j: g = c - f_i), N outward normal: it pushes inward
//   K = 2 K_i K_j / (K_i + K_j) (two layers in series; equal ones keep their own), rigid j: K_i
// and lambda (V_j - V_i), friction and damping; against a rigid j its part along the surface is no
// more than `grip` times the pressure. Both objects' samples lie on a common surface: each carries
// half, and every force acts on both objects, at the same point, with opposite signs. What a sample
// at the contact's rim stands for is cut there (layer_contact_rim.hpp).

#include "physics/layers/contact_types.hpp"

namespace physics {

// Which contacts there are now. All bodies must share one isovalue. Throws std::invalid_argument
// where they do not, or where a body's parts do not fit each other.
Contacts find_contacts(std::span<const ContactBody> bodies);

// The response's K and lambda along the normal and along the surface, at a contact.
struct LayerContactLaw {
    double stiffness = 0;           // K, N/m^2 per unit of the field
    double damping = 0, along = 0;  // N s/m^3
};
LayerContactLaw contact_law(std::span<const ContactBody> bodies, const LayerContact& contact);

// Volume of each of a body's territories as contacts leave it, with its bulges. m^3
std::vector<double> local_volumes(std::span<const ContactBody> bodies, std::uint32_t body,
                                  const Contacts& contacts);

// The samples with those in contact moved onto their common surfaces, and others onto bulges, for
// preview_mesh().
SampleWalk deformed(const SampleWalk& walk, std::uint32_t body, const Contacts& contacts);

}  // namespace physics
