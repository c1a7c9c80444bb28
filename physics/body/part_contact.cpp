#include "physics/body/part_contact.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

// Map: boxes of parts, and the pairs that are near; the cubes of a part that may be touched; where
// a place lies in a cube; how deep it lies in the part; the contacts of some points.

namespace physics {
namespace {

using geometry::Box;
using geometry::Box3f;
using geometry::BoxTree;
using geometry::Mat3;
using geometry::Vec3f;

Vec3 corner_of(const double* field, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{slot});
}

bool overlap(const Box& a, const Box& b)
{
    return (a.lo.array() <= b.hi.array()).all() && (b.lo.array() <= a.hi.array()).all();
}

Box wider(Box box, double by)
{
    box.lo.array() -= by;
    box.hi.array() += by;
    return box;
}

// With where it was before it went `way`.
Box swept(Box box, const Vec3& way)
{
    const Box now = box;
    box.add(Vec3(now.lo - way));
    box.add(Vec3(now.hi - way));
    return box;
}

Box box_of(const double* x, const std::array<std::uint32_t, 8>& corners)
{
    Box box;
    for (const auto k : corners) box.add(corner_of(x, k));
    return box;
}

// A step's view of what may touch.
struct Scene {
    const PartShapes& shapes;
    const double* x;
    const double* v;
    double dt;
    ContactLaw law;
    double stiffest;  // N/m
};

// The cubes of a part that lie where another one may be, at x.
struct Target {
    std::uint32_t part = 0;
    Vec3 velocity = Vec3::Zero();  // m/s, the mean of its corners
    std::vector<std::uint32_t> cubes;
    std::vector<Box3f> boxes;  // of each, with room around it
    BoxTree tree;
};

// Points of part `from` that may be in part `target`, an index into targets.
struct Job {
    std::uint32_t from = 0, target = 0;
    std::size_t begin = 0, end = 0;  // of its cubes with points
};

void fill_target(const Scene& scene, const std::vector<Box>& regions, Target& target)
{
    for (const auto c : scene.shapes.cubes[target.part]) {
        const Box box = box_of(scene.x, scene.shapes.corners[c]);
        const auto in = [&](const Box& region) { return overlap(region, box); };
        if (std::none_of(regions.begin(), regions.end(), in)) continue;
        // Wider by more than what single precision rounds.
        const double far = box.lo.cwiseAbs().cwiseMax(box.hi.cwiseAbs()).maxCoeff();
        const Box margin = wider(box, 1e-3 * scene.shapes.size + 1e-6 * far);
        const Box3f wide{margin.lo.cast<float>(), margin.hi.cast<float>()};
        if (!wide.lo.allFinite() || !wide.hi.allFinite()) continue;
        target.cubes.push_back(c);
        target.boxes.push_back(wide);
    }
    target.tree = geometry::build_box_tree(target.boxes);
}

// A place in a cube that is bent: 0..1 along its axes, and what they become there.
struct InCube {
    Vec3 u;
    Mat3 axes;  // m, columns dx / du
};

InCube place_in(const std::array<Vec3, 8>& x, const Vec3& u, Vec3& p)
{
    InCube out{u, Mat3::Zero()};
    // Between the ends along x, then along y, then along z.
    std::array<Vec3, 4> along_x, slope_x;
    for (std::size_t i = 0; i < 4; ++i) {
        slope_x[i] = x[2 * i + 1] - x[2 * i];
        along_x[i] = x[2 * i] + u.x() * slope_x[i];
    }
    const Vec3 rise_low = along_x[1] - along_x[0], rise_high = along_x[3] - along_x[2];
    const Vec3 low = along_x[0] + u.y() * rise_low, high = along_x[2] + u.y() * rise_high;
    const Vec3 slope_low = slope_x[0] + u.y() * (slope_x[1] - slope_x[0]);
    const Vec3 slope_high = slope_x[2] + u.y() * (slope_x[3] - slope_x[2]);
    p = low + u.z() * (high - low);
    out.axes.col(0) = slope_low + u.z() * (slope_high - slope_low);
    out.axes.col(1) = rise_low + u.z() * (rise_high - rise_low);
    out.axes.col(2) = high - low;
    return out;
}

// u with p = sum w_a(u) x_a, by Newton's method. None where p is not in the cube, or the cube is
// flat or inside out there.
std::optional<InCube> find_in_cube(const std::array<Vec3, 8>& x, double size, const Vec3& p)
{
    constexpr double slack = 1e-6;  // of a cube: what lies on a face is in both cubes
    Vec3 u = Vec3::Constant(0.5), here;
    for (int round = 0; round < 12; ++round) {
        const InCube in = place_in(x, u, here);
        if (!(in.axes.determinant() > 1e-6 * size * size * size)) return std::nullopt;
        const Vec3 off = p - here;
        if (off.norm() <= 1e-10 * size) {
            const bool inside = u.minCoeff() >= -slack && u.maxCoeff() <= 1 + slack;
            return inside ? std::optional(in) : std::nullopt;
        }
        u = (u + in.axes.inverse() * off).cwiseMax(-1.0).cwiseMin(2.0);
    }
    return std::nullopt;
}

// Of a point in another part's matter: how it came there in this step, and which way its own
// surface faces.
struct Approach {
    Vec3 way, outward;  // m, unit
};

// How deep the point that is in a cube of part `part` lies in that part's shape. It leaves through
// the nearest side, but not through one that faces as its own surface does, as the side of a block
// does for the lower rim of what stands on it, and not through the far one if it came fast. None
// where it is not inside.
std::optional<Gap> find_gap(const PartShapes& shapes, std::uint32_t part, std::uint32_t cube,
                            const InCube& in, const Approach& approach)
{
    constexpr double facing = -0.3;  // cosine; corners of blocks face their neighbours at -0.58
    constexpr double deep = 0.25;    // cubes; from there on any side is better than none
    const auto& shape = shapes.shape[part];
    const Mat3 back = (in.axes / shapes.size).inverse();  // F^-1
    const Vec3 place = shapes.origin + shapes.size * (shapes.cell[cube].cast<double>() + in.u);
    if (!shape.inside(place)) return std::nullopt;
    const auto hit = shape.closest(place);
    if (!hit) return std::nullopt;
    double depth = hit.distance;
    Vec3 normal = hit.normal;
    if (depth > 1e-9 * shapes.size) normal = (hit.point - place) / depth;
    const Vec3 came = (1 + 1e-6) * (back * approach.way);
    const Vec3 outward = (back * approach.outward).normalized();
    const auto faces_it = [&](const Vec3& n) { return outward.dot(n) <= facing; };
    const bool through = came.norm() > depth && came.dot(normal) > 0;
    if (through || !faces_it(normal)) {
        const auto left_along = [&](const Vec3& from) {
            const auto entry = shape.entry(place - from, place);
            if (!entry || !faces_it(entry.normal)) return false;
            normal = entry.normal;
            depth = std::max(0.0, (entry.point - place).dot(normal));
            return true;
        };
        const bool left = (through && left_along(came)) || left_along(2 * shapes.size * outward);
        if (!left && depth < deep * shapes.size) return std::nullopt;
    }
    const Vec3 turned = back.transpose() * normal;
    const double length = turned.norm();
    if (!(length > 0) || !std::isfinite(length) || !(depth > 0)) return std::nullopt;
    return Gap{-depth / length, turned / length, Vec3::Zero()};
}

// A point of a part's shape on its way.
struct Moving {
    std::uint32_t cube = 0;
    const ShapePoint* point = nullptr;
    std::array<double, 8> weight{};
    Vec3 p = Vec3::Zero(), v = Vec3::Zero();  // m, m/s
};

std::array<double, 8> trilinear(const Vec3& u)
{
    std::array<double, 8> weight;
    for (unsigned a = 0; a < 8; ++a) {
        weight[a] = ((a & 1) ? u.x() : 1 - u.x()) * ((a & 2) ? u.y() : 1 - u.y()) *
                    ((a & 4) ? u.z() : 1 - u.z());
    }
    return weight;
}

Moving moving_point(const Scene& scene, std::uint32_t cube, const ShapePoint& point)
{
    Moving out{cube, &point};
    const Vec3 u = point.place.cast<double>();
    out.weight = trilinear(u);
    for (std::size_t a = 0; a < 8; ++a) {
        const auto slot = scene.shapes.corners[cube][a];
        out.p += out.weight[a] * corner_of(scene.x, slot);
        out.v += out.weight[a] * corner_of(scene.v, slot);
    }
    return out;
}

// The unit vector out of the matter that the point is on.
Vec3 outward_of(const Scene& scene, const Moving& moving)
{
    std::array<Vec3, 8> x;
    for (std::size_t a = 0; a < 8; ++a) {
        x[a] = corner_of(scene.x, scene.shapes.corners[moving.cube][a]);
    }
    Vec3 p;
    const Mat3 axes = place_in(x, moving.point->place.cast<double>(), p).axes;
    if (!(std::abs(axes.determinant()) > 0)) return Vec3::Zero();
    return (axes.inverse().transpose() * moving.point->normal.cast<double>()).normalized();
}

// Where a point would be in a cube of the target when it is `behind` (m) where it is.
std::optional<PointContact> contact_in(const Scene& scene, const Moving& moving,
                                       const Target& target, std::uint32_t cube, const Vec3& behind)
{
    const PartShapes& shapes = scene.shapes;
    std::array<Vec3, 8> x;
    const auto& others = shapes.corners[cube];
    for (std::size_t a = 0; a < 8; ++a) x[a] = corner_of(scene.x, others[a]);
    const auto in = find_in_cube(x, shapes.size, moving.p - behind);
    if (!in) return std::nullopt;
    const std::array<double, 8> weight = trilinear(in->u);
    Vec3 velocity = moving.v;  // relative to the matter there
    for (std::size_t a = 0; a < 8; ++a) velocity -= weight[a] * corner_of(scene.v, others[a]);
    auto gap = find_gap(shapes, target.part, cube, *in,
                        {scene.dt * velocity - behind, outward_of(scene, moving)});
    if (!gap) return std::nullopt;
    gap->size += behind.dot(gap->normal);
    if (!(gap->size < 0)) return std::nullopt;
    gap->velocity = velocity;
    const double h = shapes.size, area = double(moving.point->area);
    const double young = std::min(shapes.stiffness[moving.cube], shapes.stiffness[cube]);
    const double mass = std::min(shapes.mass[moving.cube] * std::min(1.0, area / (h * h)),
                                 double(shapes.mass[cube]));
    const double stiffness =
        std::min(10 * young * area / h, scene.stiffest) + mass / (scene.dt * scene.dt);
    PointContact contact = contact_at(*gap, stiffness, scene.law);
    contact.count = PointContact::most;
    for (std::size_t a = 0; a < 8; ++a) {
        contact.corners[a] = shapes.corners[moving.cube][a];
        contact.weight[a] = static_cast<float>(moving.weight[a]);
        contact.corners[8 + a] = others[a];
        contact.weight[8 + a] = -static_cast<float>(weight[a]);
    }
    return contact;
}

// The contact of a point with one of the target's cubes `near`, at the first place on its way where
// it is inside.
std::optional<PointContact> first_contact(const Scene& scene, const Moving& moving,
                                          const Target& target,
                                          const std::vector<std::uint32_t>& near)
{
    constexpr double stride = 0.4;  // of a cube
    constexpr int most = 64;        // places on the way
    const Vec3 way = scene.dt * (moving.v - target.velocity);
    const double strides = std::ceil(way.norm() / (stride * scene.shapes.size));
    if (!std::isfinite(strides)) return std::nullopt;
    const int places = std::clamp(static_cast<int>(std::min(strides, double(most))), 1, most);
    for (int place = 1; place <= places; ++place) {
        const Vec3 behind = (1 - double(place) / places) * way;
        const Vec3f p = (moving.p - behind).cast<float>();
        for (const auto i : near) {
            if (!target.boxes[i].overlaps({p, p})) continue;
            const auto cube = target.cubes[i];
            if (auto contact = contact_in(scene, moving, target, cube, behind)) return contact;
        }
    }
    return std::nullopt;
}

void look(const Scene& scene, const Job& job, const Target& target, const Box& target_box,
          std::vector<PointContact>& out)
{
    const PartShapes& shapes = scene.shapes;
    const auto holders = shapes.holders[job.from];
    std::vector<std::uint32_t> near;  // of the target's cubes
    for (std::size_t i = job.begin; i < job.end; ++i) {
        const std::uint32_t holder = holders[i], cube = shapes.holder[holder];
        const auto& corners = shapes.corners[cube];
        // Points that lie in no cube are carried by one nearby.
        const Box own = box_of(scene.x, corners);
        Vec3 velocity = -target.velocity;
        for (const auto k : corners) velocity += corner_of(scene.v, k) / 8;
        const Box reach = swept(wider(own, 0.5 * own.diagonal()), scene.dt * velocity);
        if (!overlap(reach, target_box)) continue;
        near.clear();
        target.tree.overlapping({reach.lo.cast<float>(), reach.hi.cast<float>()},
                                [&](std::uint32_t c) { near.push_back(c); });
        if (near.empty()) continue;
        std::sort(near.begin(), near.end());
        for (auto p = shapes.point_at[holder]; p < shapes.point_at[holder + 1]; ++p) {
            const Moving moving = moving_point(scene, cube, shapes.point[p]);
            if (const auto contact = first_contact(scene, moving, target, near)) {
                out.push_back(*contact);
            }
        }
    }
}

// Where the boxes of parts overlap now: the regions of each part's cubes, and who looks into whom.
struct Meetings {
    std::vector<Target> targets;
    std::vector<std::vector<Box>> regions;  // of each target
    std::vector<Box> box;                   // of each target
    std::vector<Job> jobs;
};

Meetings find_meetings(const Scene& scene, const std::vector<PartPair>& pairs)
{
    constexpr std::size_t grain = 64;  // cubes with points
    const PartShapes& shapes = scene.shapes;
    Meetings out;
    std::vector<std::uint32_t> target_of(shapes.parts(), geometry::no_index);
    const auto target = [&](std::uint32_t part) {
        if (target_of[part] == geometry::no_index) {
            target_of[part] = static_cast<std::uint32_t>(out.targets.size());
            out.targets.push_back({part, Vec3::Zero(), {}, {}, {}});
            Box& box = out.box.emplace_back();
            auto& velocity = out.targets.back().velocity;
            for (const auto slot : shapes.slots[part]) {
                box.add(corner_of(scene.x, slot));
                velocity += corner_of(scene.v, slot);
            }
            velocity /= static_cast<double>(shapes.slots[part].size());
        }
        return target_of[part];
    };
    for (const auto& pair : pairs) target(pair.a), target(pair.b);
    out.regions.resize(out.targets.size());
    for (const auto& pair : pairs) {
        const auto a = target(pair.a), b = target(pair.b);
        // Points may lie outside of their cubes, and may have passed through the other part.
        const double margin = shapes.size;
        const Vec3 way = scene.dt * (out.targets[a].velocity - out.targets[b].velocity);
        const Box box_a = swept(wider(out.box[a], margin), way);
        const Box box_b = swept(wider(out.box[b], margin), -way);
        const Box region{box_a.lo.cwiseMax(box_b.lo), box_a.hi.cwiseMin(box_b.hi)};
        if (region.empty()) continue;
        out.regions[a].push_back(region);
        out.regions[b].push_back(region);
        for (const auto& [from, into] : {std::pair{pair.a, b}, std::pair{pair.b, a}}) {
            const std::size_t holders = shapes.holders[from].size();
            for (std::size_t i = 0; i < holders; i += grain) {
                out.jobs.push_back({from, into, i, std::min(holders, i + grain)});
            }
        }
    }
    return out;
}

}  // namespace

std::vector<PartPair> near_parts(const PartShapes& shapes, const double* x, const double* v,
                                 double dt)
{
    const std::size_t parts = shapes.parts();
    std::vector<Box> box(parts);
    for (std::size_t p = 0; p < parts; ++p) {
        for (const auto slot : shapes.slots[p]) {
            box[p].add(corner_of(x, slot));
            box[p].add(Vec3(corner_of(x, slot) + dt * corner_of(v, slot)));
        }
        box[p] = wider(box[p], shapes.size);
    }
    std::vector<std::uint32_t> order(parts);
    for (std::uint32_t p = 0; p < parts; ++p) order[p] = p;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return box[a].lo.x() < box[b].lo.x();
    });
    std::vector<PartPair> pairs;
    for (std::size_t i = 0; i < parts; ++i) {
        for (std::size_t j = i + 1; j < parts; ++j) {
            if (box[order[j]].lo.x() > box[order[i]].hi.x()) break;
            if (!overlap(box[order[i]], box[order[j]])) continue;
            const PartPair pair{std::min(order[i], order[j]), std::max(order[i], order[j])};
            if (!std::binary_search(shapes.overlapping.begin(), shapes.overlapping.end(), pair)) {
                pairs.push_back(pair);
            }
        }
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

std::vector<PointContact> find_part_contacts(const PartShapes& shapes,
                                             const std::vector<PartPair>& pairs, const double* x,
                                             const double* v, double dt, double tangent)
{
    if (pairs.empty()) return {};
    const double h = shapes.size;
    const Scene scene{shapes,
                      x,
                      v,
                      dt,
                      {shapes.friction, 1e-4 * h / dt, tangent},
                      1000 * shapes.mass_of_all * 9.81 / h};
    Meetings meetings = find_meetings(scene, pairs);
    geometry::parallel_for(meetings.targets.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            if (meetings.regions[t].empty()) continue;
            fill_target(scene, meetings.regions[t], meetings.targets[t]);
        }
    });
    std::vector<std::vector<PointContact>> found(meetings.jobs.size());
    geometry::parallel_for(meetings.jobs.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j) {
            const Job& job = meetings.jobs[j];
            const Target& target = meetings.targets[job.target];
            look(scene, job, target, meetings.box[job.target], found[j]);
        }
    });
    std::vector<PointContact> all;
    for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
    return all;
}

}  // namespace physics
