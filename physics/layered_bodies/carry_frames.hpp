#pragma once

// Cubes that carry the frames of a layer, so that a squashing-cubes model is coated by it.
//
// A frame's place X, the middle of what its skeletons' samples start from, moves as the cubes
// around it do, and it turns by the rotation R nearest to their deformation gradient F there:
//   T = translate(x(X)) R translate(-X) T_0      F_k = (x(X + h e_k) - x(X - h e_k)) / 2h
// Cubes that Simulate moves do not feel what touches the layer; those of cube_base.hpp do.

#include "geometry/cubes/cubes.hpp"
#include "geometry/embed/embed.hpp"
#include "physics/layers/surface_samples.hpp"

namespace physics {

struct CarriedFrames {
    std::shared_ptr<const geometry::TriMesh> probes;  // 7 a frame: X, X +- h e_k
    geometry::Binding binding;                        // of the probes
    std::vector<Vec3> centre;                         // B, X
    double step = 0;                                  // h, m

    std::size_t bytes() const;
};

// Of frames that stand where these samples are drawn. Throws std::invalid_argument when there are
// no cubes.
CarriedFrames bind_frames(std::span<const Transform> frames, const SurfaceSamples& samples,
                          const geometry::Cubes& cubes);

// Where the frames are when corners are at `x` (K, m).
std::vector<Transform> carry(const CarriedFrames& carried, std::span<const Transform> frames,
                             const geometry::Cubes& cubes, std::span<const Vec3> x);

}  // namespace physics
