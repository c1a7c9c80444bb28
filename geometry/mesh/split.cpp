#include "geometry/mesh/split.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/polygons.hpp"

#include <algorithm>

namespace geometry {
namespace {

// What of `values` the vertices have; nothing where there are none.
template <class T>
std::vector<T> taken(const std::vector<T>& values, std::span<const std::uint32_t> vertices)
{
    std::vector<T> out;
    if (values.empty()) return out;
    out.reserve(vertices.size());
    for (const auto v : vertices) out.push_back(values[v]);
    return out;
}

// Those of `all` that faces use, and the faces' numbers into these; all where faces have no
// numbers.
template <class T>
std::vector<T> those_used(const std::vector<T>& all, std::vector<std::uint16_t>& of_face)
{
    if (of_face.empty()) return all;
    std::vector<std::uint16_t> used = of_face;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::vector<T> out;
    for (const auto i : used) out.push_back(i < all.size() ? all[i] : T{});
    for (auto& i : of_face) {
        i = static_cast<std::uint16_t>(std::lower_bound(used.begin(), used.end(), i) -
                                       used.begin());
    }
    return out;
}

// The numbers that the corners of some faces have, ascending.
std::vector<std::uint32_t> used_by(const std::vector<Triangle>& corners,
                                   std::span<const std::uint32_t> faces)
{
    std::vector<std::uint32_t> out;
    out.reserve(3 * faces.size());
    for (const auto f : faces) out.insert(out.end(), corners[f].begin(), corners[f].end());
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

// The corners of some faces by the places of their numbers in `used`. `number` has room for all.
std::vector<Triangle> renumbered(const std::vector<Triangle>& corners,
                                 std::span<const std::uint32_t> faces,
                                 std::span<const std::uint32_t> used,
                                 std::vector<std::uint32_t>& number)
{
    for (std::uint32_t i = 0; i < used.size(); ++i) number[used[i]] = i;
    std::vector<Triangle> out;
    out.reserve(faces.size());
    for (const auto f : faces) {
        const auto& [a, b, c] = corners[f];
        out.push_back({number[a], number[b], number[c]});
    }
    return out;
}

// What the corners of some faces name of `values`, and the corners by their new numbers.
template <class T>
std::vector<T> compacted(const std::vector<T>& values, const std::vector<Triangle>& corners,
                         std::span<const std::uint32_t> faces, std::vector<Triangle>& new_corners)
{
    if (corners.empty()) return {};
    const std::vector<std::uint32_t> used = used_by(corners, faces);
    std::vector<std::uint32_t> number(values.size(), no_index);
    new_corners = renumbered(corners, faces, used, number);
    return taken(values, used);
}

// The polygons that some faces are of.
std::vector<std::uint32_t> polygons_of(const std::vector<std::uint32_t>& polygon,
                                       std::span<const std::uint32_t> faces)
{
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0, end = 0; !polygon.empty() && i < faces.size(); i = end) {
        end = i + 1;
        while (end < faces.size() && polygon[faces[end]] == polygon[faces[i]]) ++end;
        add_polygon(out, end - i);
    }
    if (has_triangles_only(out)) out.clear();
    return out;
}

// `number` has room for all vertices.
TriMesh mesh_of(const TriMesh& whole, std::span<const std::uint32_t> faces,
                std::vector<std::uint32_t>& number)
{
    const std::vector<std::uint32_t> vertices = used_by(whole.triangles(), faces);
    MeshTopology topology;
    topology.triangles = renumbered(whole.triangles(), faces, vertices, number);
    topology.material = taken(whole.topology->material, faces);
    topology.group = taken(whole.topology->group, faces);
    if (!faces.empty()) {
        topology.materials = those_used(whole.topology->materials, topology.material);
        topology.groups = those_used(whole.topology->groups, topology.group);
    }
    topology.polygon = polygons_of(whole.topology->polygon, faces);
    TriMesh out;
    out.topology = std::make_shared<const MeshTopology>(std::move(topology));
    out.positions = taken(whole.positions, vertices);
    out.colours = taken(whole.colours, vertices);
    for (const Attribute& a : whole.attributes) {
        out.attributes.push_back({a.name, a.unit, taken(a.values, vertices)});
    }
    return out;
}

}  // namespace

std::vector<SplitMesh> split(const TriMesh& mesh, std::span<const std::uint32_t> of,
                             std::size_t count)
{
    std::vector<SplitMesh> out(count);
    for (std::uint32_t f = 0; f < of.size(); ++f) {
        if (of[f] < count) out[of[f]].faces.push_back(f);
    }
    std::vector<std::uint32_t> number(mesh.positions.size(), no_index);
    for (SplitMesh& part : out) {
        stop_if_asked();
        part.mesh = mesh_of(mesh, part.faces, number);
    }
    return out;
}

TriMesh part_of(const TriMesh& mesh, std::span<const std::uint8_t> kept)
{
    std::vector<std::uint32_t> faces;
    for (std::uint32_t f = 0; f < kept.size(); ++f) {
        if (kept[f] != 0) faces.push_back(f);
    }
    std::vector<std::uint32_t> number(mesh.positions.size(), no_index);
    TriMesh out = mesh_of(mesh, faces, number);
    const MeshTopology& whole = *mesh.topology;
    MeshTopology topology = *out.topology;
    out.normals = compacted(mesh.normals, whole.normal_triangles, faces, topology.normal_triangles);
    topology.uvs = compacted(whole.uvs, whole.uv_triangles, faces, topology.uv_triangles);
    out.topology = std::make_shared<const MeshTopology>(std::move(topology));
    return out;
}

}  // namespace geometry
