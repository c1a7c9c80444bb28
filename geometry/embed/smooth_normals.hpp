#pragma once

// Normals of an embedded mesh that run on smoothly from cube to cube. The deformation gradient of
// trilinear interpolation jumps at the faces of cubes, and light shows each cube as a tile. Here
// each corner has the mean of the gradients that the cubes around it have there, which is a central
// difference, and the gradient at a normal is interpolated between its corners:
//
//   F_k = mean over cubes around k of F(k),   F(p) = sum_a N_a(p) F_a,   normal = cof(F) N
//
// It is continuous, exact for affine motion, and inside a body of second order in the cubes' size,
// where that of one cube is of first order.

#include "geometry/embed/bind.hpp"

#include <span>

namespace geometry {

// Gives `carried`, which embed() made of `rest`, such normals. Cubes that are `torn` (C, or empty)
// take no part; what lies at no corner of others keeps the normal that it has. On a plane the
// gradients along it are averaged, and its turning normals stand for those across it. Changes
// nothing on a sheet, where embed() gives such normals itself (sheet_motion.hpp).
void smooth_normals(TriMesh& carried, const Binding& binding, const TriMesh& rest,
                    const Cubes& cubes, std::span<const Vec3> x,
                    std::span<const std::uint8_t> torn = {});

}  // namespace geometry
