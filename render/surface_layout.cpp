#include "render/surface_layout.hpp"
#include "geometry/base/no_index.hpp"

#include <algorithm>
#include <limits>

namespace render {
namespace {

using geometry::Triangle;

constexpr std::uint32_t none = geometry::no_index;

bool within(const Triangle& t, std::size_t count)
{
    return t[0] < count && t[1] < count && t[2] < count;
}

// Files come with faces wound against their own normals. The normals say where outside is.
bool wound_against_normals(const geometry::TriMesh& mesh, const Triangle& t, const Triangle& n)
{
    const auto& p = mesh.positions;
    const geometry::Vec3f face = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]);
    return face.dot(mesh.normals[n[0]] + mesh.normals[n[1]] + mesh.normals[n[2]]) < 0;
}

}  // namespace

SurfaceLayout surface_layout(const geometry::TriMesh& mesh)
{
    SurfaceLayout out;
    out.topology = mesh.topology;
    out.positions = mesh.positions.size();
    out.normals = mesh.normals.size();
    const auto& topology = *mesh.topology;
    const std::size_t faces = topology.triangles.size();
    if (topology.normal_triangles.size() != faces) {
        out.skipped = faces;
        return out;
    }

    // The drawn vertices of a normal hang in a chain, one for each material around it: most chains
    // have one link.
    std::vector<std::uint32_t> first(mesh.normals.size(), none), next;
    const auto drawn = [&](std::uint32_t normal, std::uint32_t position, std::uint16_t material) {
        std::uint32_t* at = &first[normal];
        while (*at != none) {
            if (out.material[*at] == material && out.position[*at] == position) return *at;
            at = &next[*at];
        }
        const auto made = static_cast<std::uint32_t>(next.size());
        *at = made;
        next.push_back(none);
        out.position.push_back(position);
        out.normal.push_back(normal);
        out.material.push_back(material);
        return made;
    };

    const std::size_t materials = std::max<std::size_t>(1, topology.materials.size());
    std::vector<Triangle> clear;
    out.triangles.reserve(faces);
    for (std::size_t f = 0; f < faces; ++f) {
        const Triangle &t = topology.triangles[f], &n = topology.normal_triangles[f];
        const std::uint16_t m = topology.material.empty() ? std::uint16_t{0} : topology.material[f];
        if (!within(t, mesh.positions.size()) || !within(n, mesh.normals.size()) ||
            m >= materials) {
            ++out.skipped;
            continue;
        }
        Triangle corners{};
        for (std::size_t k = 0; k < 3; ++k) corners[k] = drawn(n[k], t[k], m);
        if (wound_against_normals(mesh, t, n)) std::swap(corners[1], corners[2]);
        const bool opaque = topology.materials.empty() || topology.materials[m].opacity >= 1;
        (opaque ? out.triangles : clear).push_back(corners);
    }
    out.opaque = out.triangles.size();
    out.triangles.insert(out.triangles.end(), clear.begin(), clear.end());
    return out;
}

}  // namespace render
