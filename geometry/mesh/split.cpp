#include "geometry/mesh/split.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"

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

// The vertices that some faces use, ascending.
std::vector<std::uint32_t> vertices_of(const TriMesh& mesh, std::span<const std::uint32_t> faces)
{
    std::vector<std::uint32_t> out;
    out.reserve(3 * faces.size());
    for (const auto f : faces) {
        const Triangle& t = mesh.triangles()[f];
        out.insert(out.end(), t.begin(), t.end());
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

// `number` has room for all vertices.
TriMesh mesh_of(const TriMesh& whole, std::span<const std::uint32_t> faces,
                std::vector<std::uint32_t>& number)
{
    const std::vector<std::uint32_t> vertices = vertices_of(whole, faces);
    for (std::uint32_t i = 0; i < vertices.size(); ++i) number[vertices[i]] = i;
    MeshTopology topology;
    topology.material = taken(whole.topology->material, faces);
    topology.group = taken(whole.topology->group, faces);
    topology.materials = those_used(whole.topology->materials, topology.material);
    topology.groups = those_used(whole.topology->groups, topology.group);
    topology.triangles.reserve(faces.size());
    for (const auto f : faces) {
        const auto& [a, b, c] = whole.triangles()[f];
        topology.triangles.push_back({number[a], number[b], number[c]});
    }
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

}  // namespace geometry
