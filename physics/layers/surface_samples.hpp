#pragma once

// Samples of an implicit layer: the rays on which they follow its surface (the paper's "seeds").
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, III.D and IV.A.
//
//    x    x    x        Each skeleton (===) emits samples in fixed directions of its local frame.
//     \   |   /         A sample stands for the rays about its own: at distance d from the skeleton
//  x---=========---x    they cross an area A(d) square to them. Where the samples stop (x) is
//     /   |   \         found by sample_walk.hpp.
//    x    x    x
//
// Offset surfaces change their area by their mean and Gauss curvature alone (Steiner), so
//   A(d) = a0 + a1 d + a2 d^2          V(d) = a0 d + a1 d^2 / 2 + a2 d^3 / 3
// for every kind of skeleton: a0 over faces, a1 along edges (wedges), a2 around corners (a point:
// solid angle d^3 / 3), mixtures over curved ones.

#include "geometry/base/no_index.hpp"
#include "geometry/fields/field.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <vector>

namespace physics {

using geometry::Box;
using geometry::Field;
using geometry::ImplicitLayer;
using geometry::Transform;
using geometry::Vec3;

inline constexpr std::uint32_t no_sample = geometry::no_index;

// Where a layer's samples start and go. Made once for a layer.
struct SurfaceSamples {
    std::vector<std::uint32_t> first;       // S + 1, into the arrays below
    std::vector<Vec3> origin;               // N, m, on the skeleton, in its carrier's frame
    std::vector<Vec3> direction;            // N, unit
    std::vector<double> a0, a1, a2;         // N, m^2, m, 1
    std::vector<geometry::Triangle> faces;  // samples of one skeleton that are neighbours, outward
    std::vector<geometry::Triangle>
        across;  // F, sample beyond the edge opposite each corner, or no_sample
    std::vector<std::uint32_t> valence;  // N, faces at each sample
    std::vector<double> core;            // S, m^3, volume of a solid skeleton itself
    std::vector<std::uint32_t> frame;    // S

    // The area that the rays of sample i cross at distance d, square to them, m^2.
    double crossed(std::size_t i, double d) const { return a0[i] + d * (a1[i] + d * a2[i]); }
    // What they sweep up to there, m^3.
    double swept(std::size_t i, double d) const
    {
        return d * (a0[i] + d * (a1[i] / 2 + d * a2[i] / 3));
    }
    std::size_t count() const { return origin.size(); }
    std::size_t skeletons() const { return core.size(); }
};

// About one sample each `spacing` m on the surface that each skeleton has alone, of a stretched one
// farther apart along its long axes and nearer across; a plane emits none. Throws
// std::invalid_argument for a spacing that is not positive, or so small that a skeleton would emit
// more than 10 million.
SurfaceSamples make_surface_samples(const ImplicitLayer& layer, double spacing);

}  // namespace physics
