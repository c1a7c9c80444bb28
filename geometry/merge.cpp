#include "geometry/merge.hpp"

#include "geometry/normals.hpp"

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

// The place of `thing` in `all`, at the end when it is new.
template <class T> std::uint16_t place_in(std::vector<T>& all, const T& thing, const char* what)
{
    const auto found = std::find(all.begin(), all.end(), thing);
    const auto place = static_cast<std::size_t>(found - all.begin());
    if (found == all.end()) all.push_back(thing);
    if (place > 0xffff) {
        throw std::invalid_argument(std::string("the merged meshes have more than 65,536 ") + what);
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

}  // namespace

TriMesh merge(std::span<const TriMesh* const> meshes)
{
    const auto any = [&](const auto& has) {
        return std::any_of(meshes.begin(), meshes.end(), has);
    };
    const bool normals = any([](const TriMesh* m) { return !m->normals.empty(); });
    const bool colours = any([](const TriMesh* m) { return !m->colours.empty(); });
    const bool uvs = any([](const TriMesh* m) { return !m->topology->uv_triangles.empty(); });
    const bool materials = any([](const TriMesh* m) { return !m->topology->materials.empty(); });
    const bool groups = any([](const TriMesh* m) { return !m->topology->groups.empty(); });

    TriMesh out;
    MeshTopology topology;
    for (const TriMesh* given : meshes) {
        TriMesh with_normals;
        if (normals && given->normals.empty() && !given->triangles().empty()) {
            with_normals = *given;
            compute_normals(with_normals, crease);
            given = &with_normals;
        }
        const TriMesh& mesh = *given;
        const MeshTopology& t = *mesh.topology;
        const std::size_t faces = t.triangles.size();

        append_triangles(topology.triangles, t.triangles, out.positions.size());
        append_triangles(topology.normal_triangles, t.normal_triangles, out.normals.size());
        append(out.positions, mesh.positions);
        append(out.normals, mesh.normals);
        if (out.positions.size() > 0xffff'ffffu) {
            throw std::invalid_argument("the merged meshes have more than 2^32 - 1 vertices");
        }
        if (colours) {
            append(out.colours, mesh.colours);
            out.colours.resize(out.positions.size(), Vec3f::Ones());
        }
        append_attributes(out, mesh);

        if (uvs && t.uv_triangles.empty()) {
            const auto nowhere = static_cast<std::uint32_t>(topology.uvs.size());
            topology.uvs.emplace_back(0.f, 0.f);
            topology.uv_triangles.insert(topology.uv_triangles.end(), faces,
                                         {nowhere, nowhere, nowhere});
        } else if (uvs) {
            append_triangles(topology.uv_triangles, t.uv_triangles, topology.uvs.size());
            append(topology.uvs, t.uvs);
        }
        if (materials) {
            std::vector<std::uint16_t> places;
            for (const Material& m : t.materials) {
                places.push_back(place_in(topology.materials, m, "materials"));
            }
            if (places.empty()) {
                places.push_back(place_in(topology.materials, Material{}, "materials"));
            }
            append_renamed(topology.material, t.material, faces, places);
        }
        if (groups) {
            std::vector<std::uint16_t> places;
            for (const std::string& g : t.groups) {
                places.push_back(place_in(topology.groups, g, "groups"));
            }
            if (places.empty()) places.push_back(place_in(topology.groups, {}, "groups"));
            append_renamed(topology.group, t.group, faces, places);
        }
    }
    out.topology = std::make_shared<const MeshTopology>(std::move(topology));
    return out;
}

}  // namespace geometry
