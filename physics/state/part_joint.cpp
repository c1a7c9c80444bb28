#include "physics/state/part_joint.hpp"

#include "geometry/base/union_find.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/state/glue.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace physics {
namespace {

using geometry::Cubes;

using Models = std::span<const std::shared_ptr<const Cubes>>;

// A part of a model, and its cube that is nearest to the joint.
struct Part {
    const Cubes* cubes = nullptr;
    std::vector<std::uint32_t> cube;  // of the model, its own
    double distance = 0;              // m, 0 inside
    double to_centre = 0;             // m
};

Vec3 place_in(const Cubes& cubes, std::uint32_t c, const Vec3& p)
{
    return (p - cubes.origin) / cubes.size - cubes.cell[c].cast<double>();
}

// m, from the box of a cube and from its centre.
double distance_to(const Cubes& cubes, std::uint32_t c, const Vec3& p)
{
    const Vec3 u = place_in(cubes, c, p);
    return cubes.size * (u - u.cwiseMax(0).cwiseMin(1)).norm();
}
double distance_to_centre(const Cubes& cubes, std::uint32_t c, const Vec3& p)
{
    return cubes.size * (place_in(cubes, c, p) - Vec3::Constant(0.5)).norm();
}

// Of a part, the one whose box is nearest; of those that hold the place, by its centre.
std::uint32_t nearest_of(const Part& part, const Vec3& p)
{
    const auto key = [&](std::uint32_t c) {
        return std::pair{distance_to(*part.cubes, c, p), distance_to_centre(*part.cubes, c, p)};
    };
    return *std::min_element(part.cube.begin(), part.cube.end(),
                             [&](auto a, auto b) { return key(a) < key(b); });
}

// By distance from p.
std::vector<Part> parts_of(const Cubes& cubes, const Vec3& p)
{
    geometry::UnionFind sets(cubes.corner_count());
    for (const auto& corners : cubes.corners) {
        for (const auto k : corners) sets.join(k, corners[0]);
    }
    std::map<std::uint32_t, Part> by_root;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        Part& part = by_root[sets.root(cubes.corners[c][0])];
        part.cubes = &cubes;
        part.cube.push_back(c);
    }
    std::vector<Part> out;
    for (auto& [root, part] : by_root) {
        const std::uint32_t nearest = nearest_of(part, p);
        part.distance = distance_to(cubes, nearest, p);
        part.to_centre = distance_to_centre(cubes, nearest, p);
        out.push_back(std::move(part));
    }
    std::stable_sort(out.begin(), out.end(), [](const Part& a, const Part& b) {
        return std::pair{a.distance, a.to_centre} < std::pair{b.distance, b.to_centre};
    });
    return out;
}

std::string named(const Vec3& p)
{
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z());
}

void check(Models models, const PartJointSettings& settings)
{
    if (models.empty() || models.size() > 2) {
        throw std::invalid_argument(fmt::format(
            "a joint takes one or two links at `cubes`, found {}: link the model that has both "
            "parts, or the two models",
            models.size()));
    }
    if (!settings.position.allFinite()) {
        throw std::invalid_argument("the position of the joint is not finite");
    }
    if (settings.kind == PartJointKind::hinge &&
        !(settings.axis.allFinite() && settings.axis.norm() > 0)) {
        throw std::invalid_argument("the axis of a hinge has no direction: expected one that is "
                                    "not (0, 0, 0), as (0, 1, 0) for a door");
    }
    for (const auto& cubes : models) {
        if (cubes->is_sheet()) {
            throw std::invalid_argument(
                "a joint joins cubes of Voxelize, found a sheet: take Pin with `follow` for it, "
                "whose mesh moves by another Simulate or by keyframes");
        }
        if (cubes->count() == 0) {
            throw std::invalid_argument("expected at least one cube, found none");
        }
    }
}

void require_reach(const Part& part, const PartJointSettings& settings, const std::string& name)
{
    const double reach = settings.reach > 0 ? settings.reach : part.cubes->size;
    if (part.distance <= reach) return;
    throw std::invalid_argument(fmt::format(
        "{} is {:.3g} m from {}, and reach is {:.3g} m: move position to where the parts meet, or "
        "raise reach",
        name, part.distance, named(settings.position), reach));
}

std::array<Part, 2> two_parts(Models models, const PartJointSettings& settings, std::size_t& others)
{
    std::array<Part, 2> out;
    const auto holds = [](const Part& part) { return part.distance == 0; };
    if (models.size() == 2) {
        for (std::size_t i = 0; i < 2; ++i) {
            auto parts = parts_of(*models[i], settings.position);
            others += std::size_t(std::count_if(parts.begin() + 1, parts.end(), holds));
            out[i] = std::move(parts[0]);
            require_reach(out[i], settings, fmt::format("link {} of `cubes`", i + 1));
        }
    } else {
        auto parts = parts_of(*models[0], settings.position);
        if (parts.size() < 2) {
            throw std::invalid_argument(
                "the cubes are one part, which a joint cannot join to itself: link a second model, "
                "or voxelize pieces of the mesh with pieces = each, groups or apart");
        }
        others = std::size_t(std::count_if(parts.begin() + 2, parts.end(), holds));
        out = {std::move(parts[0]), std::move(parts[1])};
        require_reach(out[1], settings, "the second part of `cubes`");
    }
    return out;
}

std::vector<Vec3> places(const PartJointSettings& settings, double size)
{
    const Vec3& p = settings.position;
    if (settings.kind == PartJointKind::ball) return {p};
    if (settings.kind == PartJointKind::hinge) {
        const Vec3 half = 0.5 * size * settings.axis.normalized();
        return {p - half, p + half};
    }
    std::vector<Vec3> out;  // corners of two tetrahedra, a cube's
    for (unsigned a = 0; a < 8; ++a) {
        out.push_back(p + 0.5 / std::sqrt(3.0) * size *
                              Vec3(a & 1 ? 1 : -1, a & 2 ? 1 : -1, a & 4 ? 1 : -1));
    }
    return out;
}

// Edges of a part's cubes that p is farther from it than the position is.
double farther_out(const Part& part, const Vec3& p)
{
    return (distance_to(*part.cubes, nearest_of(part, p), p) - part.distance) / part.cubes->size;
}

JointPoint point_at(const std::array<Part, 2>& parts, const Vec3& p)
{
    JointPoint out;
    for (std::size_t side = 0; side < 2; ++side) {
        const Cubes& cubes = *parts[side].cubes;
        const std::uint32_t c = nearest_of(parts[side], p);
        const auto weight = geometry::trilinear_weights(place_in(cubes, c, p));
        for (std::size_t a = 0; a < 8; ++a) {
            out.corner[8 * side + a] = cubes.corners[c][a];
            out.weight[8 * side + a] = side == 0 ? weight[a] : -weight[a];
        }
        out.stiffness[side] = cubes.young[c] * cubes.size;
    }
    return out;
}

}  // namespace

PartJoint make_joint(Models cubes, const PartJointSettings& settings, JointDoubts* doubts)
{
    check(cubes, settings);
    JointDoubts found;
    if (settings.kind == PartJointKind::glue) {
        Glued glued;
        PartJoint out = make_glue(cubes, settings.reach, &glued);
        found.loose = glued.loose, found.parts = glued.parts;
        if (doubts) *doubts = found;
        return out;
    }
    const auto parts = two_parts(cubes, settings, found.others);
    constexpr double usual = 4;  // edges; of larger cubes, points would lie far outside a thin part
    const double edge = std::min(parts[0].cubes->size, parts[1].cubes->size);
    PartJoint out;
    out.position = settings.position;
    out.cubes = {mark_of(*parts[0].cubes), mark_of(*parts[1].cubes)};
    for (const Vec3& p : places(settings, settings.size > 0 ? settings.size : usual * edge)) {
        out.points.push_back(point_at(parts, p));
        for (std::size_t side = 0; side < 2; ++side) {
            found.outside[side] = std::max(found.outside[side], farther_out(parts[side], p));
        }
    }
    if (doubts) *doubts = found;
    return out;
}

std::vector<JointPoint> points_of_all(const PartJoint& joint, Models cubes,
                                      const std::vector<StateModel>& models)
{
    std::array<std::uint32_t, 2> first{};
    for (std::size_t side = 0; side < 2; ++side) {
        const auto found = std::find_if(models.begin(), models.end(), [&](const StateModel& model) {
            return model.mark == joint.cubes[side];
        });
        if (found != models.end()) {
            first[side] = found->corner;
        } else if (!models.empty() || mark_of(*cubes.front()) != joint.cubes[side]) {
            throw std::invalid_argument(
                "a joint is of other cubes than those that are simulated: link input `cubes` of "
                "Joint to the nodes that Simulate takes its cubes from");
        }
    }
    std::vector<JointPoint> out = joint.points;
    for (JointPoint& point : out) {
        for (std::size_t i = 0; i < 16; ++i) point.corner[i] += first[i / 8];
    }
    return out;
}

}  // namespace physics
