#include "physics/state/choose_corners.hpp"

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "physics/state/state_models.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::TriMesh;

template <class Chosen> std::vector<std::uint32_t> corners_if(const Cubes& cubes, const Chosen& is)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (is(k)) out.push_back(k);
    }
    return out;
}

// Of corners in a region, those of pieces that it meets: a cube reaches beyond the piece in it,
// over others that are not meant. meets(box): whether the region meets a box in m.
template <class Meets>
std::vector<std::uint32_t> of_pieces(const Cubes& cubes, std::vector<std::uint32_t> corners,
                                     const Meets& meets)
{
    if (cubes.part.empty()) return corners;
    std::vector<std::uint8_t> met(cubes.corner_count(), 0), chosen(met);
    for (const auto k : corners) chosen[k] = 1;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto& own = cubes.corners[c];
        if (std::none_of(own.begin(), own.end(), [&](auto k) { return chosen[k] != 0; })) continue;
        const geometry::Box held = held_box(cubes, c);
        if (!meets({cubes.origin + cubes.size * held.lo, cubes.origin + cubes.size * held.hi})) {
            continue;
        }
        for (const auto k : own) met[k] = 1;
    }
    std::erase_if(corners, [&](std::uint32_t k) { return met[k] == 0; });
    return corners;
}

// "a, b, c" of at most twenty.
std::string listed(const std::vector<std::string>& names)
{
    std::string out;
    for (std::size_t i = 0; i < std::min<std::size_t>(names.size(), 20); ++i) {
        out += (i ? ", " : "") + names[i];
    }
    return names.size() > 20 ? out + " ..." : out;
}

}  // namespace

std::vector<std::uint32_t> faces_called(const TriMesh& mesh, const std::string& name)
{
    const geometry::MeshTopology& all = *mesh.topology;
    std::vector<std::string> materials;
    for (const auto& m : all.materials) materials.push_back(m.name);
    const auto picked = [&](const std::vector<std::string>& names,
                            const std::vector<std::uint16_t>& of_face, std::size_t face) {
        const std::size_t index = face < of_face.size() ? of_face[face] : 0;
        return index < names.size() && names[index] == name;
    };
    std::vector<std::uint32_t> out;
    for (std::uint32_t t = 0; t < all.triangles.size(); ++t) {
        if (picked(materials, all.material, t) ||
            (!all.group.empty() && picked(all.groups, all.group, t))) {
            out.push_back(t);
        }
    }
    if (out.empty()) {
        throw std::invalid_argument("no face of the mesh has a material or group called '" + name +
                                    "'. Its materials: " + listed(materials) +
                                    "; its groups: " + listed(all.groups));
    }
    return out;
}

TriMesh faces_of(const TriMesh& mesh, const std::string& name)
{
    auto part = std::make_shared<geometry::MeshTopology>();
    for (const auto t : faces_called(mesh, name)) part->triangles.push_back(mesh.triangles()[t]);
    TriMesh out;
    out.topology = std::move(part);
    out.positions = mesh.positions;
    return out;
}

std::vector<std::uint32_t> corners_in_box(const Cubes& cubes, const geometry::Box& box)
{
    auto corners = corners_if(cubes, [&](std::uint32_t k) {
        const Vec3 p = cubes.corner_position(k);
        return (p.array() >= box.lo.array()).all() && (p.array() <= box.hi.array()).all();
    });
    return of_pieces(cubes, std::move(corners), [&](const geometry::Box& held) {
        return (held.hi.array() >= box.lo.array()).all() &&
               (held.lo.array() <= box.hi.array()).all();
    });
}

std::vector<std::uint32_t> corners_in_sphere(const Cubes& cubes, const Vec3& centre, double radius)
{
    auto corners = corners_if(cubes, [&](std::uint32_t k) {
        return (cubes.corner_position(k) - centre).norm() <= radius;
    });
    return of_pieces(cubes, std::move(corners), [&](const geometry::Box& held) {
        return (centre - centre.cwiseMax(held.lo).cwiseMin(held.hi)).norm() <= radius;
    });
}

std::vector<std::uint32_t> corners_below(const Cubes& cubes, double height)
{
    auto corners =
        corners_if(cubes, [&](std::uint32_t k) { return cubes.corner_position(k).y() <= height; });
    return of_pieces(cubes, std::move(corners),
                     [&](const geometry::Box& held) { return held.lo.y() <= height; });
}

// Within so many mean sides of triangles.
static std::vector<std::uint32_t> corners_at_end_of_sheet(const Cubes& sheet, int axis, End end,
                                                          int layers)
{
    constexpr double rounding = 1e-4;
    const double depth = (layers + rounding) * sheet.size;
    double lo = sheet.place[0][axis], hi = lo;
    for (const Vec3& p : sheet.place) {
        lo = std::min(lo, p[axis]);
        hi = std::max(hi, p[axis]);
    }
    return corners_if(sheet, [&](std::uint32_t k) {
        const double at = sheet.place[k][axis];
        return (end != End::high && at <= lo + depth) || (end != End::low && at >= hi - depth);
    });
}

// Of corners in the outermost plane at one end, those of bodies that end there: not of one that
// ends half a cube or more before others, and shares cells with them.
static std::vector<std::uint32_t>
of_outermost(const Cubes& cubes, std::vector<std::uint32_t> corners, int axis, bool low)
{
    constexpr double half = 0.5 - 1e-6;  // cubes
    if (cubes.part.empty()) return corners;
    const auto bodies = find_components(cubes, geometry::Connectivity::corner);
    std::vector<double> from(bodies.count(), std::numeric_limits<double>::infinity());
    std::vector<std::uint32_t> body(cubes.corner_count());
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const geometry::Box held = held_box(cubes, c);
        double& least = from[bodies.label[c]];
        least = std::min(least, low ? held.lo[axis] : -held.hi[axis]);
        for (const auto k : cubes.corners[c]) body[k] = bodies.label[c];
    }
    const double outermost = *std::min_element(from.begin(), from.end());
    std::erase_if(corners, [&](std::uint32_t k) { return from[body[k]] >= outermost + half; });
    return corners;
}

static std::vector<std::uint32_t> corners_at_one_end(const Cubes& cubes, int axis, bool low,
                                                     int layers)
{
    std::int64_t out = cubes.corner[0][axis];
    for (const auto& place : cubes.corner) {
        out = low ? std::min<std::int64_t>(out, place[axis])
                  : std::max<std::int64_t>(out, place[axis]);
    }
    const std::int64_t border = low ? out + layers : out - layers;
    auto corners = corners_if(cubes, [&](std::uint32_t k) {
        return low ? cubes.corner[k][axis] <= border : cubes.corner[k][axis] >= border;
    });
    if (layers == 0) return of_outermost(cubes, std::move(corners), axis, low);
    const double at = cubes.origin[axis] + cubes.size * static_cast<double>(border);
    return of_pieces(cubes, std::move(corners), [&](const geometry::Box& held) {
        return low ? held.lo[axis] <= at : held.hi[axis] >= at;
    });
}

std::vector<std::uint32_t> corners_at_end(const Cubes& cubes, int axis, End end, int layers)
{
    if (cubes.corner.empty()) return {};
    if (cubes.is_sheet()) return corners_at_end_of_sheet(cubes, axis, end, layers);
    if (end != End::both) return corners_at_one_end(cubes, axis, end == End::low, layers);
    const auto low = corners_at_one_end(cubes, axis, true, layers);
    const auto high = corners_at_one_end(cubes, axis, false, layers);
    std::vector<std::uint32_t> both;
    std::set_union(low.begin(), low.end(), high.begin(), high.end(), std::back_inserter(both));
    return both;
}

// Whether faces come within `distance` of a box: of the places of the faces that are nearest to its
// corners and to its middle.
static bool reaches(const geometry::TriangleBvh& faces, const geometry::Box& box, double distance)
{
    for (int i = 0; i < 9; ++i) {
        Vec3 from = 0.5 * (box.lo + box.hi);
        for (int k = 0; k < 3 && i < 8; ++k) from[k] = (i >> k & 1) != 0 ? box.hi[k] : box.lo[k];
        const auto hit = faces.closest(from);
        if (!hit) return false;
        if ((hit.point - hit.point.cwiseMax(box.lo).cwiseMin(box.hi)).norm() < distance)
            return true;
    }
    return false;
}

std::vector<std::uint32_t> corners_near_material(const Cubes& cubes, const TriMesh& mesh,
                                                 const std::string& name, double distance)
{
    const geometry::TriangleBvh tree(faces_of(mesh, name));
    std::vector<Vec3> places = corner_positions(cubes);
    std::vector<geometry::TriangleBvh::Hit> hits(places.size());
    tree.closest(places, distance, hits);
    auto corners = corners_if(cubes, [&](std::uint32_t k) { return bool(hits[k]); });
    return of_pieces(cubes, std::move(corners),
                     [&](const geometry::Box& held) { return reaches(tree, held, distance); });
}

// The ends of sides that one triangle alone has.
static std::vector<std::uint32_t> corners_at_rim_of_sheet(const Cubes& sheet)
{
    std::vector<geometry::Triangle> triangles;
    for (std::size_t c = 0; c < sheet.count(); ++c) triangles.push_back(sheet_triangle(sheet, c));
    const auto uses = geometry::edge_uses(triangles, sheet.corner_count());
    std::vector<std::uint8_t> at_rim(sheet.corner_count(), 0);
    for (std::size_t i = 0; i < uses.size(); ++i) {
        const auto same = [&](std::size_t j) {
            return uses[j].a == uses[i].a && uses[j].b == uses[i].b;
        };
        if ((i > 0 && same(i - 1)) || (i + 1 < uses.size() && same(i + 1))) continue;
        at_rim[uses[i].a] = at_rim[uses[i].b] = 1;
    }
    return corners_if(sheet, [&](std::uint32_t k) { return at_rim[k] != 0; });
}

std::vector<std::uint32_t> corners_at_rim(const Cubes& cubes)
{
    if (cubes.is_sheet()) return corners_at_rim_of_sheet(cubes);
    std::vector<std::uint32_t> around(cubes.corner_count(), 0);
    for (const auto& corners : cubes.corners) {
        for (const auto k : corners) ++around[k];
    }
    // A plane's cells name each of their corners twice.
    return corners_if(cubes, [&](std::uint32_t k) { return around[k] < 8; });
}

void require_a_place_a_corner(const Cubes& cubes, const std::vector<geometry::Vec3f>& places)
{
    if (places.size() == cubes.corner_count()) return;
    throw std::invalid_argument("expected a mesh with " + std::to_string(cubes.corner_count()) +
                                " vertices, one per corner, found " +
                                std::to_string(places.size()) +
                                ". Use the mesh that Plane or Sheet made with these cubes "
                                "(for Sheet, one without loose or doubled vertices)");
}

Pins pins_on(const Cubes& cubes, std::vector<std::uint32_t> corners,
             const std::vector<geometry::Vec3f>& places)
{
    require_a_place_a_corner(cubes, places);
    Pins out;
    for (const auto k : corners) out.target.push_back(places[k].cast<double>());
    out.corner = std::move(corners);
    out.cubes = mark_of(cubes);
    return out;
}

Pins pins_at(const Cubes& cubes, std::vector<std::uint32_t> corners, const Transform& motion,
             const std::optional<Vec3>& pivot)
{
    Pins out;
    if (pivot) out.pivot.assign(corners.size(), motion * *pivot);
    out.target.reserve(corners.size());
    for (const auto k : corners) out.target.push_back(motion * cubes.corner_position(k));
    out.corner = std::move(corners);
    out.cubes = mark_of(cubes);
    return out;
}

}  // namespace physics
