#include "physics/body/solid_points.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/body/four_points.hpp"
#include "physics/body/sheet_contact.hpp"
#include "physics/body/sheet_edges.hpp"
#include "physics/body/solids_beside_sheets.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

// Map: boxes of what moves; which side a point is kept on; its plane; cubes of solids.

namespace physics {
namespace {

using geometry::Box3f;
using geometry::BoxTree;

constexpr std::size_t cubes_a_search = 32;

struct PointScene {
    const CornerBody& body;
    const SheetCells& cells;
    const SolidPointStep& step;
    Vec3 together;           // m, way of all sheets, which boxes leave out
    double stiffest;         // N/m
    std::vector<Box3f> box;  // C, of cells along their way, with the reach around them
    BoxTree tree;
};

void add_way(const PointScene& scene, const Vec3& from, const Vec3& to, Box3f& box)
{
    box.add(from.cast<float>());
    box.add(Vec3(to - scene.together).cast<float>());
}

Box3f widened(Box3f box, double by)
{
    const float far = std::max(box.lo.cwiseAbs().maxCoeff(), box.hi.cwiseAbs().maxCoeff());
    const auto margin = geometry::Vec3f::Constant(static_cast<float>(by) + 1e-6f * far);
    box.lo -= margin, box.hi += margin;
    return box;
}

PointScene point_scene(const CornerBody& body, const SolidPointStep& step)
{
    const SolidsBesideSheets& solids = *body.solids;
    PointScene out{
        body, *solids.cells, step, Vec3::Zero(), 1000 * body.skin.body_mass * 9.81 / body.h, {},
        {}};
    const auto sheet_corners = static_cast<double>(body.corners - solids.first_sheet);
    for (std::uint32_t k = solids.first_sheet; k < body.corners; ++k) {
        out.together += (corner_place(step.x1, k) - corner_place(step.x0, k)) / sheet_corners;
    }
    for (const auto& corners : out.cells.cell) {
        Box3f box;
        for (const auto k : corners)
            add_way(out, corner_place(step.x0, k), corner_place(step.x1, k), box);
        out.box.push_back(widened(box, out.cells.reach));
    }
    out.tree = fitted(out.cells.tree, out.box);
    return out;
}

// A point of a solid, at both ends of the step.
struct MovingPoint {
    PlaneTouch touch;  // its corners and number
    std::size_t cube = 0;
    double area = 0;  // m^2
    Vec3 from = Vec3::Zero(), to = Vec3::Zero();
};

// The deepest grip of a point on triangles of cells beside one.
const Grip* grip_beside(const PointScene& scene, std::uint32_t point, std::uint32_t triangle)
{
    const auto& grips = scene.step.held;
    const auto before = [](const Grip& grip, std::uint32_t p) { return grip.point < p; };
    const Grip* out = nullptr;
    for (auto grip = std::lower_bound(grips.begin(), grips.end(), point, before);
         grip != grips.end() && grip->point == point; ++grip) {
        if (grip->other < scene.step.first_other) continue;
        const std::uint32_t other = grip->other - scene.step.first_other;
        if (out && !(grip->depth > out->depth)) continue;
        if (are_beside(scene.body, scene.cells, other / 2, triangle / 2)) out = &*grip;
    }
    return out;
}

// On the side by which a point stands to a triangle; where it hardly does, on that of the solid.
Stand on_own_side(const PointScene& scene, const MovingPoint& point, const Stand& stand)
{
    constexpr double hardly = 0.25, little = 0.05;  // of the solid
    const PlaneTouch& touch = point.touch;
    const auto solid = scene.body.part_of(touch.corners[0]);
    const auto& tree = scene.step.solids[solid].tree;
    const double thinnest = scene.body.solids->solid[solid].thinnest;
    if (tree && std::abs(stand.distance) < hardly * thinnest) {
        Vec3 middle = Vec3::Zero();  // of its cube
        for (std::size_t a = 0; a < 8; ++a)
            middle += corner_place(scene.step.x1, touch.corners[a]) / 8;
        const Vec3 within = point.to + little * thinnest * (middle - point.to).normalized();
        const Vec3 way = 2 * little * thinnest * stand.normal;
        const bool before = tree->inside(within + way), behind = tree->inside(within - way);
        if (before != behind) return turned_to(stand, before ? way : Vec3(-way));
    }
    return turned_to(stand, stand.distance * stand.normal);
}

// How it stands to a triangle, with the normal out of the side that is to be kept.
std::optional<Stand> side_kept(const PointScene& scene, const MovingPoint& point,
                               std::uint32_t triangle)
{
    const auto& k = scene.cells.triangle[triangle];
    FourPoints a{point.from}, b{point.to};
    for (std::size_t i = 0; i < 3; ++i) {
        a[i + 1] = corner_place(scene.step.x0, k[i]);
        b[i + 1] = corner_place(scene.step.x1, k[i]);
    }
    const std::uint32_t p = point.touch.point, other = scene.step.first_other + triangle;
    return side_to_keep(
        Four::point, a, b, scene.cells.reach, find_grip(scene.step.held, p, other),
        [&] { return grip_beside(scene, p, triangle); },
        [&](const Stand& stand) { return on_own_side(scene, point, stand); });
}

void meet_triangle_of(const PointScene& scene, const MovingPoint& point, std::uint32_t triangle,
                      std::vector<PlaneTouch>& out)
{
    const auto stand = side_kept(scene, point, triangle);
    if (!stand || stand->distance > scene.cells.reach) return;
    const CornerBody& body = scene.body;
    const auto& k = scene.cells.triangle[triangle];
    PlaneTouch touch = point.touch;
    touch.count = 12;
    std::fill(touch.corners.begin() + 8, touch.corners.end(), k[0]);
    double half = 0, way = stand->normal.dot(point.from - point.to);
    for (std::size_t i = 0; i < 3; ++i) {
        const double w = stand->weight[i + 1];  // below 0
        touch.corners[8 + i] = k[i];
        touch.weight[8 + i] = static_cast<float>(w);
        half -= 0.5 * w * double(scene.cells.thickness[k[i]]);
        way -= w * stand->normal.dot(corner_place(scene.step.x1, k[i]) -
                                     corner_place(scene.step.x0, k[i]));
    }
    const ContactSurface& skin = body.skin;
    const double h = body.edge_at(touch.corners[0]);
    const double young = std::min(double(skin.stiffness[point.cube]), body.solids->sheet_stiffness);
    const double least = std::min(10 * young * point.area / h, scene.stiffest);
    const double mass = double(skin.mass[point.cube]) * std::min(1.0, point.area / (h * h));
    touch.stiffness = stopping(least, mass, way, scene.step.dt, h);
    touch.at_rest = stopping(least, mass, 0, scene.step.dt, h);
    if (!(touch.stiffness > 0)) return;
    touch.other = scene.step.first_other + triangle;
    touch.normal = stand->normal;
    touch.offset = -half;
    touch.size = h;
    touch.friction = body.solids->friction, touch.bounce = body.solids->bounce;
    out.push_back(touch);
}

MovingPoint moving_point(const PointScene& scene, const CornerRuns::Corners& corners,
                         std::size_t cube, std::uint32_t i)
{
    const ContactSurface& skin = scene.body.skin;
    MovingPoint out;
    std::copy(corners.begin(), corners.end(), out.touch.corners.begin());
    out.touch.point = skin.first_point[cube] + (i - skin.on(cube).point);
    out.cube = cube;
    out.area = double(skin.point_area[i]);
    for (std::size_t a = 0; a < 8; ++a) {
        const auto weight = double(skin.point[i][a]);
        out.touch.weight[a] = skin.point[i][a];
        out.from += weight * corner_place(scene.step.x0, corners[a]);
        out.to += weight * corner_place(scene.step.x1, corners[a]);
    }
    return out;
}

// What the points of one cube meet.
void meet_cube(const PointScene& scene, const CornerRuns::Corners& corners, std::size_t cube,
               std::vector<PlaneTouch>& out)
{
    if (!scene.step.solids[scene.body.part_of(corners[0])].tree) return;  // far from all sheets
    const SurfacePatch& patch = scene.body.skin.on(cube);
    std::vector<MovingPoint> points;
    Box3f all;
    for (auto i = patch.point; i < patch.points_end; ++i) {
        points.push_back(moving_point(scene, corners, cube, i));
        add_way(scene, points.back().from, points.back().to, all);
    }
    if (points.empty()) return;
    std::vector<std::uint32_t> near;
    scene.tree.overlapping(widened(all, 0), [&](std::uint32_t c) { near.push_back(c); });
    if (near.empty()) return;
    std::sort(near.begin(), near.end());
    for (const MovingPoint& point : points) {
        Box3f own;
        add_way(scene, point.from, point.to, own);
        own = widened(own, 0);
        for (const auto c : near) {
            if (!own.overlaps(scene.box[c])) continue;
            for (const auto t : {2 * c, 2 * c + 1}) {
                const auto& k = scene.cells.triangle[t];
                if (k[1] != k[2]) meet_triangle_of(scene, point, t, out);
            }
        }
    }
}

}  // namespace

std::vector<PlaneTouch> find_solid_points(const CornerBody& body, const SolidPointStep& step)
{
    const auto is_near = [](const PosedCollider& solid) { return solid.tree != nullptr; };
    if (std::none_of(step.solids.begin(), step.solids.end(), is_near)) return {};
    const PointScene scene = point_scene(body, step);
    const std::size_t cubes = body.solids->first_sheet_cell;
    std::vector<std::vector<PlaneTouch>> found((cubes + cubes_a_search - 1) / cubes_a_search);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            geometry::stop_if_asked();
            body.skin.corners.for_each(g * cubes_a_search,
                                       std::min(cubes, (g + 1) * cubes_a_search),
                                       [&](std::size_t c, const auto& corners) {
                                           meet_cube(scene, corners, c, found[g]);
                                       });
        }
    });
    return put_in_order(found);
}

}  // namespace physics
