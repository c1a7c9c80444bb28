#include "geometry/field.hpp"

#include "geometry/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

bool is_solid(SkeletonKind kind)
{
    return kind == SkeletonKind::box || kind == SkeletonKind::ellipsoid ||
           kind == SkeletonKind::plane || kind == SkeletonKind::mesh;
}

std::span<const Vec3> points_of(const Field& field, std::size_t i)
{
    return {field.points.data() + field.first[i], field.points.data() + field.first[i + 1]};
}

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
    case SkeletonKind::ellipsoid: {
        const Vec3 half = field.place[i].linear().cwiseAbs() * field.half_size[i];
        box.add(field.place[i].translation() - half);
        box.add(field.place[i].translation() + half);
        break;
    }
    case SkeletonKind::mesh:
        for (const Vec3f& p : field.mesh[i]->mesh.positions) {
            if (p.allFinite()) box.add(field.place[i] * p.cast<double>());
        }
        break;
    default:
        for (const Vec3& p : points_of(field, i)) box.add(p);
    }
    box.lo.array() -= reach;
    box.hi.array() += reach;
    return box;
}

Vec3i cell_of(const FieldGrid& grid, const Vec3& p)
{
    const Vec3 x = ((p - grid.lo) / grid.cell).array().floor();
    const Vec3 last = (grid.dims.array() - 1).cast<double>();
    return x.cwiseMax(0.0).cwiseMin(last).cast<int>();
}

std::size_t cell_index(const FieldGrid& grid, const Vec3i& c)
{
    return static_cast<std::size_t>(c.x()) +
           static_cast<std::size_t>(grid.dims.x()) *
               (static_cast<std::size_t>(c.y()) +
                static_cast<std::size_t>(grid.dims.y()) * static_cast<std::size_t>(c.z()));
}

template <class Visit> void for_cells(const FieldGrid& grid, const Box& box, const Visit& visit)
{
    const Vec3i lo = cell_of(grid, box.lo), hi = cell_of(grid, box.hi);
    for (int z = lo.z(); z <= hi.z(); ++z) {
        for (int y = lo.y(); y <= hi.y(); ++y) {
            for (int x = lo.x(); x <= hi.x(); ++x) visit(cell_index(grid, {x, y, z}));
        }
    }
}

bool touch(const Box& a, const Box& b)
{
    return (a.lo.array() <= b.hi.array()).all() && (b.lo.array() <= a.hi.array()).all();
}

Box extent(const FieldGrid& grid)
{
    Box box;
    box.add(grid.lo);
    box.add(grid.lo + grid.cell * grid.dims.cast<double>());
    return box;
}

// Cells about half as wide as a mean influence box; at most 16 a skeleton, so that a few far
// outliers cannot blow the grid up.
FieldGrid make_grid(const Field& field)
{
    FieldGrid grid;
    Box all;
    double width = 0;
    std::size_t bounded = 0;
    for (const Box& box : field.influence) {
        if (box.empty() || !box.lo.allFinite()) continue;
        all.add(box);
        width += box.size().maxCoeff();
        ++bounded;
    }
    if (bounded == 0) return grid;
    const double most = 16.0 * static_cast<double>(bounded) + 8;
    grid.lo = all.lo;
    grid.cell = 0.5 * width / static_cast<double>(bounded);
    for (;; grid.cell *= 1.25) {
        const Vec3 dims = (all.size() / grid.cell).array().ceil().max(1.0);
        if (dims.prod() > most) continue;
        grid.dims = dims.cast<int>();
        break;
    }
    grid.first.assign(static_cast<std::size_t>(grid.dims.prod()) + 1, 0);
    const auto each_entry = [&](const auto& visit) {
        for (std::uint32_t i = 0; i < field.count(); ++i) {
            const Box& box = field.influence[i];
            if (box.empty() || !box.lo.allFinite()) continue;
            for_cells(grid, box, [&](std::size_t cell) { visit(cell, i); });
        }
    };
    each_entry([&](std::size_t cell, std::uint32_t) { ++grid.first[cell + 1]; });
    for (std::size_t c = 0; c + 1 < grid.first.size(); ++c) grid.first[c + 1] += grid.first[c];
    grid.skeleton.resize(grid.first.back());
    std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
    each_entry([&](std::size_t cell, std::uint32_t i) { grid.skeleton[next[cell]++] = i; });
    return grid;
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
            "(or none of these); got {}, {} and {}",
            n, layer.contributions.size(), layer.frame.size(), translations.size()));
    }
    for (std::size_t f = 0; f < frames.size(); ++f) {
        if (!is_rigid(frames[f])) {
            throw std::invalid_argument(
                fmt::format("frame {} under an implicit layer must only turn and move", f));
        }
    }
    Field field;
    field.isovalue = layer.isovalue;
    field.rule = layer.blend.rule;
    field.weights = BlendWeights(layer.blend, n);
    field.first.push_back(0);
    for (std::size_t i = 0; i < n; ++i) {
        const Skeleton& s = layer.skeletons[i];
        try {
            check(s);
            if (layer.frame[i] >= frames.size()) {
                throw std::invalid_argument(fmt::format("it rides on frame {}, but there are {}",
                                                        layer.frame[i], frames.size()));
            }
            field.profile.push_back(make_profile(layer.contributions[i], layer.isovalue,
                                                 translations.empty() ? 0 : translations[i]));
        } catch (const std::invalid_argument& wrong) {
            throw std::invalid_argument(fmt::format("skeleton {}: {}", i, wrong.what()));
        }
        const Transform& frame = frames[layer.frame[i]];
        field.kind.push_back(s.kind);
        if (!is_solid(s.kind)) {
            for (const Vec3& p : s.points) field.points.push_back(frame * p);
        }
        field.first.push_back(static_cast<std::uint32_t>(field.points.size()));
        field.place.push_back(frame * s.place);
        field.half_size.push_back(s.half_size);
        field.mesh.push_back(s.kind == SkeletonKind::mesh ? s.mesh : nullptr);
        field.influence.push_back(influence_of(field, i));
        if (s.kind == SkeletonKind::plane) {
            field.unbounded.push_back(static_cast<std::uint32_t>(i));
        }
    }
    field.grid = make_grid(field);
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
    const std::span<const Vec3> points = points_of(field, i);
    switch (field.kind[i]) {
    case SkeletonKind::point:
    case SkeletonKind::segment:
    case SkeletonKind::polyline:
        return foot_on_polyline(points, p);
    case SkeletonKind::triangle:
        return foot_on_triangle(points.first<3>(), p);
    default:
        break;
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
    default:
        result = foot_on_plane(local);
    }
    result.n = turn * result.n;
    result.hessian = turn * result.hessian * turn.transpose();
    return result;
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
        contributors.push_back({i, v.f, v.slope * at.n, at.n, at.hessian});
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
        const double r = foot(field, i, centre).r;
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

namespace {

// Adds skeleton i's contribution at every point of the block.
void add_skeleton(const Field& field, std::uint32_t i, const FieldBlock& block,
                  FieldScratch& scratch, BlockValues& sum)
{
    const SkeletonKind kind = field.kind[i];
    if (kind == SkeletonKind::point || kind == SkeletonKind::segment ||
        kind == SkeletonKind::polyline) {
        return add_polyline(points_of(field, i), field.profile[i], block, sum);
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
        if (foot(field, i, centre).r - radius < field.profile[i].R) near.push_back(i);
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
                const Foot at = foot(field, c.skeleton, block.point(k));
                c.n = at.n;
                c.hessian = at.hessian;
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

namespace {

// One block: points[order[begin .. end)], or points[begin .. end) without an order.
struct BlockTask {
    const Field& field;
    std::span<const Vec3> points;
    std::span<const std::uint32_t> order;
    std::span<double> f;
    std::span<Vec3> gradient;

    std::size_t index(std::size_t i) const { return order.empty() ? i : order[i]; }

    void run(std::size_t begin, std::size_t end) const
    {
        thread_local FieldScratch scratch;
        thread_local FieldBlock block;
        thread_local BlockValues values;
        thread_local std::vector<std::uint32_t> near;
        block.count = 0;
        Box box;
        for (std::size_t i = begin; i < end && !order.empty(); ++i) {
            __builtin_prefetch(&points[order[i]]);
        }
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3& p = points[index(i)];
            // Far outside stands for nowhere: its squared distances stay finite.
            block.add(p.allFinite() ? p : Vec3(Vec3::Constant(1e150)));
            if (p.allFinite()) box.add(p);
        }
        block.pad();
        if (box.empty()) {
            near.clear();
        } else {
            candidates(field, box, near);
        }
        evaluate(field, near, block, scratch, values);
        for (std::size_t i = begin; i < end; ++i) {
            f[index(i)] = values.f[i - begin];
            if (!gradient.empty()) gradient[index(i)] = values.gradient(i - begin);
        }
    }
};

// Whether consecutive points are near each other already: seeds, grid blocks, mesh vertices.
bool coherent(const FieldGrid& grid, std::span<const Vec3> points)
{
    constexpr std::size_t block = FieldBlock::capacity, looks = 16;
    const std::size_t blocks = (points.size() + block - 1) / block;
    std::size_t narrow = 0;
    for (std::size_t look = 0; look < looks; ++look) {
        const std::size_t begin = look * blocks / looks * block;
        Box box;
        for (std::size_t i = begin; i < std::min(points.size(), begin + block); ++i) {
            box.add(points[i]);
        }
        narrow += box.diagonal() < 4 * grid.cell;
    }
    return narrow * 2 >= looks;
}

// Counting sort: order[start[c] .. start[c + 1]) are the points of cell c. Returns how many cells.
std::size_t sort_by_cell(const FieldGrid& grid, std::span<const Vec3> points,
                         std::span<std::uint32_t> cell, std::span<std::uint32_t> order,
                         std::vector<std::uint32_t>& start)
{
    // The field's own cells are as wide as an influence: points of a quarter of that share few
    // skeletons that reach some of them and not others.
    FieldGrid coarse;
    coarse.lo = grid.lo;
    coarse.dims = 4 * grid.dims;
    coarse.cell = 0.25 * grid.cell;
    const double most = static_cast<double>(points.size()) / 64 + 1;
    while (coarse.dims.cast<double>().prod() > most) {
        coarse.cell *= 1.1;
        coarse.dims = (grid.dims.cast<double>() * (grid.cell / coarse.cell))
                          .array()
                          .ceil()
                          .max(1.0)
                          .matrix()
                          .cast<int>();
    }
    const auto cells = static_cast<std::size_t>(coarse.dims.cast<double>().prod());
    parallel_for(points.size(), 8192, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            cell[i] =
                points[i].allFinite()
                    ? static_cast<std::uint32_t>(cell_index(coarse, cell_of(coarse, points[i])))
                    : 0;
        }
    });
    start.assign(cells + 1, 0);
    for (std::size_t i = 0; i < points.size(); ++i) ++start[cell[i] + 1];
    for (std::size_t c = 0; c < cells; ++c) start[c + 1] += start[c];
    for (std::uint32_t i = 0; i < points.size(); ++i) order[start[cell[i]]++] = i;
    for (std::size_t c = cells; c > 0; --c) start[c] = start[c - 1];
    start[0] = 0;
    return cells;
}

}  // namespace

void evaluate(const Field& field, std::span<const Vec3> points, std::span<double> f,
              std::span<Vec3> gradient)
{
    if (f.size() != points.size() || (!gradient.empty() && gradient.size() != points.size())) {
        throw std::invalid_argument(
            fmt::format("a field asked at {} points needs room for as many values and gradients "
                        "(or no gradients), got {} and {}",
                        points.size(), f.size(), gradient.size()));
    }
    if (points.size() > 0xffffffffu) {
        throw std::invalid_argument("a field can be asked at 2^32 points at most in one call");
    }
    constexpr std::size_t capacity = FieldBlock::capacity;
    const FieldGrid& grid = field.grid;
    if (points.size() <= capacity || grid.cell_count() < 2 || coherent(grid, points)) {
        const BlockTask task{field, points, {}, f, gradient};
        const std::size_t blocks = (points.size() + capacity - 1) / capacity;
        parallel_for(blocks, 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) {
                task.run(b * capacity, std::min(points.size(), (b + 1) * capacity));
            }
        });
        return;
    }

    // Scattered points: sorted into cells of some 64 points, then cell by cell; in tiles whose
    // points and results stay in cache.
    const std::size_t tile = std::clamp<std::size_t>(512 * field.count(), 1 << 18, 1 << 20);
    std::vector<std::uint32_t> cell(std::min(tile, points.size())), order(cell.size()), start;
    for (std::size_t begin = 0; begin < points.size(); begin += tile) {
        const std::size_t n = std::min(tile, points.size() - begin);
        const std::size_t cells = sort_by_cell(grid, points.subspan(begin, n), cell, order, start);
        const BlockTask task{field, points.subspan(begin, n), order, f.subspan(begin, n),
                             gradient.empty() ? gradient : gradient.subspan(begin, n)};
        parallel_for(cells, 8, [&](std::size_t from, std::size_t to) {
            for (std::size_t c = from; c < to; ++c) {
                for (std::size_t i = start[c]; i < start[c + 1]; i += capacity) {
                    task.run(i, std::min<std::size_t>(start[c + 1], i + capacity));
                }
            }
        });
    }
}

}  // namespace geometry
