#include "physics/body/solids_beside_sheets.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "geometry/mesh/measure.hpp"
#include "physics/body/make_part_shapes.hpp"
#include "physics/body/outer_faces.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace physics {
namespace {

using geometry::Box3f;
using geometry::Cubes;
using geometry::TriMesh;
using geometry::Vec3f;
using geometry::Vec3i;

struct InCell {
    std::uint32_t cube = 0;
    Vec3 local = Vec3::Zero();
};

// The nearest cube of a part to a place at rest (m), and the place in it.
InCell cell_at(const SolidsBesideSheets& solids, const SolidShape& shape, const Vec3& at_rest)
{
    const Vec3 at = (at_rest - shape.grid.origin) / shape.grid.size;
    double best_sq = std::numeric_limits<double>::infinity();
    std::uint32_t best = shape.cubes.front();
    shape.tree.nearest(at, best_sq, [&](std::uint32_t i, double& sq) {
        const Vec3 low = solids.cell[shape.cubes[i]].cast<double>();
        const Vec3 away = (low - at).cwiseMax(at - low - Vec3::Ones()).cwiseMax(0.0);
        if (away.squaredNorm() < sq) sq = away.squaredNorm(), best = shape.cubes[i];
    });
    return {best, at - solids.cell[best].cast<double>()};
}

// The faces of a closed shape that lead out, and look there: those of a mesh may all face inward.
TriMesh outside_faces(TriMesh mesh, double size)
{
    if (geometry::enclosed_volume(mesh) < 0) {
        geometry::MeshTopology turned;
        for (geometry::Triangle t : mesh.triangles()) {
            std::swap(t[1], t[2]);
            turned.triangles.push_back(t);
        }
        mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(turned));
    }
    if (auto outer = outer_faces(mesh, geometry::TriangleBvh(mesh), size)) return std::move(*outer);
    return mesh;
}

SolidShape shape_of(const SolidsBesideSheets& solids, TriMesh mesh, const PartGrid& grid,
                    std::vector<std::uint32_t> cubes)
{
    SolidShape out;
    out.mesh = outside_faces(std::move(mesh), grid.size);
    out.grid = grid;
    out.cubes = std::move(cubes);
    std::vector<Box3f> boxes;
    for (const auto c : out.cubes) {
        const Vec3f low = solids.cell[c].cast<float>();
        boxes.push_back({low, low + Vec3f::Ones()});
    }
    out.tree = geometry::build_box_tree(boxes);
    out.thinnest = geometry::bounds(out.mesh).size().minCoeff();
    const std::size_t vertices = out.mesh.positions.size();
    out.cube.resize(vertices);
    out.local.resize(vertices);
    geometry::parallel_for(vertices, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const InCell in = cell_at(solids, out, out.mesh.positions[v].cast<double>());
            out.cube[v] = in.cube, out.local[v] = in.local;
        }
    });
    return out;
}

}  // namespace

std::size_t SolidsBesideSheets::bytes() const
{
    std::size_t sum =
        sizeof *this + corners.size() * sizeof(corners[0]) + cell.size() * sizeof(cell[0]);
    for (const SolidShape& shape : solid) {
        const std::size_t a_vertex = sizeof(Vec3f) + sizeof(std::uint32_t) + sizeof(Vec3);
        sum += shape.mesh.positions.size() * a_vertex +
               shape.mesh.triangles().size() * sizeof(geometry::Triangle) +
               shape.cubes.size() * (sizeof(std::uint32_t) + sizeof(Box3f));
    }
    return sum;
}

CarriedPlace carried_place(const SolidsBesideSheets& solids, std::size_t solid, const Vec3& at_rest)
{
    const InCell in = cell_at(solids, solids.solid[solid], at_rest);
    return {solids.corners[in.cube], geometry::trilinear_weights(in.local)};
}

double softer_of(const CornerBody& body, std::size_t colliders, std::uint32_t other, double own)
{
    if (!body.solids) return own;
    const std::size_t first = colliders - body.solids->solid.size();
    return other < first ? own : std::min(own, body.solids->solid[other - first].stiffness);
}

SolidsBesideSheets make_solids_beside_sheets(const BodyModels& models, const CornerBody& body,
                                             const PartContactOptions& options)
{
    const Cubes& cubes = models.all();
    SolidsBesideSheets out;
    out.friction = options.friction, out.bounce = options.bounce;
    out.first_sheet = static_cast<std::uint32_t>(body.corners);
    out.first_sheet_cell = static_cast<std::uint32_t>(body.skin.corners.size());
    std::vector<std::uint32_t> part_of;
    for (const auto& eight : cubes.corners) {
        auto& corners = out.corners.emplace_back();
        for (std::size_t a = 0; a < 8; ++a) {
            corners[a] = static_cast<std::uint32_t>(body.slot_of(eight[a]));
        }
        part_of.push_back(body.part_of(corners[0]));
    }
    std::vector<PartGrid> grid(body.parts);
    for (std::size_t m = 0; m < models.count(); ++m) {
        const Cubes& own = *models.model(m).cubes;
        out.cell.insert(out.cell.end(), own.cell.begin(), own.cell.end());
        for (std::size_t c = 0; c < own.count(); ++c) {
            grid[part_of[models.start(m).cube + c]] = {own.size, own.origin};
        }
    }
    const PartLists cubes_of = make_part_lists(part_of, body.parts);
    for_closed_shapes(models, body, [&](std::uint32_t part, TriMesh mesh) {
        const auto its_own = cubes_of[part];
        out.solid.push_back(
            shape_of(out, std::move(mesh), grid[part], {its_own.begin(), its_own.end()}));
        double& stiffness = out.solid.back().stiffness;
        for (const auto c : its_own) {
            const double fill = std::clamp(cubes.fill[c], 0.05, 1.0);
            stiffness = std::max(stiffness, cubes.young[c] * fill);
        }
    });
    return out;
}

}  // namespace physics
