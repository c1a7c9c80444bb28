#pragma once

// The field at a block of neighbouring points, for callers with loops of their own.
// Each skeleton is kept or dropped for the whole block, by its exact distance to the block's ball.
//
//   candidates(field, box, near)              skeletons that may reach the box around the points
//   evaluate(field, near, block, scratch, out)

#include "geometry/fields/field.hpp"
#include "geometry/fields/field_block.hpp"

namespace geometry {

// Memory of block evaluation, one a thread.
struct FieldScratch {
    std::vector<BlockValues> each;  // one a skeleton
    std::vector<std::uint32_t> near;
    std::vector<Contributor> contributors;
    BlockValues feet;
    FieldBlock narrow;  // of a stretched skeleton: the block, and its points
    std::vector<Vec3> narrow_points;
    // After an evaluation with an owner: df/df_i of each near skeleton at each point, one row of
    // FieldBlock::capacity a skeleton; empty: 1 everywhere.
    std::vector<double> share;
};

// f and gradient of the blend of `skeletons` at a padded block's points.
void evaluate(const Field& field, std::span<const std::uint32_t> skeletons, const FieldBlock& block,
              FieldScratch& scratch, BlockValues& out);

// Beside the blend: skeleton `owner`'s own contribution, and the largest of the others'. Where
// own < rival the point is outside owner's territory. Ties go to the smaller number, as in
// value_at().
struct TerritoryValues {
    BlockValues blend, own, rival;
};
void evaluate(const Field& field, std::span<const std::uint32_t> skeletons, std::uint32_t owner,
              const FieldBlock& block, FieldScratch& scratch, TerritoryValues& out);

}  // namespace geometry
