#pragma once

// How the parts of parted cubes move. A part moves as the cube would that has the part's corners,
// and in place of the others virtual ones, as far from the part's own as the links of those point.
// It shares them with parts that it is joined to (part_corners.hpp).
// After Molino, Bao, Fedkiw. A virtual node algorithm for changing mesh topology during simulation.
// SIGGRAPH 2004.
//
//      2 --- x          x --- 3        Two parts of a cube whose links 0-1 and 2-3 are broken:
//      |     :          :     |        each has two corners of its own and two virtual ones, x.
//      0 --- x          x --- 1

#include "geometry/base/no_index.hpp"
#include "geometry/embed/bind.hpp"
#include "geometry/embed/embed_kernels.hpp"
#include "geometry/embed/parted_cubes.hpp"

namespace geometry {

// How each part of each parted cube moves.
struct PartMotion {
    const Cubes* cubes = nullptr;
    std::span<const PartedCube> parted;
    std::vector<CubePolynomial> polynomials;  // of all parts of the first cube, of the second, ...
    std::vector<std::uint32_t> first;         // of each parted cube, into polynomials
};

// With corners at x (K, m) and the cubes that are `torn` (C). Both arguments must outlive it.
PartMotion motion_of_parts(const Cubes& cubes, std::span<const Vec3> x,
                           std::span<const std::uint32_t> broken,
                           std::span<const PartedCube> parted, std::span<const std::uint8_t> torn);

// The part that a vertex is in, as 8 * parted cube + part; no_index: in no parted cube. Of strays,
// that of their anchors.
std::uint32_t part_of(const PartMotion& motion, const Binding& binding, std::uint32_t vertex);

// Places and normals to be carried along with parts.
struct CarriedByParts {
    std::vector<std::uint32_t> polynomial;   // of each place
    std::vector<Vec3f> anchor, local, rest;  // of each place
    std::vector<std::uint32_t> to;           // of each place, where its result goes
    std::vector<std::uint32_t> normal_of;    // of each normal, its place
    std::vector<Vec3f> normal;               // at rest
    std::vector<std::uint32_t> normal_to;
};

// `rest` goes with `part`, as the vertex v that is bound like this; `to` is v too.
void add_vertex(CarriedByParts& carried, const PartMotion& motion, std::uint32_t part,
                const Vec3f& rest, const Binding& binding, std::uint32_t v);

// `rest` goes with `part` in that part's own cube.
void add_place(CarriedByParts& carried, const PartMotion& motion, std::uint32_t part,
               const Vec3f& rest, std::uint32_t to);

// A normal of the place that was added last.
void add_normal(CarriedByParts& carried, const Vec3f& rest, std::uint32_t to);

// Puts all of them where they come to be.
void carry(const CarriedByParts& carried, const PartMotion& motion, std::vector<Vec3f>& positions,
           std::vector<Vec3f>& normals);

}  // namespace geometry
