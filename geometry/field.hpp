#pragma once

// Implicit fields of skeletons: solid where f >= isovalue, surface f = isovalue, outward normal
// -grad f / |grad f|.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997. What a skeleton gives stands in field_profile.hpp, how they combine in field_blend.hpp.
//
// A point costs only the skeletons whose influence reaches it: their boxes lie in a uniform grid,
// points are taken in blocks of neighbours, and for a block each skeleton is kept or dropped by its
// exact distance to the block's ball.

#include "geometry/field_blend.hpp"
#include "geometry/field_kernels.hpp"
#include "geometry/field_profile.hpp"
#include "geometry/field_skeleton.hpp"

#include <span>
#include <vector>

namespace geometry {

// An implicit layer as it is designed: skeletons in the local frames of what carries them.
struct ImplicitLayer {
    double isovalue = 1;
    std::vector<Skeleton> skeletons;          // S
    std::vector<Contribution> contributions;  // S
    std::vector<std::uint32_t> frame;         // S, the carrier's frame each rides on
    Blend blend;
};

// Which skeletons' influence boxes touch each cell of a uniform grid.
struct FieldGrid {
    Vec3 lo = Vec3::Zero();
    double cell = 1;  // m
    Vec3i dims = Vec3i::Zero();
    std::vector<std::uint32_t> first;     // cells + 1, into skeleton
    std::vector<std::uint32_t> skeleton;  // ascending within a cell

    std::size_t cell_count() const { return first.empty() ? 0 : first.size() - 1; }
};

// A layer in the world, ready to be asked. Immutable once made.
struct Field {
    double isovalue = 1;
    BlendRule rule = BlendRule::sum;
    BlendWeights weights;

    std::vector<SkeletonKind> kind;     // S
    std::vector<FieldProfile> profile;  // S
    std::vector<Box> influence;         // S, m, no contribution outside; infinite for planes
    std::vector<std::uint32_t> first;   // S + 1, into points
    std::vector<Vec3> points;           // m, world; none for solids
    std::vector<Transform> place;       // S, solids: their own frame to the world
    std::vector<Vec3> half_size;        // S, m
    std::vector<std::shared_ptr<const SkeletonMesh>> mesh;  // S, null for others
    FieldGrid grid;                                         // of all bounded skeletons
    std::vector<std::uint32_t> unbounded;

    std::size_t count() const { return kind.size(); }
};

// `frames` map the carrier's local frames to the world, rigid; `translations` move each skeleton's
// contribution outward, m (empty: none). Throws std::invalid_argument, naming the skeleton, when
// anything in the layer is not usable.
Field make_field(const ImplicitLayer& layer, std::span<const Transform> frames,
                 std::span<const double> translations = {});

// A box outside which f is 0 (planes left out); empty for no bounded skeletons.
Box influence(const Field& field);

// Where p stands to one skeleton.
Foot foot(const Field& field, std::size_t skeleton, const Vec3& p);

constexpr std::uint32_t no_skeleton = 0xffffffff;

struct FieldValue {
    double f = 0;
    Vec3 gradient = Vec3::Zero();
    std::uint32_t largest = no_skeleton;  // whose territory it is: the largest contribution's
};

// At one point. For many use evaluate().
FieldValue value_at(const Field& field, const Vec3& p);

// f at each point, and its gradient where `gradient` is not empty. A point that is not finite lies
// outside everything. Spans of unequal length throw std::invalid_argument.
void evaluate(const Field& field, std::span<const Vec3> points, std::span<double> f,
              std::span<Vec3> gradient = {});

// -- Blocks of neighbouring points, for callers with their own loops ---------------------------

// The skeletons that may contribute somewhere in `box`, ascending. Reuses `out`'s memory.
void candidates(const Field& field, const Box& box, std::vector<std::uint32_t>& out);

// Bounds of f over `box` for these skeletons, from r being 1-Lipschitz.
struct Interval {
    double lo = 0, hi = 0;
};
Interval bounds(const Field& field, std::span<const std::uint32_t> skeletons, const Box& box);

// Memory of block evaluation, one a thread.
struct FieldScratch {
    std::vector<BlockValues> each;  // one a skeleton
    std::vector<std::uint32_t> near;
    std::vector<Contributor> contributors;
    BlockValues feet;
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
