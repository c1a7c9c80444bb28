#pragma once

// Seeds: samples of an implicit layer that follow its surface.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, III.D and IV.A.
//
// Every skeleton emits seeds in fixed directions of its local frame. A seed stands for the rays
// about its own: at distance d from the skeleton they cross an area A(d) square to them. Offset
// surfaces change their area by their mean and Gauss curvature alone (Steiner), so
//   A(d) = a0 + a1 d + a2 d^2          V(d) = a0 d + a1 d^2 / 2 + a2 d^3 / 3
// for every kind of skeleton: a0 over faces, a1 along edges (wedges), a2 around corners (a point:
// solid angle d^3 / 3), mixtures over curved ones.
//
// A seed walks along its ray from where it was a step ago to the nearest stop:
//   f = c        the surface: it is valid, a sample of the surface; or
//   f_i = max f_j, the border of its skeleton's territory: it waits there, and comes back by
//   itself.
// f sums only what blends with the seed's skeleton. The area that a valid seed stands for on the
// surface is A(d) / cos(ray, normal); what the rays sweep until they stop, over all skeletons, is
// the volume of the object.
//
// How the volume follows a translation tau_i of one contribution, f_i(r - tau_i): where f = c the
// field grows by -f_i' df/df_i d tau, so the surface moves outward by that over |grad f|, and
//   dV/dtau_i = int_S -f_i' (df/df_i) / |grad f| dA
// over the whole surface that f_i reaches, own territory or not (territories' borders move too, but
// what one loses there the other gains). With dA = A(d) / cos(ray, normal) and cos = -ray . grad f
// / |grad f|, each valid seed adds  A(d) f_i' (df/df_i) / (ray . grad f).

#include "geometry/field.hpp"
#include "geometry/mesh.hpp"

#include <span>
#include <vector>

namespace physics {

using geometry::Box;
using geometry::Field;
using geometry::ImplicitLayer;
using geometry::Transform;
using geometry::Vec3;

constexpr std::uint32_t no_seed = 0xffffffff;

// Where a layer's seeds start and go. Made once for a layer.
struct Seeds {
    std::vector<std::uint32_t> first;       // S + 1, into the arrays below
    std::vector<Vec3> origin;               // N, m, on the skeleton, in its carrier's frame
    std::vector<Vec3> direction;            // N, unit
    std::vector<double> a0, a1, a2;         // N, m^2, m, 1
    std::vector<geometry::Triangle> faces;  // seeds of one skeleton that are neighbours, outward
    std::vector<geometry::Triangle>
        across;                          // F, seed beyond the edge opposite each corner, or no_seed
    std::vector<std::uint32_t> valence;  // N, faces at each seed
    std::vector<double> core;            // S, m^3, volume of a solid skeleton itself
    std::vector<std::uint32_t> frame;    // S

    // What the rays of seed i sweep up to distance d, m^3.
    double swept(std::size_t i, double d) const
    {
        return d * (a0[i] + d * (a1[i] / 2 + d * a2[i] / 3));
    }
    std::size_t count() const { return origin.size(); }
    std::size_t skeletons() const { return core.size(); }
};

// About one seed each `spacing` m on the surface that each skeleton has alone; a plane emits none.
// Throws std::invalid_argument for a spacing that is not positive, or so small that a skeleton
// would emit more than 10 million.
Seeds make_seeds(const ImplicitLayer& layer, double spacing);

// Where the seeds are at a moment, in the world.
struct SeedWalk {
    std::vector<double> distance;      // N, m, from the skeleton
    std::vector<std::uint8_t> valid;   // N, 1: on the surface
    std::vector<Vec3> position;        // N, m
    std::vector<Vec3> gradient;        // N, of f there
    std::vector<double> area;          // N, m^2 of surface, 0 for those not valid
    std::vector<double> local_volume;  // S, m^3, of each territory
    std::vector<double> volume_slope;  // S, m^2, dV/dtau_i of the whole volume; empty if not asked

    double volume() const;
};

// Walks every seed to its stop, to 1e-12 of the thickness. `before` is where they were a step ago
// (null: at their skeleton's thickness). `frames` are those that `field` was made with.
// `slopes`: also how the volume follows translations.
SeedWalk walk(const Field& field, const Seeds& seeds, std::span<const Transform> frames,
              const SeedWalk* before = nullptr, bool slopes = false);

// The layer as its seeds see it: each skeleton's own mesh as far as any of its corners is valid,
// with normals. For preview: the pieces meet without being joined.
geometry::TriMesh preview_mesh(const Seeds& seeds, const SeedWalk& walk);

}  // namespace physics
