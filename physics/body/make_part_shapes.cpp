#include "physics/body/make_part_shapes.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/embed/bind.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/winding_walk.hpp"
#include "physics/body/closed_shape.hpp"
#include "physics/body/flat_faces.hpp"
#include "physics/body/halved_triangle.hpp"
#include "physics/body/mesh_of_some.hpp"
#include "physics/body/outer_faces.hpp"
#include "physics/body/part_contact.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::no_index;
using geometry::Triangle;
using geometry::TriMesh;
using geometry::Vec3;

// One of the models of a body, and the parts of the body's cubes.
struct ShapedModel {
    const Cubes& cubes;
    const TriMesh* surface;
    std::uint32_t first_cube;
    std::span<const std::uint32_t> part_of;  // of each of its cubes
    std::size_t parts;                       // of the body
};

// The triangles of each part: those whose first vertex is carried by one of its cubes.
PartLists triangles_of_parts(const ShapedModel& model)
{
    const TriMesh& surface = *model.surface;
    const geometry::Binding binding = geometry::bind(surface, model.cubes);
    std::vector<std::uint32_t> part_of;
    part_of.reserve(surface.triangles().size());
    for (const Triangle& t : surface.triangles()) {
        const bool sound = std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
            return v < surface.positions.size() && surface.positions[v].allFinite();
        });
        // One more list holds those that are of no use.
        part_of.push_back(sound ? model.part_of[binding.used[binding.cube[t[0]]]]
                                : static_cast<std::uint32_t>(model.parts));
    }
    return make_part_lists(part_of, model.parts + 1);
}

// A point before it is known which cube holds it.
struct LoosePoint {
    Vec3 place, normal;
    double area;
};

// How dense the points of a part are, by the second of its three widths: two bodies a cube wide
// that lie across each other touch between their corners alone, where rims cross.
struct Density {
    double longest;  // m, side of a triangle that is not cut
    int crowds;      // along a cube: of each, points are taken together

    Density(const TriMesh& mesh, double cube)
    {
        constexpr double of_cube = 1.5, of_width = 0.52;  // an edge is cut in two, and corners stay
        geometry::Box box;
        for (const auto& p : mesh.positions) box.add(p.cast<double>());
        Vec3 width = box.empty() ? Vec3::Constant(cube) : Vec3(box.hi - box.lo);
        std::sort(width.begin(), width.end());
        const double cubes = width[1] / (0.99 * cube);  // below 1 only by more than rounding
        crowds = cubes < 0.5 ? most_crowds : cubes < 1 ? 8 : 4;
        longest = std::clamp(of_width * width[1], of_cube / crowds * cube, of_cube * cube);
    }
    static constexpr int most_crowds = 16;
};

// Points near the corners of the triangle, cut in two along its longest side until that is no
// longer than `longest`.
void add_points(const std::array<Vec3, 3>& t, double longest, std::vector<LoosePoint>& out)
{
    // Near the corners, and inside: what rests rim on rim still has its points over the other.
    constexpr double near = 0.9, far = 0.05;
    const HalvedTriangle halved(t);
    if (halved.longest > longest) {
        add_points(halved.first, longest, out);
        add_points(halved.second, longest, out);
        return;
    }
    const Vec3 &p = halved.first[0], &q = halved.second[1], &r = halved.first[2];
    const Vec3 area = (q - p).cross(r - p) / 2;
    const double size = area.norm();
    if (!(size > 0)) return;
    for (std::size_t i = 0; i < 3; ++i) {
        out.push_back(
            {near * t[i] + far * (t[(i + 1) % 3] + t[(i + 2) % 3]), area / size, size / 3});
    }
}

using Corners = std::array<Vec3, 3>;

Corners corners_of(const TriMesh& mesh, const Triangle& t)
{
    return {mesh.positions[t[0]].cast<double>(), mesh.positions[t[1]].cast<double>(),
            mesh.positions[t[2]].cast<double>()};
}

bool is_near_rim(const Vec3& p, const Corners& t, const Rims& rims, double near)
{
    for (std::size_t i = 0; i < 3; ++i) {
        if (rims.corner[i] && (p - t[i]).norm() <= near) return true;
        if (!rims.side[i]) continue;
        const Vec3 side = t[(i + 1) % 3] - t[i];
        const double along = std::clamp((p - t[i]).dot(side) / side.squaredNorm(), 0.0, 1.0);
        if ((p - t[i] - along * side).norm() <= near) return true;
    }
    return false;
}

// Flat faces of bodies that keep their shape meet where the rim of one lies on the other, or where
// rims cross: points within them would touch nothing first. A face of 0.16 by 0.24 m in cubes of
// 0.02 m has a tenth of the points.
void add_points_on_rims(const TriMesh& mesh, double longest, std::vector<LoosePoint>& out)
{
    constexpr double flat = 1e-3, near = 0.12;  // of the longest side; points lie 0.1 of it within
    const std::vector<Rims> rims = rims_of_flat_faces(mesh, flat * longest);
    std::vector<LoosePoint> all;
    for (std::size_t i = 0; i < rims.size(); ++i) {
        const Corners corners = corners_of(mesh, mesh.triangles()[i]);
        all.clear();
        add_points(corners, longest, all);
        for (const LoosePoint& point : all) {
            if (is_near_rim(point.place, corners, rims[i], near * longest)) out.push_back(point);
        }
    }
}

// Adds those of a part's mesh.
void add_points(const TriMesh& mesh, const geometry::TriangleBvh& shape, double longest, bool rigid,
                std::vector<LoosePoint>& out)
{
    const std::size_t first = out.size();
    if (rigid) {
        add_points_on_rims(mesh, longest, out);
    } else {
        for (const Triangle& t : mesh.triangles()) add_points(corners_of(mesh, t), longest, out);
    }
    // The triangles may all face inward.
    geometry::parallel_for(out.size() - first, 256, [&](std::size_t begin, std::size_t end) {
        geometry::WindingWalk walk(shape, 2 * longest);
        for (std::size_t i = first + begin; i < first + end; ++i) {
            LoosePoint& point = out[i];
            if (walk.inside(point.place + 1e-3 * longest * point.normal)) point.normal *= -1;
        }
    });
}

// Which points are taken together: those of one cube, of one of across^3 boxes in it, and of one
// side of six.
constexpr std::uint64_t most_in_cube =
    6 * Density::most_crowds * Density::most_crowds * Density::most_crowds;
std::uint64_t crowd_of(std::uint32_t cube, const Vec3& place, const Vec3& normal, int across)
{
    const geometry::Vec3i in =
        (place * across).array().floor().cast<int>().cwiseMax(0).cwiseMin(across - 1);
    Eigen::Index axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    const auto side = static_cast<int>(2 * axis) + (normal[axis] > 0 ? 1 : 0);
    const int number = ((in.z() * across + in.y()) * across + in.x()) * 6 + side;
    return std::uint64_t{cube} * most_in_cube + static_cast<std::uint64_t>(number);
}

using CrowdedPoints = std::vector<std::pair<std::uint64_t, ShapePoint>>;  // by their crowd

// Finds the cubes of the points of a model's parts: those of part_of_point[i] are kept where it has
// their cube.
void keep_points(const ShapedModel& model, const std::vector<LoosePoint>& loose,
                 const std::vector<std::uint32_t>& part_of_point,
                 const std::vector<int>& crowds_of_point, CrowdedPoints& out)
{
    const Cubes& cubes = model.cubes;
    TriMesh mesh;
    for (const LoosePoint& point : loose) mesh.positions.push_back(point.place.cast<float>());
    if (mesh.positions.empty()) return;
    if (!cubes.part.empty()) {  // those of a part are joined, as they go with one body
        geometry::MeshTopology joined;
        for (std::uint32_t i = 1; i < loose.size(); ++i) {
            if (part_of_point[i] == part_of_point[i - 1]) joined.triangles.push_back({i - 1, i, i});
        }
        mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(joined));
    }
    const geometry::Binding binding = geometry::bind(mesh, cubes);
    for (std::size_t i = 0; i < loose.size(); ++i) {
        const std::uint32_t cube = binding.used[binding.cube[i]];
        if (model.part_of[cube] != part_of_point[i]) continue;
        const Vec3 place =
            (loose[i].place - cubes.origin) / cubes.size - cubes.cell[cube].cast<double>();
        out.push_back(
            {crowd_of(model.first_cube + cube, place, loose[i].normal, crowds_of_point[i]),
             {place.cast<float>(), loose[i].normal.cast<float>(),
              static_cast<float>(loose[i].area)}});
    }
}

// Sorts points by cube, and takes crowds together, into the shapes.
void take_points(CrowdedPoints& points, PartShapes& out)
{
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < points.size();) {
        const std::uint64_t crowd = points[i].first;
        Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
        double area = 0;
        for (; i < points.size() && points[i].first == crowd; ++i) {
            const ShapePoint& p = points[i].second;
            place += double(p.area) * p.place.cast<double>();
            normal += double(p.area) * p.normal.cast<double>();
            area += double(p.area);
        }
        const auto cube = static_cast<std::uint32_t>(crowd / most_in_cube);
        if (out.holder.empty() || out.holder.back() != cube) {
            out.holder.push_back(cube);
            out.point_at.push_back(static_cast<std::uint32_t>(out.point.size()));
        }
        out.point.push_back({(place / area).cast<float>(), normal.normalized().cast<float>(),
                             static_cast<float>(area)});
    }
    out.point_at.push_back(static_cast<std::uint32_t>(out.point.size()));
}

// Where the point of a touch is, with corners at x.
Vec3 own_place(const PlaneTouch& touch, const Aligned<double>& x)
{
    Vec3 out = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        out +=
            double(touch.weight[a]) * Eigen::Map<const Vec3>(&x[4 * std::size_t{touch.corners[a]}]);
    }
    return out;
}

// A pair of parts that lie in each other at rest, and where they do.
struct Overlap {
    PartPair pair;
    double depth;  // m
    Vec3 place;    // m
};

// Those deeper than rounding and bulges of thinned points, ascending; of each pair the deepest.
std::vector<Overlap> overlaps_at_rest(const PartShapes& shapes, const CornerBody& body)
{
    constexpr double deep = 0.05;  // cubes
    const Aligned<double> still(body.numbers, 0);
    std::vector<Overlap> out;
    const auto add = [&](std::uint32_t a, std::uint32_t b, double depth, const Vec3& place) {
        out.push_back({{std::min(a, b), std::max(a, b)}, depth, place});
    };
    const auto pairs = near_parts(shapes, body.rest.data(), still.data(), 1);
    for (const PlaneTouch& touch :
         find_part_touches(shapes, pairs, body.rest.data(), still.data(), 1, Look::back)) {
        const std::uint32_t a = body.part_of(touch.corners[0]), b = touch.other;
        const double size = std::min(shapes.size_of(a), shapes.size_of(b));
        const double depth = -touch.gap(body.rest.data());
        if (depth > deep * size) add(a, b, depth, own_place(touch, body.rest));
    }

    // Surfaces that coincide have points that are in neither.
    const auto look = [&](std::uint32_t a, std::uint32_t b) {
        geometry::stop_if_asked();
        const auto& nodes = shapes.shape[a].tree().nodes;
        if (nodes.empty()) return;
        for (const auto c : shapes.cubes[b]) {
            const Vec3 middle =
                shapes.grid[b].origin +
                shapes.size_of(b) * (shapes.cell[c].cast<double>().array() + 0.5).matrix();
            if (nodes.front().box.distance_sq(middle) > 0) continue;
            if (!shapes.shape[b].inside(middle) || !shapes.shape[a].inside(middle)) continue;
            add(a, b, 0, middle);
            return;
        }
    };
    for (const PartPair& pair : pairs) {
        if (pair.a != pair.b) look(pair.a, pair.b), look(pair.b, pair.a);
    }
    std::stable_sort(out.begin(), out.end(), [](const Overlap& a, const Overlap& b) {
        return a.pair != b.pair ? a.pair < b.pair : a.depth > b.depth;
    });
    const auto same = [](const Overlap& a, const Overlap& b) { return a.pair == b.pair; };
    out.erase(std::unique(out.begin(), out.end(), same), out.end());
    return out;
}

// visit(part, its closed shape) for each part of a model, ascending. `cubes_of` lists the body's.
template <class Visit>
void for_closed_parts(const ShapedModel& model, const PartLists& cubes_of, const Visit& visit)
{
    const TriMesh* const surface = model.surface;
    PartLists triangles;
    if (surface) triangles = triangles_of_parts(model);
    MeshOfSome some(surface ? surface->positions.size() : 0);
    std::vector<std::uint32_t> own(model.part_of.begin(), model.part_of.end());
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    for (const std::uint32_t p : own) {
        TriMesh mesh;
        if (surface) {
            const auto at = [&](std::uint32_t v) { return surface->positions[v]; };
            for (const auto t : triangles[p]) some.add(surface->triangles()[t], at);
            mesh = some.take();
        }
        std::vector<std::uint32_t> of;
        for (const auto c : cubes_of[p]) of.push_back(c - model.first_cube);
        visit(p, closed_shape(std::move(mesh), model.cubes, of));
    }
}

// What the shapes keep of the cubes themselves. Returns the part of each.
std::vector<std::uint32_t> take_cubes(const Cubes& cubes, const CornerBody& body, PartShapes& out)
{
    std::vector<std::uint32_t> part_of;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        auto& corners = out.corners.emplace_back();
        for (std::size_t a = 0; a < 8; ++a) {
            corners[a] = static_cast<std::uint32_t>(body.slot_of(cubes.corners[c][a]));
        }
        part_of.push_back(body.part_of(corners[0]));
        out.stiffness.push_back(
            static_cast<float>(cubes.young[c] * std::clamp(cubes.fill[c], 0.05, 1.0)));
        out.mass.push_back(static_cast<float>(cubes.mass[c]));
        out.mass_of_all += cubes.mass[c];
    }
    return part_of;
}

// The shapes of a model's parts, and, unless that is null, their points.
void add_shapes(const ShapedModel& model, const CornerBody& body, PartShapes& out,
                CrowdedPoints* points)
{
    const Cubes& cubes = model.cubes;
    std::vector<LoosePoint> loose;
    std::vector<std::uint32_t> part_of_point;
    std::vector<int> crowds_of_point;
    for_closed_parts(model, out.cubes, [&](std::uint32_t p, TriMesh mesh) {
        out.grid[p] = {cubes.size, cubes.origin};
        out.shape[p] = geometry::TriangleBvh(mesh);
        if (auto outer = outer_faces(mesh, out.shape[p], cubes.size)) {
            mesh = std::move(*outer);
            out.outer[p] = geometry::TriangleBvh(mesh);
        }
        if (!points) return;
        const bool rigid = !body.rigid.empty() && body.rigid[p] != 0;
        const Density density(mesh, cubes.size);
        add_points(mesh, out.shape[p], density.longest, rigid, loose);
        part_of_point.resize(loose.size(), p);
        crowds_of_point.resize(loose.size(), density.crowds);
    });
    // All at once: a search for the cubes of some is over the cubes of all.
    if (points) keep_points(model, loose, part_of_point, crowds_of_point, *points);
}

// All but points and what they need. Returns the part of each cube.
std::vector<std::uint32_t> take_shapes(const BodyModels& models, const CornerBody& body,
                                       PartShapes& out, CrowdedPoints* points)
{
    const Cubes& cubes = models.all();
    out.least_size = body.h;
    std::vector<std::uint32_t> part_of = take_cubes(cubes, body, out);
    out.cubes = make_part_lists(part_of, body.parts);
    std::vector<std::uint32_t> part_of_slot(body.corners);
    for (std::size_t k = 0; k < body.corners; ++k) part_of_slot[k] = body.part_of(k);
    out.slots = make_part_lists(part_of_slot, body.parts);
    out.grid.resize(body.parts);
    out.shape.resize(body.parts);
    out.outer.resize(body.parts);
    out.cell.reserve(cubes.count());
    for (std::size_t m = 0; m < models.count(); ++m) {
        const auto [own, surface] = models.model(m);
        const std::uint32_t first = models.start(m).cube;
        out.cell.insert(out.cell.end(), own->cell.begin(), own->cell.end());
        add_shapes(
            {*own, surface, first, std::span(part_of).subspan(first, own->count()), body.parts},
            body, out, points);
    }
    return part_of;
}

}  // namespace

PartShapes make_part_shapes(const BodyModels& models, const CornerBody& body,
                            const PartContactOptions& options)
{
    const Cubes& cubes = models.all();
    PartShapes out;
    out.friction = options.friction;
    out.bounce = options.bounce;
    CrowdedPoints points;
    const std::vector<std::uint32_t> part_of = take_shapes(models, body, out, &points);
    std::vector<std::uint32_t> part_of_holder;
    take_points(points, out);
    for (const auto c : out.holder) part_of_holder.push_back(part_of[c]);

    out.holders = make_part_lists(part_of_holder, body.parts);
    if (options.self) {
        out.around = cubes_around(out.corners, out.holder, body.corners);
        out.quarters = cubes.part;
    }
    find_windings(out);
    for (const Overlap& overlap : overlaps_at_rest(out, body)) {
        out.overlapping.push_back(overlap.pair);
        out.overlap_at.push_back(overlap.place);
    }
    return out;
}

PartShapes make_outlines(const BodyModels& models, const CornerBody& body)
{
    PartShapes out;
    take_shapes(models, body, out, nullptr);
    find_windings(out);
    return out;
}

static void for_closed_shapes_of(const BodyModels& models, const CornerBody& body,
                                 const std::vector<std::uint8_t>& which,
                                 const std::function<void(std::uint32_t, TriMesh)>& visit)
{
    const Cubes& cubes = models.all();
    std::vector<std::uint32_t> part_of;
    for (const auto& corners : cubes.corners) {
        part_of.push_back(body.part_of(body.slot_of(corners[0])));
    }
    const PartLists cubes_of = make_part_lists(part_of, body.parts);
    for (std::size_t m = 0; m < models.count(); ++m) {
        if (which[m] == 0) continue;
        const auto [own, surface] = models.model(m);
        const std::uint32_t first = models.start(m).cube;
        const std::span own_parts = std::span(part_of).subspan(first, own->count());
        for_closed_parts({*own, surface, first, own_parts, body.parts}, cubes_of,
                         [&](std::uint32_t p, TriMesh mesh) { visit(p, std::move(mesh)); });
    }
}

void for_closed_shapes(const BodyModels& models, const CornerBody& body,
                       const std::function<void(std::uint32_t, TriMesh)>& visit)
{
    for_closed_shapes_of(models, body, std::vector<std::uint8_t>(models.count(), 1), visit);
}

std::vector<geometry::MassProperties> solids_of_rigid_parts(const BodyModels& models,
                                                            const CornerBody& body)
{
    std::vector<std::uint8_t> which(models.count(), 0);
    for (std::size_t m = 0; m < models.count(); ++m) {
        const std::uint32_t k = models.all().corners[models.start(m).cube][0];
        const bool rigid = body.rigid[body.part_of(body.slot_of(k))] != 0;  // as are all its parts
        which[m] = models.model(m).surface && rigid ? 1 : 0;
    }
    std::vector<geometry::MassProperties> out(body.parts);
    for_closed_shapes_of(models, body, which, [&](std::uint32_t p, const TriMesh& mesh) {
        out[p] = geometry::mass_properties(mesh);
    });
    return out;
}

std::shared_ptr<const PartShapes> shapes_that_touch(const BodyModels& models,
                                                    const CornerBody& body,
                                                    const PartContactOptions& options)
{
    const bool may = options.on && (body.parts > 1 || options.self);
    if (!may || geometry::flat_axis(models.all()) >= 0) return nullptr;
    return std::make_shared<const PartShapes>(make_part_shapes(models, body, options));
}

}  // namespace physics
