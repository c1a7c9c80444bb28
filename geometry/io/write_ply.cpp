// Binary PLY.

#include "geometry/base/no_index.hpp"
#include "geometry/base/srgb.hpp"
#include "geometry/io/file_bytes.hpp"
#include "geometry/io/read_ply.hpp"
#include "geometry/io/texture_files.hpp"
#include "geometry/io/write_mesh.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/polygons.hpp"

#include <algorithm>
#include <cmath>

namespace geometry {
namespace {

std::uint8_t byte_of(float x)
{
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.f, 1.f)));
}

void put_count(std::string& out, std::size_t count, bool is_long)
{
    if (is_long) {
        put_bytes(out, static_cast<std::uint32_t>(count));
    } else {
        put_bytes(out, static_cast<std::uint8_t>(count));
    }
}

// The one entry of each vertex, of its normals or texture coordinates; empty when some vertex has
// none or several.
std::vector<std::uint32_t> entry_of_vertex(const TriMesh& mesh,
                                           const std::vector<Triangle>& entries)
{
    const MeshTopology& t = *mesh.topology;
    std::vector<std::uint32_t> entry(mesh.positions.size(), no_index);
    for (std::size_t f = 0; f < entries.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            auto& n = entry[t.triangles[f][k]];
            if (n != no_index && n != entries[f][k]) return {};
            n = entries[f][k];
        }
    }
    if (std::find(entry.begin(), entry.end(), no_index) != entry.end()) return {};
    return entry;
}

// The names of attributes as those of properties: each once, and none that readers take for
// something else.
std::vector<std::string> property_names(const std::vector<Attribute>& attributes)
{
    std::vector<std::string> names;
    for (const Attribute& a : attributes) {
        std::string name = one_line(a.name, "value");
        for (char& c : name) c = c == ' ' ? '_' : c;
        while (has_meaning_in_ply(name) ||
               std::find(names.begin(), names.end(), name) != names.end()) {
            name += '_';
        }
        names.push_back(std::move(name));
    }
    return names;
}

const Material& material_of(const MeshTopology& t, std::size_t face)
{
    static const Material plain;
    if (t.materials.empty()) return plain;
    return t.materials[t.material.empty() ? 0 : t.material[face]];
}

struct PlyFaces {
    bool long_lists, long_coordinates;  // their counts take more than a byte
    bool seams, colours;
};

void put_faces(std::string& out, const MeshTopology& t, const Outlines& faces, const PlyFaces& has)
{
    for (std::size_t p = 0; p < faces.count(); ++p) {
        put_count(out, faces[p].size(), has.long_lists);
        for (const std::uint32_t corner : faces[p]) {
            put_bytes(out, t.triangles[corner / 3][corner % 3]);
        }
        if (has.seams) {
            put_count(out, 2 * faces[p].size(), has.long_coordinates);
            for (const std::uint32_t corner : faces[p]) {
                const Vec2f& uv = t.uvs[t.uv_triangles[corner / 3][corner % 3]];
                put_bytes(out, std::array{uv.x(), uv.y()});
            }
        }
        if (has.colours) {
            const Vec3f c = srgb_from_linear(material_of(t, faces.first_triangle(p)).colour);
            for (int d = 0; d < 3; ++d) put_bytes(out, byte_of(c[d]));
        }
    }
}

}  // namespace

std::string ply_bytes(const TriMesh& mesh, const FileFrame& frame)
{
    const MeshTopology& t = *mesh.topology;
    const std::vector<std::uint32_t> normal = entry_of_vertex(mesh, t.normal_triangles),
                                     uv = entry_of_vertex(mesh, t.uv_triangles);
    const bool normals = !mesh.normals.empty() && !normal.empty();
    const bool uvs = !t.uvs.empty() && !uv.empty();
    const bool seams = !t.uv_triangles.empty() && !uvs;  // then corners have their own
    const bool colours = !mesh.colours.empty();
    const bool face_colours = !colours && !t.materials.empty();

    std::string out = "ply\nformat binary_little_endian 1.0\ncomment " + own_header(frame) + "\n";
    if (const std::string texture = only_texture(t); !texture.empty()) {
        out += "comment TextureFile " + texture + "\n";
    }
    out += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
    out += "property float x\nproperty float y\nproperty float z\n";
    if (normals) out += "property float nx\nproperty float ny\nproperty float nz\n";
    if (uvs) out += "property float s\nproperty float t\n";
    const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (colours) out += rgb;
    for (const std::string& name : property_names(mesh.attributes)) {
        out += "property float " + name + "\n";
    }
    const Outlines faces = outlines(t);
    out += "element face " + std::to_string(faces.count()) + "\n";
    // All readers know counts of one byte.
    const std::size_t most = faces.most_corners();
    const PlyFaces lists{most > 255, 2 * most > 255, seams, face_colours};
    const auto list = [](bool is_long) {
        return std::string("property list ") + (is_long ? "uint" : "uchar");
    };
    out += list(lists.long_lists) + " uint vertex_indices\n";
    if (seams) out += list(lists.long_coordinates) + " float texcoord\n";
    if (face_colours) out += rgb;
    out += "end_header\n";

    out.reserve(out.size() + mesh.positions.size() * 36 + t.triangles.size() * 16);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        put_floats(out, mesh.positions[v]);
        if (normals) put_floats(out, mesh.normals[normal[v]]);
        if (uvs) put_bytes(out, std::array{t.uvs[uv[v]].x(), t.uvs[uv[v]].y()});
        if (colours) {
            const Vec3f c = srgb_from_linear(mesh.colours[v]);
            for (int d = 0; d < 3; ++d) put_bytes(out, byte_of(c[d]));
        }
        for (const Attribute& a : mesh.attributes) put_bytes(out, a.values[v]);
    }
    put_faces(out, t, faces, lists);
    return out;
}

}  // namespace geometry
