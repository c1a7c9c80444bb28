#pragma once

// The field of an implicit layer in the world: skeletons, each with its contribution, blended.
// Solid where f >= isovalue; the surface is f = isovalue, its outward normal -grad f / |grad f|.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997.
//
//      f                 one skeleton (field_profile.hpp)     two, blended (field_blend.hpp)
//      |`-.
//      |   `.                                                     .---.     .---.
//   c -|-----`-.-- surface: f = isovalue                         (  x   `-'   x  )
//      |       |`-.                                               `---'     `---'
//      '-------+---`---- r, distance (field_skeleton.hpp)       x: point skeletons
//
// A point costs only the skeletons whose influence reaches it (field_grid.hpp). Many points are
// asked by evaluate_points.hpp; callers with loops of their own ask blocks of neighbours by
// evaluate_block.hpp.

#include "geometry/base/no_index.hpp"
#include "geometry/fields/field_blend.hpp"
#include "geometry/fields/field_grid.hpp"
#include "geometry/fields/field_profile.hpp"
#include "geometry/fields/field_skeleton.hpp"

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

// A layer in the world, ready to be asked. Immutable once made.
struct Field {
    double isovalue = 1;
    BlendRule rule = BlendRule::sum;
    BlendWeights weights;

    std::vector<SkeletonKind> kind;     // S
    std::vector<FieldProfile> profile;  // S
    std::vector<Box> influence;         // S, m, no contribution outside; infinite for planes
    std::vector<std::uint32_t> first;   // S + 1, into points
    std::vector<Vec3> points;      // m, world; Bezier points of curves; none for solids and sheets
    std::vector<Transform> place;  // S, solids and sheets: their own frame to the world
    std::vector<Vec3> half_size;   // S, m
    std::vector<std::shared_ptr<const SkeletonMesh>> mesh;  // S, null for others
    std::vector<FieldStretch> stretch;                      // S, world, or empty: none has one
    double most_stretch = 1;                                // of them all
    FieldGrid grid;                                         // of all bounded skeletons
    std::vector<std::uint32_t> unbounded;

    std::size_t count() const { return kind.size(); }
};

// Whether a skeleton has an inside, where its distance is negative.
inline bool is_solid(SkeletonKind kind)
{
    return kind == SkeletonKind::box || kind == SkeletonKind::ellipsoid ||
           kind == SkeletonKind::plane || kind == SkeletonKind::mesh ||
           kind == SkeletonKind::torus || kind == SkeletonKind::cylinder ||
           kind == SkeletonKind::cone;
}

// Whether a skeleton is drawn by its points, and not in a frame of its own.
inline bool has_points(SkeletonKind kind)
{
    return !is_solid(kind) && kind != SkeletonKind::sheet;
}

// The points of skeleton i in the world; Bezier points of a curve; none for solids and sheets.
inline std::span<const Vec3> points_of(const Field& field, std::size_t i)
{
    return {field.points.data() + field.first[i], field.points.data() + field.first[i + 1]};
}

// Null where skeleton i has none.
inline const FieldStretch* stretch_of(const Field& field, std::size_t i)
{
    return field.stretch.empty() || field.stretch[i].most == 1 ? nullptr : &field.stretch[i];
}

// How many times as wide the layer of skeleton i is along a unit direction as its radii say.
inline double width_along(const Field& field, std::size_t i, const Vec3& direction)
{
    return field.stretch.empty() ? 1 : field.stretch[i].along(direction);
}

// m: of the layer of skeleton i alone, along a unit direction.
inline double thickness_along(const Field& field, std::size_t i, const Vec3& direction)
{
    return field.profile[i].e * width_along(field, i, direction);
}

// A field of one skeleton in space narrowed by its stretch: without one.
Field narrowed(Field field);

// `frames` map the carrier's local frames to the world, rigid; `translations` move each skeleton's
// contribution outward, m (empty: none). Throws std::invalid_argument, naming the skeleton, when
// anything in the layer is not usable.
Field make_field(const ImplicitLayer& layer, std::span<const Transform> frames,
                 std::span<const double> translations = {});

// A box outside which f is 0 (planes left out); empty for no bounded skeletons.
Box influence(const Field& field);

// Where p stands to one skeleton.
Foot foot(const Field& field, std::size_t skeleton, const Vec3& p);

// 1/m: the slope that the contribution of a skeleton has at its surface, near p.
double surface_slope(const Field& field, std::size_t skeleton, const Vec3& p);

// m: how far from the surface of a skeleton alone a foot is, of a stretched one to first order.
double surface_gap(const Field& field, std::size_t skeleton, const Foot& foot);

// foot().r alone, which is quicker. The same bits.
double distance(const Field& field, std::size_t skeleton, const Vec3& p);

// Tells a contributor how its skeleton's grad r turns, for the rule `gradient`.
void set_turning(const Field& field, const Foot& foot, Contributor& contributor);

inline constexpr std::uint32_t no_skeleton = no_index;

struct FieldValue {
    double f = 0;
    Vec3 gradient = Vec3::Zero();
    std::uint32_t largest = no_skeleton;  // whose territory it is: the largest contribution's
};

// At one point. For many use evaluate().
FieldValue value_at(const Field& field, const Vec3& p);

// The skeletons that may contribute somewhere in `box`, ascending. Reuses `out`'s memory.
void candidates(const Field& field, const Box& box, std::vector<std::uint32_t>& out);

// Bounds of f over `box` for these skeletons, from r being 1-Lipschitz.
struct Interval {
    double lo = 0, hi = 0;
};
Interval bounds(const Field& field, std::span<const std::uint32_t> skeletons, const Box& box);

// 1/m: no larger is |grad f| in `box`, for these skeletons. Of a smooth blend of several parts it
// is twice what their sum may have: shares of a contribution above 1 are rare and near it.
double slope_bound(const Field& field, std::span<const std::uint32_t> skeletons, const Box& box);

}  // namespace geometry
