// What becomes of the mesh, step by step:
//   vertices in parted cubes go with their parts            carry_old_vertices
//   the corners of cut faces come to be where they belong   carried_corners
//   corners that meet at rest and still do become one       add_corner
//   the new faces are listed with all that belongs to them  add_faces

#include "geometry/embed/cut_torn.hpp"

#include "geometry/embed/cut_faces.hpp"
#include "geometry/embed/part_motion.hpp"
#include "geometry/embed/t_junctions.hpp"
#include "geometry/embed/torn_faces.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/polygons.hpp"

#include <algorithm>
#include <limits>
#include <map>

namespace geometry {
namespace {

// The lists by which faces of the mesh at rest name normals and texture coordinates.
struct FaceLists {
    const TriMesh& rest;
    bool own_normals;  // listed for themselves; else a vertex's normal has the vertex's number
    bool has_normals, has_uvs;

    const std::vector<Triangle>& triangles() const { return rest.topology->triangles; }
    const std::vector<Triangle>& normals() const  // has_normals
    {
        return own_normals ? rest.topology->normal_triangles : triangles();
    }
    const std::vector<Triangle>& uvs() const { return rest.topology->uv_triangles; }  // has_uvs
};

FaceLists lists_of(const TriMesh& rest)
{
    const MeshTopology& t = *rest.topology;
    const bool own_normals = t.normal_triangles.size() == t.triangles.size();
    const bool listed = own_normals || rest.normals.size() == rest.positions.size();
    return {rest, own_normals, !rest.normals.empty() && listed,
            t.uv_triangles.size() == t.triangles.size()};
}

// The mean of some of `values` by the shares of a face's corners.
template <class Value>
Value mixed(const std::vector<Value>& values, const Triangle& at,
            const std::array<double, 3>& share)
{
    Value sum = float(share[0]) * values[at[0]];
    for (std::size_t k = 1; k < 3; ++k) sum += float(share[k]) * values[at[k]];
    return sum;
}

// Where the corners of new faces come to be: their places, and a normal each where there are any.
TriMesh carried_corners(const FaceLists& lists, const Cubes& cubes, std::span<const Vec3> x,
                        std::span<const std::uint8_t> torn, const PartMotion& motion,
                        const std::vector<CutFaces::Corner>& corners)
{
    TriMesh points;
    for (const CutFaces::Corner& c : corners) {
        if (c.closes()) {
            points.positions.push_back((cubes.origin + cubes.size * c.at).cast<float>());
            if (lists.has_normals) points.normals.push_back(c.outward.cast<float>());
            continue;
        }
        points.positions.push_back(mixed(lists.rest.positions, lists.triangles()[c.face], c.share));
        if (!lists.has_normals) continue;
        points.normals.push_back(
            mixed(lists.rest.normals, lists.normals()[c.face], c.share).normalized());
    }
    // Joined, as the faces are: what lies outside of all cubes goes with what is near.
    MeshTopology joined;
    for (std::uint32_t i = 1; i < points.positions.size(); ++i) {
        joined.triangles.push_back({i - 1, i, i});
    }
    points.topology = std::make_shared<MeshTopology>(std::move(joined));
    const Binding binding = bind(points, cubes, false);
    TriMesh out = embed(binding, points, cubes, x, torn);
    CarriedByParts carried;
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
        const std::uint32_t part = corners[i].part, bound = part_of(motion, binding, i);
        if (part != no_index) {
            add_place(carried, motion, part, points.positions[i], i);
        } else if (bound != no_index) {  // on its border, or outside and nearest to it
            add_vertex(carried, motion, bound, points.positions[i], binding, i);
        } else {
            continue;
        }
        if (lists.has_normals) add_normal(carried, points.normals[i], i);
    }
    carry(carried, motion, out.positions, out.normals);
    return out;
}

// Vertices in parted cubes go with the part that they are in. Those that uncut faces share lie on
// the border of their cube, where it makes a difference to their normals only.
void carry_old_vertices(const FaceLists& lists, const Binding& binding, const PartMotion& motion,
                        TriMesh& mesh)
{
    const TriMesh& rest = lists.rest;
    std::vector<std::uint32_t> part(rest.positions.size(), no_index);
    for (std::uint32_t v = 0; v < part.size(); ++v) part[v] = part_of(motion, binding, v);
    std::map<std::uint32_t, std::vector<std::uint32_t>> normals_at;
    for (std::size_t f = 0; lists.has_normals && f < lists.normals().size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = lists.triangles()[f][k];
            if (part[v] != no_index) normals_at[v].push_back(lists.normals()[f][k]);
        }
    }
    CarriedByParts carried;
    for (std::uint32_t v = 0; v < part.size(); ++v) {
        if (part[v] == no_index) continue;
        add_vertex(carried, motion, part[v], rest.positions[v], binding, v);
        for (const std::uint32_t n : normals_at[v]) add_normal(carried, rest.normals[n], n);
    }
    carry(carried, motion, mesh.positions, mesh.normals);
}

// The number of the group "inside"; without groups so far, all faces are of "outside".
std::uint16_t group_inside(MeshTopology& topology)
{
    auto& names = topology.groups;
    if (topology.group.empty()) {
        names.assign(1, "outside");
        topology.group.assign(topology.triangles.size(), 0);
    }
    const auto found = std::find(names.begin(), names.end(), "inside");
    if (found != names.end()) return std::uint16_t(found - names.begin());
    if (names.size() > 0xffff) return 0;
    names.emplace_back("inside");
    return std::uint16_t(names.size() - 1);
}

// The number of this material; without materials so far, all faces have the first or the default.
std::uint16_t number_of(MeshTopology& topology, const Material& material)
{
    auto& all = topology.materials;
    if (all.empty()) all.emplace_back();
    if (topology.material.empty()) topology.material.assign(topology.triangles.size(), 0);
    const auto found = std::find(all.begin(), all.end(), material);
    if (found != all.end()) return std::uint16_t(found - all.begin());
    if (all.size() > 0xffff) return 0;
    all.push_back(material);
    return std::uint16_t(all.size() - 1);
}

// Where a point lies along the plane across an axis.
Vec2f place_along(const Vec3& across, const Vec3& at)
{
    Eigen::Index axis = 0;
    across.cwiseAbs().maxCoeff(&axis);
    return Vec3f(at.cast<float>())({(axis + 1) % 3, (axis + 2) % 3});
}

// The mesh while corners and faces are added to it.
struct Growing {
    const FaceLists& lists;
    const Cubes& cubes;
    const Closing& closing;
    TriMesh& mesh;
    MeshTopology topology;
    // Vertices that new faces have, by their places at rest.
    std::map<std::uint32_t, std::vector<std::uint32_t>> known;
};

// The vertex, normal and texture coordinates of a corner that is carried to `at` with `normal`
// (null: none). One vertex for all that meet at rest and still do.
Triangle add_corner(Growing& growing, const CutFaces::Corner& c, const Vec3f& at,
                    const Vec3f* normal)
{
    const FaceLists& lists = growing.lists;
    TriMesh& mesh = growing.mesh;
    // Or as near as rounding to single precision has them, far from the origin.
    constexpr float rounding = 10 * std::numeric_limits<float>::epsilon();
    const float near = float(1e-4 * growing.cubes.size) + rounding * at.cwiseAbs().maxCoeff();
    const Triangle& vertices = lists.triangles()[c.face];
    const auto meets = [&](std::uint32_t v) { return (mesh.positions[v] - at).norm() < near; };
    auto& there = growing.known[c.place];
    const auto k = std::size_t(std::max_element(c.share.begin(), c.share.end()) - c.share.begin());
    Triangle out{};
    if (!c.closes() && c.share[k] > 1 - 1e-9 && meets(vertices[k])) {  // a corner of the face
        out[0] = vertices[k];
        there.push_back(out[0]);
        if (lists.has_normals) out[1] = lists.normals()[c.face][k];
        if (lists.has_uvs) out[2] = lists.uvs()[c.face][k];
        return out;
    }
    const auto same = std::find_if(there.begin(), there.end(), meets);
    out[0] = same != there.end() ? *same : std::uint32_t(mesh.positions.size());
    if (same == there.end()) {
        there.push_back(out[0]);
        mesh.positions.push_back(at);
        if (!mesh.colours.empty()) {
            mesh.colours.push_back(mixed(lists.rest.colours, vertices, c.share));
        }
        for (Attribute& a : mesh.attributes) {
            a.values.push_back(mixed(a.values, vertices, c.share));
        }
    }
    if (lists.has_normals) {
        out[1] = std::uint32_t(mesh.normals.size());
        mesh.normals.push_back(*normal);
    }
    if (lists.has_uvs) {
        auto& uvs = growing.topology.uvs;
        out[2] = std::uint32_t(uvs.size());
        uvs.push_back(c.closes() && growing.closing.material
                          ? place_along(c.outward, growing.cubes.origin + growing.cubes.size * c.at)
                          : mixed(lists.rest.topology->uvs, lists.uvs()[c.face], c.share));
    }
    return out;
}

// `corner`: vertex, normal and texture coordinates of each corner.
void add_faces(Growing& growing, const CutFaces& cut, const std::vector<Triangle>& corner)
{
    const MeshTopology& before = *growing.lists.rest.topology;
    MeshTopology& topology = growing.topology;
    const auto& corners = cut.corners;
    const bool closes = corners[cut.faces.back()[0]].closes();
    const std::uint16_t inside = closes ? group_inside(topology) : 0;
    const bool own_material = closes && growing.closing.material;
    const std::uint16_t material =
        own_material ? number_of(topology, *growing.closing.material) : 0;
    for (const Triangle& face : cut.faces) {
        const std::uint32_t source = corners[face[0]].face;
        const auto entries = [&](std::size_t what) -> Triangle {
            return {corner[face[0]][what], corner[face[1]][what], corner[face[2]][what]};
        };
        topology.triangles.push_back(entries(0));
        if (growing.lists.has_normals) topology.normal_triangles.push_back(entries(1));
        if (growing.lists.has_uvs) topology.uv_triangles.push_back(entries(2));
        if (!topology.polygon.empty()) add_polygon(topology.polygon, 1);
        const bool is_inside = corners[face[0]].closes();
        if (!topology.material.empty()) {
            const std::uint16_t outside =
                before.material.empty() ? std::uint16_t{0} : before.material[source];
            topology.material.push_back(is_inside && own_material ? material : outside);
        }
        if (!closes && before.group.empty()) continue;
        const std::uint16_t outside =
            before.group.empty() ? std::uint16_t{0} : before.group[source];
        topology.group.push_back(is_inside ? inside : outside);
    }
}

}  // namespace

TriMesh cut_torn(const Binding& binding, const TriMesh& rest, TriMesh carried, const Cubes& cubes,
                 std::span<const Vec3> x, std::span<const std::uint32_t> broken,
                 std::span<const PartedCube> parted, const Closing& closing)
{
    if (parted.empty()) return carried;
    const FaceLists lists = lists_of(rest);
    const std::vector<std::uint8_t> torn = marked(cubes, parted);
    const PartMotion motion = motion_of_parts(cubes, x, broken, parted, torn);
    carry_old_vertices(lists, binding, motion, carried);
    CutFaces cut = cut_faces(binding, rest, cubes, parted, closing.solid);
    if (cut.faces.empty()) return carried;
    split_at_t_junctions(rest, cubes, cut);

    const TriMesh points = carried_corners(lists, cubes, x, torn, motion, cut.corners);
    carried = without_faces(std::move(carried), cut.cut);
    Growing growing{lists, cubes, closing, carried, *carried.topology, {}};
    if (lists.has_normals && !lists.own_normals) {
        growing.topology.normal_triangles = growing.topology.triangles;
    }
    std::vector<Triangle> corner;
    for (std::size_t i = 0; i < cut.corners.size(); ++i) {
        corner.push_back(add_corner(growing, cut.corners[i], points.positions[i],
                                    lists.has_normals ? &points.normals[i] : nullptr));
    }
    add_faces(growing, cut, corner);
    carried.topology = std::make_shared<MeshTopology>(std::move(growing.topology));
    return carried;
}

}  // namespace geometry
