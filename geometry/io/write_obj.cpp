// Wavefront OBJ and its material library.

#include "geometry/base/parallel.hpp"
#include "geometry/base/srgb.hpp"
#include "geometry/io/file_bytes.hpp"
#include "geometry/io/texture_files.hpp"
#include "geometry/io/write_mesh.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/polygons.hpp"

#include <charconv>
#include <map>
#include <set>

namespace geometry {
namespace {

template <class Number> void put(std::string& out, Number x)
{
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, x).ptr;
    out.append(text, end);
}

// item(out, i) for all i of 0..n, made in parallel, joined in order.
template <class Item> void put_all(std::string& out, std::size_t n, const Item& item)
{
    constexpr std::size_t grain = 8192;
    std::vector<std::string> pieces((n + grain - 1) / grain);
    parallel_for(pieces.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            pieces[k].reserve(32 * grain);
            for (std::size_t i = k * grain; i < std::min(n, (k + 1) * grain); ++i) {
                item(pieces[k], i);
            }
        }
    });
    std::size_t size = out.size();
    for (const std::string& p : pieces) size += p.size();
    out.reserve(size);
    for (const std::string& p : pieces) out += p;
}

template <class V> void put_vector(std::string& out, const V& v)
{
    for (int d = 0; d < v.size(); ++d) {
        out += ' ';
        put(out, v[d]);
    }
}

// Where two are the same the second "m" becomes "m.1", or "m.2" where another one is called that.
std::vector<std::string> told_apart(std::vector<std::string> names)
{
    std::set<std::string> taken(names.begin(), names.end());
    std::map<std::string, int> used;
    for (std::string& name : names) {
        int number = used[name]++;
        if (number == 0) continue;
        const std::string plain = name + ".";
        while (!taken.insert(plain + std::to_string(number)).second) ++number;
        name = plain + std::to_string(number);
    }
    return names;
}

std::vector<std::string> material_names(const MeshTopology& t)
{
    std::vector<std::string> names;
    for (const Material& m : t.materials) {
        std::string& name = names.emplace_back(one_line(m.name, "default"));
        for (char& c : name) c = c == ' ' ? '_' : c;  // some readers stop at a space
    }
    return told_apart(std::move(names));
}

std::vector<std::string> group_names(const MeshTopology& t)
{
    std::vector<std::string> names;
    for (const std::string& g : t.groups) names.push_back(one_line(g, "default"));
    return told_apart(std::move(names));
}

}  // namespace

std::string obj_text(const TriMesh& mesh, const std::string& library, const FileFrame& frame)
{
    const MeshTopology& t = *mesh.topology;
    std::string out = "# " + own_header(frame) + "\n";
    if (!library.empty() && !t.materials.empty()) out += "mtllib " + library + "\n";
    put_all(out, mesh.positions.size(), [&](std::string& line, std::size_t i) {
        line += 'v';
        put_vector(line, mesh.positions[i]);
        if (!mesh.colours.empty()) put_vector(line, srgb_from_linear(mesh.colours[i]));
        line += '\n';
    });
    put_all(out, mesh.normals.size(), [&](std::string& line, std::size_t i) {
        line += "vn";
        put_vector(line, mesh.normals[i]);
        line += '\n';
    });
    put_all(out, t.uvs.size(), [&](std::string& line, std::size_t i) {
        line += "vt";
        put_vector(line, t.uvs[i]);
        line += '\n';
    });
    if (t.triangles.empty()) {
        put_all(out, mesh.positions.size(), [](std::string& line, std::size_t i) {
            line += "p ";
            put(line, i + 1);
            line += '\n';
        });
        return out;
    }

    // A face's line, after the lines that change the group or the material.
    const std::vector<std::string> names = material_names(t), groups = group_names(t);
    const Outlines faces = outlines(t);
    put_all(out, faces.count(), [&](std::string& line, std::size_t p) {
        const std::size_t f = faces.first_triangle(p);
        if (!t.group.empty() && (f == 0 || t.group[f] != t.group[f - 1])) {
            line += "o " + groups[t.group[f]] + "\n";
        }
        if (!names.empty() &&
            (f == 0 || (!t.material.empty() && t.material[f] != t.material[f - 1]))) {
            line += "usemtl " + names[t.material.empty() ? 0 : t.material[f]] + "\n";
        }
        line += 'f';
        for (const std::uint32_t corner : faces[p]) {
            const std::uint32_t of = corner / 3, k = corner % 3;
            line += ' ';
            put(line, t.triangles[of][k] + 1);
            if (t.normal_triangles.empty() && t.uv_triangles.empty()) continue;
            line += '/';
            if (!t.uv_triangles.empty()) put(line, t.uv_triangles[of][k] + 1);
            if (t.normal_triangles.empty()) continue;
            line += '/';
            put(line, t.normal_triangles[of][k] + 1);
        }
        line += '\n';
    });
    return out;
}

std::string mtl_text(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    const std::vector<std::string> names = material_names(t);
    const TextureNames textures = texture_names(t);
    std::string out;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const Material& m = t.materials[i];
        // The Blinn-Phong exponent of the same highlight, for readers without roughness.
        const float alpha = std::max(m.roughness * m.roughness, 1e-3f);
        out += "newmtl " + names[i] + "\nKd";
        put_vector(out, srgb_from_linear(m.colour));
        out += "\nd ";
        put(out, m.opacity);
        out += "\nNs ";
        put(out, std::min(2 / (alpha * alpha) - 2, 1000.f));
        out += "\nPr ";
        put(out, m.roughness);
        out += "\nPm ";
        put(out, m.metallic);
        const std::string clamp = m.use.u == TextureUse::Wrap::clamp ? " -clamp on " : " ";
        if (!textures.colour[i].empty()) {
            const std::string file = clamp + textures.colour[i];
            out += "\nmap_Kd" + file;
            if (m.use.alpha != TextureUse::Alpha::ignored) out += "\nmap_d" + file;
        }
        // Blender takes map_Bump for a normal map and knows no norm; others take it for heights,
        // unless there is a norm.
        for (const char* word : {"\nnorm", "\nmap_Bump"}) {
            if (textures.normals[i].empty()) break;
            out += word;
            if (m.bump != 1) {
                out += " -bm ";
                put(out, m.bump);
            }
            out += clamp + textures.normals[i];
        }
        out += "\n\n";
    }
    return out;
}

}  // namespace geometry
