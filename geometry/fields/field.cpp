#include "geometry/fields/field.hpp"

#include "geometry/fields/curve_skeleton.hpp"
#include "geometry/fields/round_skeleton.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace geometry {
namespace {

Box influence_of(const Field& field, std::size_t i)
{
    Box box;
    const double reach = field.profile[i].R;
    if (!(reach > 0) && !is_solid(field.kind[i])) return box;  // moved inward to nothing
    switch (field.kind[i]) {
    case SkeletonKind::plane:
        box.add(Vec3::Constant(-std::numeric_limits<double>::infinity()));
        box.add(Vec3::Constant(std::numeric_limits<double>::infinity()));
        return box;
    case SkeletonKind::box:
    case SkeletonKind::ellipsoid:
    case SkeletonKind::torus:
    case SkeletonKind::cylinder:
    case SkeletonKind::cone: {
        const Vec3 half =
            field.place[i].linear().cwiseAbs() * half_extent(field.kind[i], field.half_size[i]);
        box.add(field.place[i].translation() - half);
        box.add(field.place[i].translation() + half);
        break;
    }
    case SkeletonKind::mesh:
    case SkeletonKind::sheet:
        for (const Vec3f& p : field.mesh[i]->mesh.positions) {
            if (p.allFinite()) box.add(field.place[i] * p.cast<double>());
        }
        break;
    default:
        for (const Vec3& p : points_of(field, i)) box.add(p);
    }
    if (const FieldStretch* stretch = stretch_of(field, i)) {
        const Vec3 out = reach * stretch->wide.rowwise().norm();
        box.lo -= out;
        box.hi += out;
        return box;
    }
    box.lo.array() -= reach;
    box.hi.array() += reach;
    return box;
}

// What a skeleton is drawn by, if by points.
void add_points(const Skeleton& s, const Transform& frame, Field& field)
{
    if (s.kind == SkeletonKind::curve) {
        for (const Vec3& p : catmull_rom(s.points)) field.points.push_back(frame * p);
    } else if (has_points(s.kind)) {
        for (const Vec3& p : s.points) field.points.push_back(frame * p);
    }
    field.first.push_back(static_cast<std::uint32_t>(field.points.size()));
}

Foot foot_on_points(SkeletonKind kind, std::span<const Vec3> points, const Vec3& p)
{
    if (kind == SkeletonKind::triangle) return foot_on_triangle(points.first<3>(), p);
    if (kind == SkeletonKind::curve) return foot_on_curve(points, p);
    return foot_on_polyline(points, p);
}

bool touch(const Box& a, const Box& b)
{
    return (a.lo.array() <= b.hi.array()).all() && (b.lo.array() <= a.hi.array()).all();
}

}  // namespace

Field make_field(const ImplicitLayer& layer, std::span<const Transform> frames,
                 std::span<const double> translations)
{
    const std::size_t n = layer.skeletons.size();
    if (layer.contributions.size() != n || layer.frame.size() != n ||
        (!translations.empty() && translations.size() != n)) {
        throw std::invalid_argument(fmt::format(
            "a layer of {} skeletons needs as many contributions, frame numbers and translations "
            "(or no translations), got {}, {} and {}",
            n, layer.contributions.size(), layer.frame.size(), translations.size()));
    }
    for (std::size_t f = 0; f < frames.size(); ++f) {
        if (!is_rigid(frames[f])) {
            throw std::invalid_argument(fmt::format(
                "frame {} of an implicit layer must be rigid: no scale, shear or mirroring", f));
        }
    }
    Field field;
    field.isovalue = layer.isovalue;
    field.rule = layer.blend.rule;
    field.weights = BlendWeights(layer.blend, n);
    field.first.push_back(0);
    const bool stretched = std::any_of(layer.skeletons.begin(), layer.skeletons.end(),
                                       [](const Skeleton& s) { return s.stretches(); });
    for (std::size_t i = 0; i < n; ++i) {
        const Skeleton& s = layer.skeletons[i];
        try {
            check(s);
            if (layer.frame[i] >= frames.size()) {
                throw std::invalid_argument(
                    fmt::format("its frame is {}, but there are only {} frames", layer.frame[i],
                                frames.size()));
            }
            field.profile.push_back(make_profile(layer.contributions[i], layer.isovalue,
                                                 translations.empty() ? 0 : translations[i]));
        } catch (const std::invalid_argument& wrong) {
            throw std::invalid_argument(fmt::format("skeleton {}: {}", i, wrong.what()));
        }
        const Transform& frame = frames[layer.frame[i]];
        field.kind.push_back(s.kind);
        add_points(s, frame, field);
        field.place.push_back(frame * s.place);
        field.half_size.push_back(s.half_size);
        const bool of_mesh = s.kind == SkeletonKind::mesh || s.kind == SkeletonKind::sheet;
        field.mesh.push_back(of_mesh ? s.mesh : nullptr);
        if (stretched) {
            field.stretch.push_back(stretch_of(s, frame.linear()));
            field.most_stretch = std::max(field.most_stretch, field.stretch.back().most);
        }
        field.influence.push_back(influence_of(field, i));
        if (s.kind == SkeletonKind::plane) {
            field.unbounded.push_back(static_cast<std::uint32_t>(i));
        }
    }
    field.grid = make_field_grid(field.influence);
    return field;
}

Field narrowed(Field field)
{
    const Mat3 narrow = field.stretch[0].narrow;
    for (Vec3& p : field.points) p = narrow * p;
    field.stretch.clear();
    field.most_stretch = 1;
    field.influence[0] = influence_of(field, 0);
    field.grid = make_field_grid(field.influence);
    return field;
}

Box influence(const Field& field)
{
    Box all;
    for (const Box& box : field.influence) {
        if (!box.empty() && box.lo.allFinite()) all.add(box);
    }
    return all;
}

Foot foot(const Field& field, std::size_t i, const Vec3& p)
{
    if (has_points(field.kind[i])) {
        const std::span<const Vec3> points = points_of(field, i);
        const FieldStretch* const stretch = stretch_of(field, i);
        if (!stretch) return foot_on_points(field.kind[i], points, p);
        thread_local std::vector<Vec3> narrow;
        narrow.clear();
        for (const Vec3& q : points) narrow.emplace_back(stretch->narrow * q);
        Foot result = foot_on_points(field.kind[i], narrow, stretch->narrow * p);
        result.n = stretch->narrow * result.n;
        result.hessian = stretch->narrow * result.hessian * stretch->narrow;
        return result;
    }
    const Mat3 turn = field.place[i].linear();
    const Vec3 local = turn.transpose() * (p - field.place[i].translation());
    Foot result;
    switch (field.kind[i]) {
    case SkeletonKind::box:
        result = foot_on_box(field.half_size[i], local);
        break;
    case SkeletonKind::ellipsoid:
        result = foot_on_ellipsoid(field.half_size[i], local);
        break;
    case SkeletonKind::mesh:
        result = foot_on_mesh(*field.mesh[i], local);
        break;
    case SkeletonKind::sheet:
        result = foot_on_sheet(*field.mesh[i], local);
        break;
    case SkeletonKind::torus:
        result = foot_on_torus(round_shape(field.kind[i], field.half_size[i]), local);
        break;
    case SkeletonKind::cylinder:
    case SkeletonKind::cone:
        result = foot_on_cone(round_shape(field.kind[i], field.half_size[i]), local);
        break;
    default:
        result = foot_on_plane(local);
    }
    result.n = turn * result.n;
    result.hessian = turn * result.hessian * turn.transpose();
    return result;
}

double surface_slope(const Field& field, std::size_t i, const Vec3& p)
{
    const double k = field.profile[i].k;
    const FieldStretch* const stretch = stretch_of(field, i);
    // On the skeleton itself grad r is nothing: the least that it has anywhere.
    return stretch ? k * std::max(foot(field, i, p).n.norm(), 1 / stretch->most) : k;
}

double surface_gap(const Field& field, std::size_t i, const Foot& foot)
{
    const FieldStretch* const stretch = stretch_of(field, i);
    const double gap = foot.r - field.profile[i].e;
    return stretch ? gap / std::max(foot.n.norm(), 1 / stretch->most) : gap;
}

double distance(const Field& field, std::size_t i, const Vec3& p)
{
    if (stretch_of(field, i)) return foot(field, i, p).r;
    switch (field.kind[i]) {
    case SkeletonKind::point:
    case SkeletonKind::segment:
    case SkeletonKind::polyline:
        return distance_to_polyline(points_of(field, i), p);
    default:
        return foot(field, i, p).r;
    }
}

void set_turning(const Field& field, const Foot& foot, Contributor& contributor)
{
    contributor.n = foot.n;
    contributor.turn = foot.hessian;
    const double length = foot.n.norm();
    if (!stretch_of(field, contributor.skeleton) || !(length > 0)) return;
    contributor.n /= length;
    contributor.turn =
        foot.hessian * (Mat3::Identity() - contributor.n * contributor.n.transpose()) / length;
}

FieldValue value_at(const Field& field, const Vec3& p)
{
    FieldValue value;
    if (!p.allFinite()) return value;
    thread_local std::vector<std::uint32_t> near;
    thread_local std::vector<Contributor> contributors;
    Box box;
    box.add(p);
    candidates(field, box, near);
    contributors.clear();
    double largest = 0;
    for (const std::uint32_t i : near) {
        const Foot at = foot(field, i, p);
        const ProfileValue v = profile_at(field.profile[i], at.r);
        if (!(v.f > 0)) continue;
        contributors.push_back({i, v.f, v.slope * at.n});
        set_turning(field, at, contributors.back());
        if (v.f > largest) {
            largest = v.f;
            value.largest = i;
        }
    }
    const Blended b = blend(field.rule, field.weights, contributors);
    value.f = b.f;
    value.gradient = b.gradient;
    return value;
}

void candidates(const Field& field, const Box& box, std::vector<std::uint32_t>& out)
{
    out.clear();
    const FieldGrid& grid = field.grid;
    if (grid.cell_count() > 0 && touch(extent(grid), box)) {
        const Vec3i cells = cell_of(grid, box.hi) - cell_of(grid, box.lo) + Vec3i::Ones();
        if (cells.prod() > 32) {  // wide: asking every skeleton is quicker
            for (std::uint32_t i = 0; i < field.count(); ++i) {
                if (touch(field.influence[i], box)) out.push_back(i);
            }
            return;
        }
        for_cells(grid, box, [&](std::size_t cell) {
            for (std::uint32_t e = grid.first[cell]; e < grid.first[cell + 1]; ++e) {
                if (touch(field.influence[grid.skeleton[e]], box)) {
                    out.push_back(grid.skeleton[e]);
                }
            }
        });
    }
    out.insert(out.end(), field.unbounded.begin(), field.unbounded.end());
    if (out.size() > 1) {
        std::sort(out.begin(), out.end());
        out.erase(std::unique(out.begin(), out.end()), out.end());
    }
}

Interval bounds(const Field& field, std::span<const std::uint32_t> skeletons, const Box& box)
{
    const Vec3 centre = box.centre();
    const double radius = 0.5 * box.diagonal();
    Interval sum, largest;
    for (const std::uint32_t i : skeletons) {
        const double r = distance(field, i, centre);
        const double lo = profile_at(field.profile[i], r + radius).f;
        // Only solids have an inside; nothing is nearer than the skeleton itself elsewhere.
        const double nearest = is_solid(field.kind[i]) ? r - radius : std::max(0.0, r - radius);
        const double hi = profile_at(field.profile[i], nearest).f;
        sum.lo += lo;
        sum.hi += hi;
        largest.lo = std::max(largest.lo, lo);
    }
    return {field.rule == BlendRule::sum ? sum.lo : largest.lo, sum.hi};
}

double slope_bound(const Field& field, std::span<const std::uint32_t> skeletons, const Box& box)
{
    const Vec3 centre = box.centre();
    const double radius = 0.5 * box.diagonal();
    double sum = 0;
    std::uint32_t first = no_skeleton;
    bool parts = false;
    for (const std::uint32_t i : skeletons) {
        const double r = distance(field, i, centre);
        const double nearest = is_solid(field.kind[i]) ? r - radius : std::max(0.0, r - radius);
        if (!(nearest < field.profile[i].R)) continue;
        sum += steepest(field.profile[i], nearest, r + radius);
        if (first == no_skeleton) first = i;
        parts |= field.weights.part(i) != field.weights.part(first);
    }
    const bool smooth =
        field.rule == BlendRule::gradient || (field.rule == BlendRule::smooth_groups && parts);
    return smooth ? 2 * sum : sum;
}

}  // namespace geometry
