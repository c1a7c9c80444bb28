#include "render/surface_layout.hpp"
#include "geometry/base/no_index.hpp"

#include <algorithm>
#include <limits>

namespace render {
namespace {

using geometry::Triangle;
using Alpha = geometry::TextureUse::Alpha;

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

// How each material is drawn, one at least. Those without textures share the first two parts.
std::vector<std::size_t> parts_of(const geometry::MeshTopology& topology,
                                  std::vector<SurfaceLayout::Part>& parts)
{
    std::vector<std::size_t> part_of;
    parts.resize(2);
    parts[1].clear = true;
    const bool has_uvs = topology.uv_triangles.size() == topology.triangles.size();
    for (const geometry::Material& m : topology.materials) {
        const bool textured = has_uvs && (m.texture || m.normal_map);
        const bool clear =
            m.opacity < 1 || (textured && m.texture && m.use.alpha == Alpha::blended);
        part_of.push_back(textured ? parts.size() : clear ? 1 : 0);
        if (!textured) continue;
        parts.push_back({0, clear, true, static_cast<std::uint16_t>(part_of.size() - 1)});
    }
    if (part_of.empty()) part_of.push_back(0);
    return part_of;
}

// The drawn vertices of a normal hang in a chain, one for each material and place of a picture
// around it: most chains have one link.
class DrawnVertices {
public:
    DrawnVertices(SurfaceLayout& out, std::size_t normals) : out_(out), first_(normals, none) {}

    std::uint32_t number(std::uint32_t normal, std::uint32_t position, std::uint16_t material,
                         std::uint32_t uv)
    {
        std::uint32_t* at = &first_[normal];
        while (*at != none) {
            if (out_.material[*at] == material && out_.position[*at] == position &&
                out_.uv[*at] == uv) {
                return *at;
            }
            at = &next_[*at];
        }
        const auto made = static_cast<std::uint32_t>(next_.size());
        *at = made;
        next_.push_back(none);
        out_.position.push_back(position);
        out_.normal.push_back(normal);
        out_.material.push_back(material);
        out_.uv.push_back(uv);
        return made;
    }

private:
    SurfaceLayout& out_;
    std::vector<std::uint32_t> first_, next_;
};

// Puts the triangles of each part together: opaque before clear, those without a texture first.
void join_parts(SurfaceLayout& out, const std::vector<std::vector<Triangle>>& triangles,
                const std::vector<SurfaceLayout::Part>& parts)
{
    for (const bool clear : {false, true}) {
        for (std::size_t k = 0; k < parts.size(); ++k) {
            if (parts[k].clear != clear || triangles[k].empty()) continue;
            out.parts.push_back(parts[k]);
            out.parts.back().count = triangles[k].size();
            out.triangles.insert(out.triangles.end(), triangles[k].begin(), triangles[k].end());
        }
    }
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
    std::vector<SurfaceLayout::Part> parts;
    const std::vector<std::size_t> part_of = parts_of(topology, parts);
    std::vector<std::vector<Triangle>> triangles(parts.size());
    DrawnVertices drawn(out, mesh.normals.size());
    for (std::size_t f = 0; f < faces; ++f) {
        const Triangle &t = topology.triangles[f], &n = topology.normal_triangles[f];
        const std::uint16_t m = topology.material.empty() ? std::uint16_t{0} : topology.material[f];
        const bool textured = m < part_of.size() && parts[part_of[m]].textured;
        const Triangle uv = textured ? topology.uv_triangles[f] : Triangle{none, none, none};
        if (!within(t, mesh.positions.size()) || !within(n, mesh.normals.size()) ||
            m >= part_of.size() || (textured && !within(uv, topology.uvs.size()))) {
            ++out.skipped;
            continue;
        }
        Triangle corners{};
        for (std::size_t k = 0; k < 3; ++k) corners[k] = drawn.number(n[k], t[k], m, uv[k]);
        if (wound_against_normals(mesh, t, n)) std::swap(corners[1], corners[2]);
        triangles[part_of[m]].push_back(corners);
    }
    join_parts(out, triangles, parts);
    if (parts.size() == 2) out.uv.clear();
    return out;
}

}  // namespace render
