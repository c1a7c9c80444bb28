#include "physics/state/glue.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::Vec3i;

// A model, and which of its parts each corner is of.
struct Side {
    const Cubes* cubes;
    std::vector<std::uint32_t> part;     // K, the first corner of it
    std::vector<std::uint32_t> cube_of;  // K, one that has it
    geometry::CubeFinder finder;
    Vec3 lo, hi;  // m, of all cubes

    explicit Side(const Cubes& of) : cubes(&of), cube_of(of.corner_count()), finder(of)
    {
        geometry::UnionFind sets(of.corner_count());
        for (std::uint32_t c = 0; c < of.count(); ++c) {
            for (const auto k : of.corners[c]) sets.join(k, of.corners[c][0]), cube_of[k] = c;
        }
        part = sets.roots();
        Vec3i low = of.cell[0], high = of.cell[0];
        for (const Vec3i& cell : of.cell) low = low.cwiseMin(cell), high = high.cwiseMax(cell);
        lo = of.origin + of.size * low.cast<double>();
        hi = of.origin + of.size * (high.cast<double>() + Vec3::Ones());
    }
    std::uint32_t part_of(std::uint32_t cube) const { return part[cubes->corners[cube][0]]; }
};

// Of a part, the cube that is nearest to a corner of another.
struct Near {
    std::uint32_t cube;
    std::pair<double, double> key;  // m, from the cube and from its centre
    Vec3 at;                        // in the cube
};

// For each part of `side` within reach of p but one of those there may be.
std::map<std::uint32_t, Near> near_parts(const Side& side, const Vec3& p, double reach,
                                         std::optional<std::uint32_t> but)
{
    std::map<std::uint32_t, Near> out;
    if (((p - side.hi).array() > reach).any() || ((side.lo - p).array() > reach).any()) return out;
    const double h = side.cubes->size;
    const Vec3 u = (p - side.cubes->origin) / h;
    const Vec3i first = (u.array() - reach / h).floor().cast<int>();
    const Vec3i last = (u.array() + reach / h).floor().cast<int>();
    const auto visit = [&](const Vec3i& cell) {
        const Vec3 at = u - cell.cast<double>();
        const double away = h * (at - at.cwiseMax(0).cwiseMin(1)).norm();
        if (away > reach) return;
        const std::pair key{away, h * (at - Vec3::Constant(0.5)).norm()};
        const auto found = side.finder.in_cell(cell);
        for (std::uint32_t c = found.begin; c < found.end; ++c) {
            const std::uint32_t part = side.part_of(c);
            if (part == but) continue;
            const auto [entry, fresh] = out.try_emplace(part, Near{c, key, at});
            if (!fresh && key < entry->second.key) entry->second = {c, key, at};
        }
    };
    for (int z = first.z(); z <= last.z(); ++z) {
        for (int y = first.y(); y <= last.y(); ++y) {
            for (int x = first.x(); x <= last.x(); ++x) visit({x, y, z});
        }
    }
    return out;
}

// Where `model` is 0 or 1: of the corner.
JointPoint point_at(const Side& side, std::uint32_t corner, std::size_t model, const Side& other,
                    const Near& near)
{
    JointPoint out;
    const auto weight = geometry::trilinear_weights(near.at);
    for (std::size_t a = 0; a < 8; ++a) {
        out.corner[8 * model + a] = corner;
        out.corner[8 * (1 - model) + a] = other.cubes->corners[near.cube][a];
        out.weight[8 * (1 - model) + a] = model == 0 ? -weight[a] : weight[a];
    }
    out.weight[8 * model] = model == 0 ? 1 : -1;
    const std::uint32_t own = side.cube_of[corner];
    out.stiffness[model] = side.cubes->young[own] * side.cubes->size;
    out.stiffness[1 - model] = other.cubes->young[near.cube] * other.cubes->size;
    return out;
}

// By the first corners of two parts: the points at corners of each.
using Meetings =
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<std::vector<JointPoint>, 2>>;

// The corners of all parts of sides[model] that are near the other side's.
void add_meetings(std::span<const Side> sides, std::size_t model, double reach, Meetings& to)
{
    const bool same = sides.size() == 1;
    const Side& side = sides[same ? 0 : model];
    const Side& other = sides[same ? 0 : 1 - model];
    for (std::uint32_t k = 0; k < side.cubes->corner_count(); ++k) {
        geometry::stop_if_asked();
        const std::uint32_t own = side.part[k];
        const auto but = same ? std::optional(own) : std::nullopt;
        for (const auto& [part, near] :
             near_parts(other, side.cubes->corner_position(k), reach, but)) {
            // Of one model, the part of the smaller number is the first of the two.
            if (same && (own < part) != (model == 0)) continue;
            const auto pair = model == 0 ? std::pair{own, part} : std::pair{part, own};
            to[pair][model].push_back(point_at(side, k, model, other, near));
        }
    }
}

std::size_t parts_of(const Side& side)
{
    std::size_t out = 0;
    for (std::uint32_t k = 0; k < side.part.size(); ++k) out += side.part[k] == k;
    return out;
}

Glued count_of(std::span<const Side> sides, const Meetings& meetings)
{
    Glued out;
    std::array<std::vector<std::uint8_t>, 2> seen;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        out.parts += parts_of(sides[i]);
        seen[i].resize(sides[i].part.size(), 0);
    }
    for (const auto& [pair, points] : meetings) {
        seen[0][pair.first] = 1;
        seen[sides.size() - 1][pair.second] = 1;
    }
    out.loose = out.parts;
    for (const auto& of : seen) out.loose -= std::size_t(std::count(of.begin(), of.end(), 1));
    return out;
}

constexpr double most_reach = 2;  // edges of the smaller cubes

[[noreturn]] void fail_apart(std::span<const Side> sides, double edge, double reach)
{
    double tried = reach;
    for (double wider = 2 * reach; wider <= most_reach * edge; wider *= 2) {
        tried = wider;
        Meetings found;
        add_meetings(sides, 0, wider, found);
        add_meetings(sides, 1, wider, found);
        if (found.empty()) continue;
        throw std::invalid_argument(fmt::format(
            "no two parts of `cubes` come nearer than {:.3g} m, and some come nearer than "
            "{:.3g} m: set reach = {:.3g}, or move the parts together",
            reach, wider, wider));
    }
    throw std::invalid_argument(fmt::format(
        "no two parts of `cubes` come nearer than {:.3g} m: move the parts together", tried));
}

}  // namespace

PartJoint make_glue(std::span<const std::shared_ptr<const Cubes>> models, double reach,
                    Glued* glued)
{
    std::vector<Side> sides;
    double edge = models[0]->size;
    for (const auto& cubes : models) {
        sides.emplace_back(*cubes);
        edge = std::min(edge, cubes->size);
    }
    // A second layer of corners is an edge away: half of that would take both where parts lie half
    // an edge apart.
    const double within = reach > 0 ? reach : edge / 4;
    if (within > most_reach * edge) {
        throw std::invalid_argument(fmt::format(
            "expected a reach of at most {:.3g} m, two edges of the smaller cubes, found {:.3g} m: "
            "move the parts together",
            most_reach * edge, within));
    }
    Meetings meetings;
    add_meetings(sides, 0, within, meetings);
    add_meetings(sides, 1, within, meetings);
    if (meetings.empty()) fail_apart(sides, edge, within);
    PartJoint out;
    out.cubes = {mark_of(*models.front()), mark_of(*models.back())};
    for (const auto& [pair, of] : meetings) {
        const auto& points = of[0].size() > of[1].size() ? of[0] : of[1];
        out.points.insert(out.points.end(), points.begin(), points.end());
    }
    if (glued) *glued = count_of(sides, meetings);
    return out;
}

}  // namespace physics
