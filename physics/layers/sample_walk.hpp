#pragma once

// Where the samples of a layer are at a moment: each walks along its ray from where it was a step
// ago to the nearest stop.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, III.D and IV.A.
//
//     .--x--. .--x--.     x: f = c, the surface. The sample is valid, a sample of the surface.
//    x   |   b   |   x    b: f_i = max f_j, the border of its skeleton's territory. It waits there,
//    x --o-- b --o-- x       and comes back by itself.
//    x   |   b   |   x    f sums only what blends with the sample's skeleton (o).
//     '--x--' '--x--'
//
// The area that a valid sample stands for on the surface is A(d) / cos(ray, normal); what the rays
// sweep until they stop, over all skeletons, is the volume of the object.
//
// How the volume follows a translation tau_i of one contribution, f_i(r - tau_i): where f = c the
// field grows by -f_i' df/df_i d tau, so the surface moves outward by that over |grad f|, and
//   dV/dtau_i = int_S -f_i' (df/df_i) / |grad f| dA
// over the whole surface that f_i reaches, own territory or not (territories' borders move too, but
// what one loses there the other gains). With dA = A(d) / cos(ray, normal) and cos = -ray . grad f
// / |grad f|, each valid sample adds  A(d) f_i' (df/df_i) / (ray . grad f).

#include "physics/layers/surface_samples.hpp"

#include <span>
#include <vector>

namespace physics {

// Where the samples are at a moment, in the world.
struct SampleWalk {
    std::vector<double> distance;      // N, m, from the skeleton
    std::vector<std::uint8_t> valid;   // N, 1: on the surface
    std::vector<Vec3> position;        // N, m
    std::vector<Vec3> gradient;        // N, of f there
    std::vector<double> area;          // N, m^2 of surface, 0 for those not valid
    std::vector<double> local_volume;  // S, m^3, of each territory
    std::vector<double> volume_slope;  // S, m^2, dV/dtau_i of the whole volume; empty if not asked

    double volume() const;
};

// Walks every sample to its stop, to 1e-12 of the thickness. `before` is where they were a step ago
// (null: on the surface of their skeleton alone). `frames` are those that `field` was made with.
// `slopes`: also how the volume follows translations.
SampleWalk walk(const Field& field, const SurfaceSamples& samples,
                std::span<const Transform> frames, const SampleWalk* before = nullptr,
                bool slopes = false);

// The layer as its samples see it: each skeleton's own mesh as far as any of its corners is valid,
// with normals. For preview: the pieces meet without being joined.
geometry::TriMesh preview_mesh(const SurfaceSamples& samples, const SampleWalk& walk);

}  // namespace physics
