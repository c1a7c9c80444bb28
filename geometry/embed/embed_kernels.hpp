#pragma once

// The inner loops of embedding: what the trilinear polynomials of cubes make of places and normals,
// two at a time where the machine has the lanes for it (Highway, chosen at run time; no fused
// multiply-add, so that every machine gives the same bits).

#include "geometry/base/vec.hpp"

#include <span>

namespace geometry {

// u(p) = c0 + cx x + cy y + cz z + cxy xy + cyz yz + czx zx + cxyz xyz in one cube, each
// coefficient a vector in four lanes, the last of them 0.
struct CubePolynomial {
    Eigen::Array4f c0, cx, cy, cz, cxy, cyz, czx, cxyz;
};

// That of a cube whose corners move by u, m.
CubePolynomial polynomial_of(const std::array<Vec3, 8>& u);

// u at p, 0..1, and its change over `by` with the slope there. m.
Vec3f affine_at(const CubePolynomial& u, const Vec3f& p, const Vec3f& by);

// Of V vertices: the cube of each, into `polynomials`, and its place there.
struct CarriedPlaces {
    std::span<const CubePolynomial> polynomials;
    std::span<const std::uint32_t> cube;
    std::span<const Vec3f> local;
};

// to[v] = rest[v] + u(local[v]), for v in begin..end.
void carry_positions(const CarriedPlaces& places, std::span<const Vec3f> rest, std::size_t begin,
                     std::size_t end, std::span<Vec3f> to);

// to[n] = cof(F) rest[n] to unit length, F = I + per_metre grad u at vertex[n], for n in
// begin..end; rest[n] where that is nothing, or where vertex[n] is none of them.
void turn_normals(const CarriedPlaces& places, std::span<const std::uint32_t> vertex,
                  float per_metre, std::span<const Vec3f> rest, std::size_t begin, std::size_t end,
                  std::span<Vec3f> to);

// Both at once, where normal v is vertex v's: half as much is read.
void carry_vertices(const CarriedPlaces& places, std::span<const Vec3f> rest,
                    std::span<const Vec3f> rest_normals, float per_metre, std::size_t begin,
                    std::size_t end, std::span<Vec3f> to, std::span<Vec3f> to_normals);

}  // namespace geometry
