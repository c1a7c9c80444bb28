#include "physics/body/overlaps.hpp"

#include "geometry/mesh/triangle_bvh.hpp"
#include "physics/body/sheet_crossings.hpp"
#include "physics/body/solids_beside_sheets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace physics {
namespace {

// The model that each part is of.
std::vector<std::size_t> models_of_parts(ModelsOfState models, const CornerBody& body)
{
    std::vector<std::size_t> out(body.parts, 0);
    std::size_t corner = 0;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const std::size_t end = corner + models[m]->corner_count();
        for (; corner < end; ++corner) out[body.part_of(body.slot_of(corner))] = m;
    }
    return out;
}

// Pairs of two models: how many, and where one of them is.
struct Overlap {
    std::size_t pairs = 0;
    Vec3 place = Vec3::Zero();  // m
};

std::string named(const Vec3& place)
{
    return fmt::format("({:.3g}, {:.3g}, {:.3g})", place.x(), place.y(), place.z());
}

std::string told(const SheetCrossing& crossing, std::size_t of)
{
    const auto [a, b] = crossing.models;
    const std::string place = named(crossing.place);
    if (a != b) {
        return fmt::format("Sheets {} and {} cross each other at rest near {}, and contact keeps "
                           "them crossed. Move them apart.",
                           a + 1, b + 1, place);
    }
    return fmt::format("{} crosses itself at rest near {}, and contact keeps it crossed. Mend the "
                       "mesh.",
                       of == 1 ? "The sheet" : fmt::format("Sheet {}", a + 1), place);
}

std::string told(std::pair<std::size_t, std::size_t> models, std::size_t of, const Overlap& overlap)
{
    const std::string place = named(overlap.place);
    if (models.first != models.second) {
        return fmt::format(
            "Bodies {} and {} overlap at rest near {}, so they pass through each "
            "other. Move them apart, or join them by Joint. Where a surface is open, "
            "whole cubes count.",
            models.first + 1, models.second + 1, place);
    }
    return fmt::format(
        "{} has {} of parts that overlap at rest, one near {}: these parts pass "
        "through each other. Move them apart in the mesh, or join them by Joint. Where "
        "a surface is open, whole cubes count.",
        of == 1 ? "The body" : fmt::format("Body {}", models.first + 1),
        overlap.pairs == 1 ? "a pair" : fmt::format("{} pairs", overlap.pairs), place);
}

// Sheets whose corners lie in a solid at rest.
void add_sheets_in_solids(const std::vector<std::size_t>& model, const CornerBody& body,
                          std::vector<std::string>& out)
{
    if (!body.solids) return;
    const auto place = [&](std::size_t slot) {
        return Vec3(Eigen::Map<const Vec3>(body.rest.data() + 4 * slot));
    };
    std::map<std::pair<std::size_t, std::size_t>, Vec3> found;
    for (const SolidShape& solid : body.solids->solid) {
        const geometry::TriangleBvh tree(solid.mesh);
        const geometry::Box bounds = geometry::bounds(solid.mesh);
        const auto part = body.part_of(body.solids->corners[solid.cubes[0]][0]);
        for (std::size_t slot = body.solids->first_sheet; slot < body.corners; ++slot) {
            const Vec3 p = place(slot);
            if ((p.array() < bounds.lo.array()).any() || (p.array() > bounds.hi.array()).any()) {
                continue;
            }
            if (tree.inside(p)) found.emplace(std::pair{model[part], model[body.part_of(slot)]}, p);
        }
    }
    for (const auto& [two, at] : found) {
        out.push_back(
            fmt::format("The sheet of cubes[{}] starts inside the solid of cubes[{}] near "
                        "{}: contact pushes it out, or holds it there where it "
                        "goes through the middle. Move them apart.",
                        two.second, two.first, named(at)));
    }
}

bool are_joined(const CornerBody& body, std::span<const JointPoint> joints, PartPair pair)
{
    return std::any_of(joints.begin(), joints.end(), [&](const JointPoint& joint) {
        const auto a = body.part_of(body.slot_of(joint.corner[0]));
        const auto b = body.part_of(body.slot_of(joint.corner[8]));
        return std::minmax(a, b) == std::minmax(pair.a, pair.b);
    });
}

}  // namespace

std::vector<std::string> told_of_overlaps(ModelsOfState models, const CornerBody& body,
                                          std::span<const JointPoint> joints)
{
    std::vector<std::string> out;
    for (const SheetCrossing& c : sheet_crossings(body)) out.push_back(told(c, models.size()));
    const std::vector<std::size_t> model = models_of_parts(models, body);
    add_sheets_in_solids(model, body, out);
    if (!body.shapes || body.shapes->overlapping.empty()) return out;
    std::map<std::pair<std::size_t, std::size_t>, Overlap> all;
    for (std::size_t i = 0; i < body.shapes->overlapping.size(); ++i) {
        const PartPair pair = body.shapes->overlapping[i];
        if (are_joined(body, joints, pair)) continue;
        Overlap& overlap = all[std::minmax(model[pair.a], model[pair.b])];
        if (overlap.pairs++ == 0) overlap.place = body.shapes->overlap_at[i];
    }
    for (const auto& [two, overlap] : all) out.push_back(told(two, models.size(), overlap));
    return out;
}

}  // namespace physics
