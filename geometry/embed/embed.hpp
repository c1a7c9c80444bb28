#pragma once

// A mesh carried by cubes: each vertex moves with the trilinear interpolation of the displacements
// of its cube's corners. Any mesh on any cubes.
// Sederberg, Parry. Free-form deformation of solid geometric models. SIGGRAPH 1986; here with one
// trilinear cell for each cube.
//
//   u(p) = sum_a N_a(p) u_a,   N_a = prod_d (a_d ? p_d : 1 - p_d),   p in 0..1 in its cube
//   x = X + u,   F = I + grad u,   normal = cof(F) N / |cof(F) N|,   cof(F) = det(F) F^-T
//
// A vertex in no cube goes with the nearest one by the affine map that touches u at an anchor q of
// it (bind.hpp): u(p) = u(q) + grad u(q) (p - q), which continues u smoothly.
// All are exact for affine motion, so forces handed back keep their sum and their torque.
//
// On a plane (geometry/cubes/plane.hpp) vertices keep their height above or below it, along its
// turning normals: however far that is, who lies over or under a cell is in it. How vertices move
// with a sheet (geometry/cubes/sheet.hpp) is in sheet_motion.hpp. On both, weights are those of the
// place below a vertex: its forces keep their sum, and their torque where it lies in the sheet.

#include "geometry/embed/bind.hpp"

#include <span>

namespace geometry {

// The mesh as corners at `x` (K, m) carry it: positions and normals; all else as it was. Throws
// std::invalid_argument when sizes do not match. In single precision from the displacements on:
// the error is some 1e-7 of the displacement, below that of the positions themselves. Cells of a
// plane that are `torn` (C, or empty) do not count for its normals. A sheet does not tear.
TriMesh embed(const Binding& binding, const TriMesh& mesh, const Cubes& cubes,
              std::span<const Vec3> x, std::span<const std::uint8_t> torn = {});

// Forces at vertices (V, N) to forces at corners (K, N): the transpose of displacements at corners
// to displacements at vertices. Keeps sum and torque about any point of the rest shape.
std::vector<Vec3> transpose(const Binding& binding, const Cubes& cubes,
                            std::span<const Vec3> forces);

// Corner values (K) interpolated to vertices (V). That of a vertex in no cube is its cube's
// nearest.
std::vector<float> interpolate(const Binding& binding, const Cubes& cubes,
                               std::span<const double> values);

// Displacements or velocities of corners (K) at vertices (V), also of those in no cube: by
// weights(), the transpose of transpose().
std::vector<Vec3f> carried_vectors(const Binding& binding, const Cubes& cubes,
                                   std::span<const Vec3> vectors);

// Cube values (C) averaged at corners, over the cubes around each by their fill, or the triangles
// of a sheet by what fills each. K.
std::vector<double> at_corners(const Cubes& cubes, std::span<const float> values);

// The weights of a vertex's eight corners; they sum to 1, and are 0..1 where its place is.
std::array<double, 8> weights(const Binding& binding, std::uint32_t vertex);

}  // namespace geometry
