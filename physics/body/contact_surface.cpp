#include "physics/body/contact_surface.hpp"

#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/body/contact_thickness.hpp"
#include "physics/body/surface_patches.hpp"

#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>

namespace physics {
namespace {

using geometry::Cubes;

// All that tells one patch from another.
std::string bytes_of(const LoosePatch& patch)
{
    std::string bytes;
    const auto add = [&](const float* from, Eigen::Index count) {
        bytes.append(reinterpret_cast<const char*>(from), std::size_t(count) * sizeof(float));
    };
    for (const auto* points : {&patch.points, &patch.within}) {
        for (const PatchPoint& point : *points) {
            add(point.place.data(), 3);
            add(point.weight.data(), 8);
            add(&point.area, 1);
        }
        bytes.push_back('|');
    }
    for (std::size_t i = 0; i < patch.areas.size(); ++i) {
        add(patch.areas[i].data(), 3);
        for (const Vec3f& side : patch.pieces[i]) add(side.data(), 3);
    }
    return bytes;
}

void add_patch(const LoosePatch& patch, ContactSurface& surface)
{
    SurfacePatch out;
    out.point = std::uint32_t(surface.point.size());
    out.area = std::uint32_t(surface.area.size());
    out.within = out.point + std::uint32_t(patch.points.size());
    for (const auto* points : {&patch.points, &patch.within}) {
        for (const PatchPoint& point : *points) {
            const float away = (point.place - Vec3f::Constant(0.5f)).norm();
            out.reach = std::max(out.reach, away / std::sqrt(0.75f));
            surface.point.push_back(point.weight);
            surface.point_area.push_back(point.area);
        }
    }
    std::array<double, 8> share{};
    double total = 0;
    for (std::size_t i = 0; i < patch.areas.size(); ++i) {
        const double size = patch.areas[i].cast<double>().norm();
        // The middles of a triangle's sides give the mean of anything of second degree.
        const auto& [corner, p, q] = patch.pieces[i];
        for (const Vec3f& middle : {Vec3f(p / 2), Vec3f(q / 2), Vec3f((p + q) / 2)}) {
            const Vec3 place = (corner + middle).cast<double>();
            const auto w = geometry::trilinear_weights(place.cwiseMax(0.0).cwiseMin(1.0));
            for (std::size_t a = 0; a < 8; ++a) share[a] += size / 3 * w[a];
        }
        total += size;
    }
    for (std::size_t a = 0; a < 8; ++a) {
        out.share[a] = static_cast<float>(total > 0 ? share[a] / total : 0.125);
    }
    surface.area.insert(surface.area.end(), patch.areas.begin(), patch.areas.end());
    surface.piece.insert(surface.piece.end(), patch.pieces.begin(), patch.pieces.end());
    out.points_end = std::uint32_t(surface.point.size());
    out.areas_end = std::uint32_t(surface.area.size());
    surface.patch.push_back(out);
}

// A model whose patches are packed, where its corners begin, and the slots of all corners.
struct Packed {
    const Cubes& cubes;
    std::uint32_t first_corner;
    const std::vector<std::uint32_t>& slot;  // empty: the corners themselves

    CornerRuns::Corners corners_of(std::size_t c) const
    {
        CornerRuns::Corners corners;
        for (std::size_t a = 0; a < 8; ++a) {
            const std::uint32_t k = first_corner + cubes.corners[c][a];
            corners[a] = slot.empty() ? k : slot[k];
        }
        return corners;
    }
};

// Of a body that is smaller than a cube, points would stand for hardly anything, and be stopped by
// as little: together they have at least a face of a cube.
void widen_areas(double size, std::vector<LoosePatch>& patches)
{
    double area = 0;
    for (const LoosePatch& patch : patches) {
        for (const PatchPoint& point : patch.points) area += double(point.area);
    }
    const double least = size * size;
    if (!(area > 0 && area < least)) return;
    for (LoosePatch& patch : patches) {
        for (PatchPoint& point : patch.points) {
            point.area = static_cast<float>(double(point.area) * (least / area));
        }
    }
}

// Patches that a surface holds already, and how many points come before.
struct KnownPatches {
    std::unordered_map<std::string, std::uint32_t> at;
    std::uint32_t points = 0;
};

// Adds a model's patches to the surface; takes them apart.
void pack(const Packed& model, std::vector<LoosePatch>& patches, KnownPatches& known,
          ContactSurface& out)
{
    const Cubes& cubes = model.cubes;
    const bool flat = geometry::flat_axis(cubes) >= 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        LoosePatch patch = std::exchange(patches[c], {});
        if (patch.points.empty() && patch.areas.empty() && patch.within.empty()) continue;
        out.corners.push_back(model.corners_of(c));
        out.stiffness.push_back(
            static_cast<float>(cubes.young[c] * std::clamp(cubes.fill[c], 0.05, 1.0)));
        out.mass.push_back(static_cast<float>(cubes.mass[c]));
        if (flat) {
            const double thickness = contact_thickness(cubes.fill[c] * cubes.size, cubes.size);
            const float half = static_cast<float>(0.5 * thickness);
            out.half_thickness.push_back(half);
            out.thickest = std::max(out.thickest, double(half));
        }
        // Vertices that no triangle uses (point clouds) share the faces of the cube.
        const auto spare = static_cast<float>(cubes.size * cubes.size) /
                           static_cast<float>(std::max<std::size_t>(1, patch.points.size()));
        for (PatchPoint& point : patch.points) {
            if (!(point.area > 0)) point.area = spare;
        }
        const auto [at, fresh] = known.at.emplace(bytes_of(patch), out.patch.size());
        if (fresh) add_patch(patch, out);
        out.patch_of.push_back(at->second);
        out.first_point.push_back(known.points);
        known.points += out.patch[at->second].points_end - out.patch[at->second].point;
    }
}

}  // namespace

void CornerRuns::push_back(const Corners& corners)
{
    if (runs_.empty() || runs_.back().at(size_) != corners) {
        runs_.push_back({static_cast<std::uint32_t>(size_), corners});
    }
    ++size_;
}

std::vector<CornerRuns::Run>::const_iterator CornerRuns::holder_of(std::size_t cube) const
{
    const auto next = std::upper_bound(runs_.begin(), runs_.end(), cube,
                                       [](std::size_t c, const Run& run) { return c < run.first; });
    return next - 1;
}

CornerRuns::Corners CornerRuns::operator[](std::size_t cube) const
{
    return holder_of(cube)->at(cube);
}

std::size_t ContactSurface::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    return corners.bytes() + of(patch_of, stiffness, mass, half_thickness, first_point, patch,
                                point, point_area, area, piece);
}

ContactSurface make_contact_surface(const BodyModels& models,
                                    const std::vector<std::uint32_t>& slot, bool tears)
{
    ContactSurface out;
    for (const double m : models.all().mass) out.body_mass += m;
    KnownPatches known;
    for (std::size_t m = 0; m < models.count(); ++m) {
        const BodyModel& model = models.model(m);
        auto patches = model.cubes->is_sheet() ? patches_of_sheet(*model.cubes)
                       : model.surface         ? patches_of_surface(*model.cubes, *model.surface)
                                               : patches_of_cubes(*model.cubes);
        widen_areas(model.cubes->size, patches);
        if (tears) add_corners_within(*model.cubes, patches);
        pack({*model.cubes, models.start(m).corner, slot}, patches, known, out);
    }
    out.patch_of.shrink_to_fit();
    out.stiffness.shrink_to_fit();
    out.mass.shrink_to_fit();
    out.half_thickness.shrink_to_fit();
    out.first_point.shrink_to_fit();
    return out;
}

ContactSurface make_contact_surface(const Cubes& cubes, const std::vector<std::uint32_t>& slot,
                                    const geometry::TriMesh* surface, bool tears)
{
    return make_contact_surface(BodyModels(cubes, surface), slot, tears);
}

}  // namespace physics
