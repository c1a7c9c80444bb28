#pragma once

// The inner loops of field evaluation: one skeleton against a block of nearby points, vectorised
// over the points (Highway, widest instructions of the machine chosen at run time; no fused
// multiply-add, so that every machine gives the same bits).

#include "geometry/fields/field_block.hpp"
#include "geometry/fields/field_profile.hpp"
#include "geometry/fields/field_skeleton.hpp"

#include <span>

namespace geometry {

// Adds the contribution of one polyline skeleton (one point: a point skeleton; two: a segment).
void add_polyline(std::span<const Vec3> points, const FieldProfile& profile,
                  const FieldBlock& block, BlockValues& sum);

// Adds the contribution of one curve skeleton, given by its Bezier points.
void add_curve(std::span<const Vec3> bezier, const FieldProfile& profile, const FieldBlock& block,
               BlockValues& sum);

// Adds the contribution of one torus, cylinder or cone, whose own frame `place` takes to the world.
void add_round(SkeletonKind kind, const Vec3& half_size, const Transform& place,
               const FieldProfile& profile, const FieldBlock& block, BlockValues& sum);

// Adds the contribution of a skeleton whose distances and their gradients are known: feet.f = r,
// feet.g = grad r.
void add_feet(const BlockValues& feet, const FieldProfile& profile, std::size_t count,
              BlockValues& sum);

}  // namespace geometry
