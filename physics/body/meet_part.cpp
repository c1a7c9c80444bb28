#include "physics/body/meet_part.hpp"

#include "geometry/cubes/trilinear.hpp"
#include "physics/body/box_regions.hpp"
#include "physics/body/places_on_way.hpp"
#include "physics/body/plane_touch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

// Map: cubes that may be met; in one of them; before them; on the way.

namespace physics {
namespace {

using geometry::Box;
using geometry::Box3f;
using geometry::Vec3f;

Vec3 corner_in(const double* field, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{slot});
}

std::array<Vec3, 8> corners_of_cube(const StepOfParts& step, std::uint32_t cube)
{
    std::array<Vec3, 8> x;
    for (std::size_t a = 0; a < 8; ++a) x[a] = corner_in(step.x, step.shapes.corners[cube][a]);
    return x;
}

// Where a point would be in a cube of the target when it is `behind` (m) where it is.
std::optional<PartMeeting> meet_in(const StepOfParts& step, const Arriving& point,
                                   const Target& target, std::uint32_t cube, const Vec3& behind)
{
    constexpr double slack = 1e-6;     // cubes: what lies on a face is in both cubes
    constexpr double rounding = 1e-6;  // cubes: of what lies no deeper, the side is not known
    const PartShapes& shapes = step.shapes;
    const double size = shapes.size_of(target.part);
    const auto in = find_in_cube(corners_of_cube(step, cube), size, point.p - behind, slack);
    if (!in) return std::nullopt;
    const std::array<double, 8> weight = geometry::trilinear_weights(in->u);
    Vec3 velocity = point.v;  // relative to the matter there
    for (std::size_t a = 0; a < 8; ++a) {
        velocity -= weight[a] * corner_in(step.v, shapes.corners[cube][a]);
    }
    // How it got to where a step begins is not known.
    const Vec3 way =
        step.look == Look::ahead ? Vec3(Vec3::Zero()) : Vec3(step.dt * velocity - behind);
    auto gap = find_gap({shapes, target.part, cube, *in}, {way, point.outward(), point.own});
    if (!gap) return std::nullopt;
    gap->size += behind.dot(gap->normal);
    if (!(gap->size < -rounding * size)) return std::nullopt;
    return PartMeeting{cube, *in, *gap};
}

// How far before a face a point may be to be told of it, cubes of size `h`: more where it looks
// ahead at speed.
constexpr double most_ahead = 1;
double reach_before(const StepOfParts& step, const Arriving& point, double way, double h)
{
    const double around = point.around / h;
    if (step.look == Look::back) return known_before + around;
    return std::min(known_before + way / h, most_ahead) + around;
}

// Before the target's cubes `near`, that a point is in none of: before the one that it is nearest
// to, among three whose middles are.
std::optional<PartMeeting> meet_before(const StepOfParts& step, const Arriving& point,
                                       const Target& target, const std::vector<NearCube>& near,
                                       double reach)
{
    const double h = step.shapes.size_of(target.part);
    const Vec3f p = point.p.cast<float>();
    constexpr std::size_t tried = 3;
    std::array<std::pair<float, std::uint32_t>, tried> nearest;
    nearest.fill({std::numeric_limits<float>::infinity(), 0});
    for (std::uint32_t i = 0; i < near.size(); ++i) {
        const Box3f& box = near[i].box;
        const std::pair<float, std::uint32_t> here{(0.5f * (box.lo + box.hi) - p).squaredNorm(), i};
        if (!(here < nearest.back())) continue;
        nearest.back() = here;
        std::sort(nearest.begin(), nearest.end());
    }
    std::optional<InCube> best;
    std::uint32_t cube = 0;
    double least = reach;
    for (const auto& [distance, at] : nearest) {
        if (!std::isfinite(distance)) break;
        const auto& [box, c] = near[at];
        // It is no further from the cube than that many of the cube's edges.
        const double most = least * double((box.hi - box.lo).norm());
        if (box.distance_sq(point.p) > most * most) continue;
        const auto in = find_in_cube(corners_of_cube(step, c), h, point.p, least);
        if (!in) continue;
        const double off = std::max({0.0, -in->u.minCoeff(), in->u.maxCoeff() - 1});
        if (best && off >= least) continue;
        best = in, cube = c, least = off;
    }
    if (!best) return std::nullopt;
    const AtRest rest{step.shapes, target.part, cube, *best};
    const auto gap = find_distance(rest, point.outward(), reach * h, point.own);
    if (!gap) return std::nullopt;
    return PartMeeting{cube, *best, *gap};
}

}  // namespace

Vec3 way_ahead(const Vec3& way, double h)
{
    const double most = (most_ahead - known_before) * h;
    return way * std::min(1.0, most / std::max(most, way.norm()));
}

Target target_of(const StepOfParts& step, std::uint32_t part)
{
    Target out;
    out.part = part;
    for (const auto slot : step.shapes.slots[part]) {
        out.box.add(corner_in(step.x, slot));
        out.velocity += corner_in(step.v, slot);
    }
    out.velocity /= static_cast<double>(step.shapes.slots[part].size());
    return out;
}

void fill_target(const StepOfParts& step, const std::vector<Box>& regions, Target& target)
{
    const BoxRegions near(regions);
    for (const auto c : step.shapes.cubes[target.part]) {
        Box box;
        for (const auto k : step.shapes.corners[c]) box.add(corner_in(step.x, k));
        if (!near.meet(box)) continue;
        // Wider by more than what single precision rounds.
        const double far = box.lo.cwiseAbs().cwiseMax(box.hi.cwiseAbs()).maxCoeff();
        const Box margin = wider(box, 1e-3 * step.shapes.size_of(target.part) + 1e-6 * far);
        const Box3f wide{margin.lo.cast<float>(), margin.hi.cast<float>()};
        if (!wide.lo.allFinite() || !wide.hi.allFinite()) continue;
        target.cubes.push_back(c);
        target.boxes.push_back(wide);
    }
    target.tree = geometry::build_box_tree(target.boxes);
}

std::optional<PartMeeting> first_meeting(const StepOfParts& step, const Arriving& point,
                                         const Target& target, NearCubes& near,
                                         std::vector<NearCube>& close)
{
    constexpr double stride = 0.4;  // of a cube
    constexpr int most = 64;        // places on a short way
    const Vec3 way = step.dt * (point.v - target.velocity);
    const double h = step.shapes.size_of(target.part);
    const double strides = std::ceil(way.norm() / (stride * h));
    if (!std::isfinite(strides)) return std::nullopt;
    const int places = std::clamp(static_cast<int>(std::min(strides, double(most))), 1, most);
    const int first = step.look == Look::ahead ? places : 1;
    const double reach = reach_before(step, point, way.norm(), h);
    Box about;
    about.add(point.p);
    about.add(step.look == Look::back ? Vec3(point.p - way) : point.p + way_ahead(way, h));
    about = wider(about, known_before * h + point.around);
    const Box3f span{about.lo.cast<float>(), about.hi.cast<float>()};
    near.meeting(span, close);
    if (close.empty()) return std::nullopt;
    Places look{double(first), double(places), 1, double(places)};
    if (first == 1 && strides > most) {
        Box3f all;
        for (const auto& [box, cube] : close) all.add(box);
        look = places_within(all, point.p, way, strides);
    }
    for (double place = look.from; place <= look.to; place += look.step) {
        const Vec3 behind = (1 - place / look.of) * way;
        const Vec3f p = (point.p - behind).cast<float>();
        for (const auto& [box, cube] : close) {
            if (!box.overlaps({p, p})) continue;
            if (auto found = meet_in(step, point, target, cube, behind)) return found;
        }
    }
    return meet_before(step, point, target, close, reach);
}

}  // namespace physics
