#include "geometry/mesh/merge.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/normals.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/unstated_material.hpp"

#include <algorithm>
#include <stdexcept>

namespace geometry {
namespace {

constexpr double crease = 0.7;  // rad, for meshes that come without normals

template <class T> void append(std::vector<T>& to, const std::vector<T>& from)
{
    to.insert(to.end(), from.begin(), from.end());
}

void append_triangles(std::vector<Triangle>& to, const std::vector<Triangle>& from,
                      std::size_t base)
{
    for (Triangle t : from) {
        for (auto& v : t) v += static_cast<std::uint32_t>(base);
        to.push_back(t);
    }
}

// The place of `thing` among the first `known` of `all`; at the end when it is not there.
template <class T>
std::uint16_t place_in(std::vector<T>& all, const T& thing, const char* what, std::size_t known)
{
    const auto end = all.begin() + std::ptrdiff_t(known);
    const auto found = std::find(all.begin(), end, thing);
    const auto place = found == end ? all.size() : static_cast<std::size_t>(found - all.begin());
    if (found == end) all.push_back(thing);
    if (place > 0xffff) {
        throw std::invalid_argument(std::string("the merged meshes exceed the limit of 65,536 ") +
                                    what);
    }
    return static_cast<std::uint16_t>(place);
}

// The numbers in `from` (or all 0, where a mesh has none), renamed through `places`.
void append_renamed(std::vector<std::uint16_t>& to, const std::vector<std::uint16_t>& from,
                    std::size_t faces, const std::vector<std::uint16_t>& places)
{
    for (std::size_t f = 0; f < faces; ++f) to.push_back(places[from.empty() ? 0 : from[f]]);
}

void append_attributes(TriMesh& to, const TriMesh& from)
{
    const std::size_t before = to.positions.size() - from.positions.size();
    for (const Attribute& a : from.attributes) {
        const auto same = [&](const Attribute& b) { return a.name == b.name && a.unit == b.unit; };
        auto found = std::find_if(to.attributes.begin(), to.attributes.end(), same);
        if (found == to.attributes.end()) {
            to.attributes.push_back({a.name, a.unit, {}});
            found = to.attributes.end() - 1;
        }
        found->values.resize(before, 0.f);
        append(found->values, a.values);
    }
    for (Attribute& a : to.attributes) a.values.resize(to.positions.size(), 0.f);
}

// What some of the meshes have, and the others get.
struct Has {
    bool normals, colours, uvs, materials, groups, polygons;
};

Has what_some_have(std::span<const TriMesh* const> meshes)
{
    const auto any = [&](const auto& has) {
        return std::any_of(meshes.begin(), meshes.end(), has);
    };
    return {any([](const TriMesh* m) { return !m->normals.empty(); }),
            any([](const TriMesh* m) { return !m->colours.empty(); }),
            any([](const TriMesh* m) { return !m->topology->uv_triangles.empty(); }),
            any([](const TriMesh* m) { return !m->topology->materials.empty(); }),
            any([](const TriMesh* m) { return !m->topology->groups.empty(); }),
            any([](const TriMesh* m) { return !m->topology->polygon.empty(); })};
}

void append_uvs(MeshTopology& to, const MeshTopology& from)
{
    if (from.uv_triangles.empty()) {
        const auto nowhere = static_cast<std::uint32_t>(to.uvs.size());
        to.uvs.emplace_back(0.f, 0.f);
        to.uv_triangles.insert(to.uv_triangles.end(), from.triangles.size(),
                               {nowhere, nowhere, nowhere});
    } else {
        append_triangles(to.uv_triangles, from.uv_triangles, to.uvs.size());
        append(to.uvs, from.uvs);
    }
}

void append_materials(MeshTopology& to, const MeshTopology& from)
{
    std::vector<std::uint16_t> places;
    for (const Material& m : from.materials) {
        places.push_back(place_in(to.materials, m, "materials", to.materials.size()));
    }
    if (places.empty()) {
        places.push_back(place_in(to.materials, Material{}, "materials", to.materials.size()));
    }
    append_renamed(to.material, from.material, from.triangles.size(), places);
}

void append_groups(MeshTopology& to, const MeshTopology& from)
{
    // Groups of one name within a mesh are different ones.
    const std::size_t known = to.groups.size();
    std::vector<std::uint16_t> places;
    for (const std::string& g : from.groups) {
        places.push_back(place_in(to.groups, g, "groups", known));
    }
    if (places.empty()) places.push_back(place_in(to.groups, {}, "groups", known));
    append_renamed(to.group, from.group, from.triangles.size(), places);
}

void append_polygons(MeshTopology& to, const MeshTopology& from)
{
    const std::uint32_t before = to.polygon.empty() ? 0 : to.polygon.back() + 1;
    for (const std::uint32_t number : from.polygon) to.polygon.push_back(before + number);
    if (!from.polygon.empty()) return;
    for (std::size_t f = 0; f < from.triangles.size(); ++f) add_polygon(to.polygon, 1);
}

// Of each vertex the colour of the material that its faces are drawn in.
std::vector<Vec3f> face_colours(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    std::vector<Vec3f> colours(mesh.positions.size(), Material{}.colour);
    if (t.materials.empty()) return colours;
    for (std::size_t f = 0; f < t.triangles.size(); ++f) {
        const Material& material = t.materials[t.material.empty() ? 0 : t.material[f]];
        for (const auto v : t.triangles[f]) colours[v] = material.colour;
    }
    return colours;
}

// Adds a mesh, and what the others have and it has not.
void append_mesh(TriMesh& to, MeshTopology& topology, const TriMesh& mesh, const Has& has)
{
    const MeshTopology& t = *mesh.topology;
    append_triangles(topology.triangles, t.triangles, to.positions.size());
    append_triangles(topology.normal_triangles, t.normal_triangles, to.normals.size());
    append(to.positions, mesh.positions);
    append(to.normals, mesh.normals);
    if (to.positions.size() > 0xffff'ffffu) {
        throw std::invalid_argument("the merged meshes exceed the limit of 2^32 - 1 vertices");
    }
    if (has.colours) {
        append(to.colours, has_vertex_colours(mesh) ? mesh.colours : face_colours(mesh));
    }
    append_attributes(to, mesh);
    if (has.uvs) append_uvs(topology, t);
    if (has.materials) append_materials(topology, t);
    if (has.groups) append_groups(topology, t);
    if (has.polygons) append_polygons(topology, t);
}

}  // namespace

TriMesh merge(std::span<const TriMesh* const> meshes)
{
    const Has has = what_some_have(meshes);
    TriMesh out;
    MeshTopology topology;
    for (const TriMesh* mesh : meshes) {
        stop_if_asked();
        TriMesh with_normals;
        if (has.normals && mesh->normals.empty() && !mesh->triangles().empty()) {
            with_normals = *mesh;
            compute_normals(with_normals, crease);
            mesh = &with_normals;
        }
        append_mesh(out, topology, *mesh, has);
    }
    out.topology = std::make_shared<const MeshTopology>(std::move(topology));
    return out;
}

}  // namespace geometry
