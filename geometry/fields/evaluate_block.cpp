#include "geometry/fields/evaluate_block.hpp"

#include "geometry/fields/field_kernels.hpp"
#include "geometry/fields/round_skeleton.hpp"

#include <algorithm>

namespace geometry {
namespace {

// The same in narrowed space, where a stretched skeleton has distances like any other.
void add_stretched(const Field& field, std::uint32_t i, const FieldStretch& stretch,
                   const FieldBlock& block, FieldScratch& scratch, BlockValues& sum)
{
    const Mat3& narrow = stretch.narrow;
    scratch.narrow.count = 0;
    for (std::size_t k = 0; k < block.count; ++k) scratch.narrow.add(narrow * block.point(k));
    scratch.narrow.pad();
    scratch.narrow_points.clear();
    for (const Vec3& p : points_of(field, i)) scratch.narrow_points.emplace_back(narrow * p);
    BlockValues& own = scratch.feet;
    own.clear(block.count);
    if (field.kind[i] == SkeletonKind::curve) {
        add_curve(scratch.narrow_points, field.profile[i], scratch.narrow, own);
    } else {
        add_polyline(scratch.narrow_points, field.profile[i], scratch.narrow, own);
    }
    for (std::size_t k = 0; k < block.count; ++k) {
        const Vec3 gradient = narrow * own.gradient(k);
        sum.f[k] += own.f[k];
        sum.gx[k] += gradient.x();
        sum.gy[k] += gradient.y();
        sum.gz[k] += gradient.z();
    }
}

// Adds skeleton i's contribution at every point of the block.
void add_skeleton(const Field& field, std::uint32_t i, const FieldBlock& block,
                  FieldScratch& scratch, BlockValues& sum)
{
    const SkeletonKind kind = field.kind[i];
    const FieldStretch* const stretch = stretch_of(field, i);
    if (stretch && kind != SkeletonKind::triangle) {
        return add_stretched(field, i, *stretch, block, scratch, sum);
    }
    if (kind == SkeletonKind::point || kind == SkeletonKind::segment ||
        kind == SkeletonKind::polyline) {
        return add_polyline(points_of(field, i), field.profile[i], block, sum);
    }
    if (kind == SkeletonKind::curve) {
        return add_curve(points_of(field, i), field.profile[i], block, sum);
    }
    if (is_round(kind)) {
        return add_round(kind, field.half_size[i], field.place[i], field.profile[i], block, sum);
    }
    BlockValues& feet = scratch.feet;
    for (std::size_t k = 0; k < (block.count + 7) / 8 * 8; ++k) {
        const Foot at = foot(field, i, block.point(k));
        feet.f[k] = at.r;
        feet.gx[k] = at.n.x();
        feet.gy[k] = at.n.y();
        feet.gz[k] = at.n.z();
    }
    add_feet(feet, field.profile[i], block.count, sum);
}

// Of `skeletons`, those whose influence reaches into the block's bounding ball.
void keep_near(const Field& field, std::span<const std::uint32_t> skeletons,
               const FieldBlock& block, std::vector<std::uint32_t>& near)
{
    Box box;
    for (std::size_t k = 0; k < block.count; ++k) box.add(block.point(k));
    const Vec3 centre = box.centre();
    const double radius = 0.5 * box.diagonal();
    near.clear();
    for (const std::uint32_t i : skeletons) {
        if (distance(field, i, centre) - radius < field.profile[i].R) near.push_back(i);
    }
}

// Every near skeleton's contribution by itself, into scratch.each.
void evaluate_each(const Field& field, const FieldBlock& block, FieldScratch& scratch)
{
    const std::size_t n = scratch.near.size();
    if (scratch.each.size() < n) scratch.each.resize(n);
    for (std::size_t s = 0; s < n; ++s) {
        scratch.each[s].clear(block.count);
        add_skeleton(field, scratch.near[s], block, scratch, scratch.each[s]);
    }
}

// Whether these skeletons blend as their plain sum: all of one part, or by the rule.
bool plain_sum(const Field& field, std::span<const std::uint32_t> near)
{
    if (field.rule == BlendRule::sum || near.empty()) return true;
    if (field.rule == BlendRule::gradient) return false;
    return std::all_of(near.begin(), near.end(), [&](std::uint32_t i) {
        return field.weights.part(i) == field.weights.part(near[0]);
    });
}

void add(const BlockValues& one, std::size_t count, BlockValues& sum)
{
    for (std::size_t k = 0; k < (count + 7) / 8 * 8; ++k) {
        sum.f[k] += one.f[k];
        sum.gx[k] += one.gx[k];
        sum.gy[k] += one.gy[k];
        sum.gz[k] += one.gz[k];
    }
}

void blend_each(const Field& field, const FieldBlock& block, FieldScratch& scratch,
                BlockValues& out)
{
    const std::size_t n = scratch.near.size();
    if (plain_sum(field, scratch.near)) {
        out.clear(block.count);
        for (std::size_t s = 0; s < n; ++s) add(scratch.each[s], block.count, out);
        scratch.share.clear();
        return;
    }
    scratch.share.assign(n * FieldBlock::capacity, 0);
    for (std::size_t k = 0; k < block.count; ++k) {
        scratch.contributors.clear();
        for (std::size_t s = 0; s < n; ++s) {
            const BlockValues& one = scratch.each[s];
            if (!(one.f[k] > 0)) continue;
            Contributor c{scratch.near[s], one.f[k], one.gradient(k)};
            if (field.rule == BlendRule::gradient) {
                set_turning(field, foot(field, c.skeleton, block.point(k)), c);
            }
            scratch.contributors.push_back(c);
        }
        const Blended b = blend(field.rule, field.weights, scratch.contributors);
        for (const Contributor& c : scratch.contributors) {
            const auto s = static_cast<std::size_t>(
                std::lower_bound(scratch.near.begin(), scratch.near.end(), c.skeleton) -
                scratch.near.begin());
            scratch.share[s * FieldBlock::capacity + k] = c.share;
        }
        out.f[k] = b.f;
        out.gx[k] = b.gradient.x();
        out.gy[k] = b.gradient.y();
        out.gz[k] = b.gradient.z();
    }
}

}  // namespace

void evaluate(const Field& field, std::span<const std::uint32_t> skeletons, const FieldBlock& block,
              FieldScratch& scratch, BlockValues& out)
{
    keep_near(field, skeletons, block, scratch.near);
    if (scratch.near.size() < 2 || plain_sum(field, scratch.near)) {
        out.clear(block.count);
        for (const std::uint32_t i : scratch.near) add_skeleton(field, i, block, scratch, out);
        return;
    }
    evaluate_each(field, block, scratch);
    blend_each(field, block, scratch, out);
}

void evaluate(const Field& field, std::span<const std::uint32_t> skeletons, std::uint32_t owner,
              const FieldBlock& block, FieldScratch& scratch, TerritoryValues& out)
{
    keep_near(field, skeletons, block, scratch.near);
    evaluate_each(field, block, scratch);
    blend_each(field, block, scratch, out.blend);
    out.own.clear(block.count);
    out.rival.clear(block.count);
    for (std::size_t s = 0; s < scratch.near.size(); ++s) {
        const BlockValues& one = scratch.each[s];
        BlockValues& to = scratch.near[s] == owner ? out.own : out.rival;
        for (std::size_t k = 0; k < block.count; ++k) {
            if (!(one.f[k] > to.f[k])) continue;
            to.f[k] = one.f[k];
            to.gx[k] = one.gx[k];
            to.gy[k] = one.gy[k];
            to.gz[k] = one.gz[k];
        }
    }
}

}  // namespace geometry
