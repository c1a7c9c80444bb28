#include "physics/body/join_bodies.hpp"

#include <algorithm>

// Map: what is by corner or by part; surfaces; cells of sheets.

namespace physics {
namespace {

template <class T> void append(std::vector<T>& to, const std::vector<T>& from)
{
    to.insert(to.end(), from.begin(), from.end());
}

// `all` with `count` more numbers: `from`, or `usual` where that is empty.
template <class T>
void append_or(std::vector<T>& all, const std::vector<T>& from, std::size_t count, const T& usual)
{
    if (from.empty()) {
        all.insert(all.end(), count, usual);
    } else {
        append(all, from);
    }
}

// Of two lists that may be empty for `usual` throughout.
template <class T>
std::vector<T> both(const std::vector<T>& a, std::size_t count_a, const std::vector<T>& b,
                    std::size_t count_b, const T& usual)
{
    std::vector<T> out;
    if (a.empty() && b.empty()) return out;
    append_or(out, a, count_a, usual);
    append_or(out, b, count_b, usual);
    return out;
}

std::vector<std::uint32_t> slots_of(const CornerBody& solids, const CornerBody& sheets,
                                    std::span<const JoinedModel> models)
{
    std::vector<std::uint32_t> out;
    std::size_t solid = 0, sheet = 0;
    for (const JoinedModel& model : models) {
        for (std::size_t k = 0; k < model.corners; ++k) {
            const std::size_t slot =
                model.sheet ? solids.corners + sheets.slot_of(sheet++) : solids.slot_of(solid++);
            out.push_back(static_cast<std::uint32_t>(slot));
        }
    }
    return out;
}

// Points of the surface, over all of its cubes.
std::uint32_t points_of(const ContactSurface& surface)
{
    const std::size_t cubes = surface.corners.size();
    if (cubes == 0) return 0;
    const SurfacePatch& last = surface.on(cubes - 1);
    return surface.first_point[cubes - 1] + last.points_end - last.point;
}

ContactSurface join_surfaces(const ContactSurface& solids, const ContactSurface& sheets,
                             std::uint32_t first_slot)
{
    ContactSurface out = solids;
    const std::uint32_t points = points_of(solids);
    const auto patches = static_cast<std::uint32_t>(solids.patch.size());
    const auto patch_points = static_cast<std::uint32_t>(solids.point.size());
    const auto areas = static_cast<std::uint32_t>(solids.area.size());
    out.body_mass += sheets.body_mass;
    sheets.corners.for_each(0, sheets.corners.size(), [&](std::size_t, auto corners) {
        for (auto& k : corners) k += first_slot;
        out.corners.push_back(corners);
    });
    for (const auto patch : sheets.patch_of) out.patch_of.push_back(patches + patch);
    append(out.stiffness, sheets.stiffness);
    append(out.mass, sheets.mass);
    out.half_thickness.assign(solids.patch_of.size(), 0);
    append(out.half_thickness, sheets.half_thickness);
    out.thickest = sheets.thickest;
    for (const auto first : sheets.first_point) out.first_point.push_back(points + first);
    for (SurfacePatch patch : sheets.patch) {
        patch.point += patch_points, patch.points_end += patch_points;
        patch.within += patch_points;
        patch.area += areas, patch.areas_end += areas;
        out.patch.push_back(patch);
    }
    append(out.point, sheets.point);
    append(out.point_area, sheets.point_area);
    append(out.area, sheets.area);
    append(out.piece, sheets.piece);
    return out;
}

std::shared_ptr<const SheetCells> move_cells(const SheetCells& cells, std::uint32_t first_slot,
                                             std::uint32_t first_number,
                                             std::span<const JoinedModel> models)
{
    auto out = std::make_shared<SheetCells>(cells);
    out->first_number = first_number;
    const auto move = [&](auto& lists) {
        for (auto& corners : lists) {
            for (auto& k : corners) k += first_slot;
        }
    };
    move(out->cell), move(out->triangle), move(out->edge);
    for (auto& k : out->point) k += first_slot;
    out->thickness.insert(out->thickness.begin(), first_slot, 0.0f);
    out->stiffness.insert(out->stiffness.begin(), first_slot, 0.0f);
    std::vector<std::uint32_t> number;  // among all models, of each sheet
    for (std::uint32_t m = 0; m < models.size(); ++m) {
        if (models[m].sheet) number.push_back(m);
    }
    for (auto& m : out->model) m = number[m];
    return out;
}

}  // namespace

CornerBody join_bodies(const CornerBody& solids, const CornerBody& sheets,
                       std::span<const JoinedModel> models,
                       std::unique_ptr<SolidsBesideSheets> touching)
{
    const auto first_slot = static_cast<std::uint32_t>(solids.corners);
    CornerBody out;
    out.h = std::min(solids.h, sheets.h);
    out.greatest_edge = std::max(solids.greatest_edge, sheets.greatest_edge);
    out.models = models.size();
    out.corners = solids.corners + sheets.corners;
    out.numbers = padded_numbers(out.corners);
    out.slot = slots_of(solids, sheets, models);
    out.mass = both(solids.mass, solids.corners, sheets.mass, sheets.corners, 0.0);
    out.mass_damping =
        both(solids.mass_damping, solids.corners, sheets.mass_damping, sheets.corners, 0.0);
    out.parts = solids.parts + sheets.parts;
    append_or(out.part, solids.part, solids.corners, 0u);
    append_or(out.part, sheets.part, sheets.corners, 0u);
    for (std::size_t k = first_slot; k < out.corners; ++k) {
        out.part[k] += static_cast<std::uint32_t>(solids.parts);
    }
    if (!solids.rigid.empty()) {
        out.rigid = solids.rigid;
        out.rigid.resize(out.parts, 0);
    }
    append_or(out.part_edge, solids.part_edge, solids.parts, solids.h);
    append_or(out.part_edge, sheets.part_edge, sheets.parts, sheets.h);
    out.on_lattice = solids.on_lattice && sheets.on_lattice;
    out.rest.assign(out.numbers, 0);
    std::copy_n(solids.rest.begin(), 4 * solids.corners, out.rest.begin());
    std::copy_n(sheets.rest.begin(), 4 * sheets.corners, out.rest.begin() + 4 * first_slot);
    out.skin = join_surfaces(solids.skin, sheets.skin, first_slot);
    out.shapes = solids.shapes;
    out.outlines = solids.outlines;
    const std::size_t numbers = solids.shapes ? solids.shapes->point.size() : 0;
    if (sheets.sheets) {
        out.sheets =
            move_cells(*sheets.sheets, first_slot, static_cast<std::uint32_t>(numbers), models);
    }
    if (!touching) return out;
    touching->cells = move_cells(*touching->cells, first_slot, 0, models);
    for (std::size_t c = touching->first_sheet_cell; c < out.skin.corners.size(); ++c) {
        touching->sheet_stiffness =
            std::max(touching->sheet_stiffness, double(out.skin.stiffness[c]));
    }
    out.solids = std::move(touching);
    return out;
}

}  // namespace physics
