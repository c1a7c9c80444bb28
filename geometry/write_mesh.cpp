#include "geometry/write_mesh.hpp"

#include "geometry/colour.hpp"
#include "geometry/distinct.hpp"
#include "geometry/parallel.hpp"
#include "geometry/whole_file.hpp"

#include <nlohmann/json.hpp>

#include <charconv>
#include <map>
#include <stdexcept>

namespace geometry {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t unset = ~std::uint32_t{0};

// ---- text ---------------------------------------------------------------------------------------

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

// A name as a line of text holds it.
std::string one_line(const std::string& name, const char* otherwise)
{
    std::string out;
    for (const char c : name) out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    const auto first = out.find_first_not_of(' ');
    if (first == std::string::npos) return otherwise;
    return out.substr(first, out.find_last_not_of(' ') - first + 1);
}

// Names of materials, told apart where two are the same.
std::vector<std::string> material_names(const MeshTopology& t)
{
    std::vector<std::string> names;
    std::map<std::string, int> used;
    for (const Material& m : t.materials) {
        std::string name = one_line(m.name, "default");
        for (char& c : name) c = c == ' ' ? '_' : c;  // some readers stop at a space
        const int before = used[name]++;
        names.push_back(before == 0 ? name : name + "." + std::to_string(before));
    }
    return names;
}

// ---- binary -------------------------------------------------------------------------------------

template <class T> void put_bytes(std::string& out, const T& value)
{
    static_assert(std::is_trivially_copyable_v<T>);
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void put_floats(std::string& out, const Vec3f& v)
{
    out.append(reinterpret_cast<const char*>(v.data()), 12);
}

std::uint8_t byte_of(float x)
{
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.f, 1.f)));
}

// The one normal of each vertex; empty when some vertex has none or several.
std::vector<std::uint32_t> normal_of_vertex(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    std::vector<std::uint32_t> normal(mesh.positions.size(), unset);
    for (std::size_t f = 0; f < t.normal_triangles.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            auto& n = normal[t.triangles[f][k]];
            if (n != unset && n != t.normal_triangles[f][k]) return {};
            n = t.normal_triangles[f][k];
        }
    }
    if (std::find(normal.begin(), normal.end(), unset) != normal.end()) return {};
    return normal;
}

const Material& material_of(const MeshTopology& t, std::size_t face)
{
    static const Material plain;
    if (t.materials.empty()) return plain;
    return t.materials[t.material.empty() ? 0 : t.material[face]];
}

// Faces that share group and material, in order of group, then material.
std::map<std::pair<std::uint16_t, std::uint16_t>, std::vector<std::uint32_t>>
faces_by_look(const MeshTopology& t)
{
    std::map<std::pair<std::uint16_t, std::uint16_t>, std::vector<std::uint32_t>> faces;
    for (std::uint32_t f = 0; f < t.triangles.size(); ++f) {
        faces[{t.group.empty() ? std::uint16_t(0) : t.group[f],
               t.material.empty() ? std::uint16_t(0) : t.material[f]}]
            .push_back(f);
    }
    return faces;
}

}  // namespace

std::string obj_text(const TriMesh& mesh, const std::string& library)
{
    const MeshTopology& t = *mesh.topology;
    std::string out = "# Aspic: metres, y up\n";
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
    const std::vector<std::string> names = material_names(t);
    put_all(out, t.triangles.size(), [&](std::string& line, std::size_t f) {
        if (!t.group.empty() && (f == 0 || t.group[f] != t.group[f - 1])) {
            line += "o " + one_line(t.groups[t.group[f]], "default") + "\n";
        }
        if (!names.empty() &&
            (f == 0 || (!t.material.empty() && t.material[f] != t.material[f - 1]))) {
            line += "usemtl " + names[t.material.empty() ? 0 : t.material[f]] + "\n";
        }
        line += 'f';
        for (std::size_t k = 0; k < 3; ++k) {
            line += ' ';
            put(line, t.triangles[f][k] + 1);
            if (t.normal_triangles.empty() && t.uv_triangles.empty()) continue;
            line += '/';
            if (!t.uv_triangles.empty()) put(line, t.uv_triangles[f][k] + 1);
            if (t.normal_triangles.empty()) continue;
            line += '/';
            put(line, t.normal_triangles[f][k] + 1);
        }
        line += '\n';
    });
    return out;
}

std::string mtl_text(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    const std::vector<std::string> names = material_names(t);
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
        out += "\n\n";
    }
    return out;
}

std::string ply_bytes(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    const std::vector<std::uint32_t> normal = normal_of_vertex(mesh);
    const bool normals = !mesh.normals.empty() && !normal.empty();
    const bool colours = !mesh.colours.empty();
    const bool face_colours = !colours && !t.materials.empty();

    std::string out = "ply\nformat binary_little_endian 1.0\ncomment Aspic: metres, y up\n";
    out += "element vertex " + std::to_string(mesh.positions.size()) + "\n";
    out += "property float x\nproperty float y\nproperty float z\n";
    if (normals) out += "property float nx\nproperty float ny\nproperty float nz\n";
    const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (colours) out += rgb;
    for (const Attribute& a : mesh.attributes) {
        std::string name = one_line(a.name, "value");
        for (char& c : name) c = c == ' ' ? '_' : c;
        out += "property float " + name + "\n";
    }
    out += "element face " + std::to_string(t.triangles.size()) + "\n";
    out += "property list uchar uint vertex_indices\n";
    if (face_colours) out += rgb;
    out += "end_header\n";

    out.reserve(out.size() + mesh.positions.size() * 36 + t.triangles.size() * 16);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        put_floats(out, mesh.positions[v]);
        if (normals) put_floats(out, mesh.normals[normal[v]]);
        if (colours) {
            const Vec3f c = srgb_from_linear(mesh.colours[v]);
            for (int d = 0; d < 3; ++d) put_bytes(out, byte_of(c[d]));
        }
        for (const Attribute& a : mesh.attributes) put_bytes(out, a.values[v]);
    }
    for (std::size_t f = 0; f < t.triangles.size(); ++f) {
        put_bytes(out, std::uint8_t(3));
        put_bytes(out, t.triangles[f]);
        if (face_colours) {
            const Vec3f c = srgb_from_linear(material_of(t, f).colour);
            for (int d = 0; d < 3; ++d) put_bytes(out, byte_of(c[d]));
        }
    }
    return out;
}

std::string stl_bytes(const TriMesh& mesh)
{
    const auto& triangles = mesh.triangles();
    if (triangles.empty()) {
        throw std::invalid_argument("an STL file holds faces only, and the mesh has none: write "
                                    "points as PLY, OBJ or GLB");
    }
    std::string out = "Aspic: metres, y up";
    out.resize(80, ' ');
    put_bytes(out, static_cast<std::uint32_t>(triangles.size()));
    out.reserve(84 + 50 * triangles.size());
    for (const auto& [a, b, c] : triangles) {
        const Vec3f &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        const Vec3 n = (q - p).cast<double>().cross((r - p).cast<double>());
        const double length = n.norm();
        put_floats(out, length > 0 ? Vec3f((n / length).cast<float>()) : Vec3f(Vec3f::Zero()));
        put_floats(out, p);
        put_floats(out, q);
        put_floats(out, r);
        put_bytes(out, std::uint16_t(0));
    }
    return out;
}

// ---- glTF ---------------------------------------------------------------------------------------

namespace {

// The two chunks of a GLB while they grow.
struct Gltf {
    nlohmann::json json;
    std::string bin;

    // A piece of the binary chunk as an accessor; its index.
    template <class T>
    std::size_t add(const std::vector<T>& values, int component_type, const char* type,
                    std::size_t per_value, int target)
    {
        json["bufferViews"].push_back({{"buffer", 0},
                                       {"byteOffset", bin.size()},
                                       {"byteLength", values.size() * sizeof(T)},
                                       {"target", target}});
        bin.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                     {"componentType", component_type},
                                     {"count", values.size() / per_value},
                                     {"type", type}});
        return json["accessors"].size() - 1;
    }
    std::size_t add_floats(const std::vector<Vec3f>& values)
    {
        return add(values, 5126, "VEC3", 1, 34962);
    }
    std::size_t add_positions(const std::vector<Vec3f>& values)
    {
        const std::size_t index = add_floats(values);
        Vec3f lo = values.at(0), hi = lo;
        for (const Vec3f& p : values) {
            lo = lo.cwiseMin(p);
            hi = hi.cwiseMax(p);
        }
        json["accessors"][index]["min"] = {lo.x(), lo.y(), lo.z()};
        json["accessors"][index]["max"] = {hi.x(), hi.y(), hi.z()};
        return index;
    }
};

nlohmann::json gltf_material(const Material& m)
{
    nlohmann::json out{{"name", m.name},
                       {"doubleSided", true},
                       {"pbrMetallicRoughness",
                        {{"baseColorFactor", {m.colour.x(), m.colour.y(), m.colour.z(), m.opacity}},
                         {"metallicFactor", m.metallic},
                         {"roughnessFactor", m.roughness}}}};
    if (m.opacity < 1) out["alphaMode"] = "BLEND";
    return out;
}

// The faces of one primitive. glTF has one index a corner, so a vertex with several normals or
// texture coordinates is written several times.
nlohmann::json gltf_primitive(Gltf& gltf, const TriMesh& mesh,
                              const std::vector<std::uint32_t>& faces)
{
    const MeshTopology& t = *mesh.topology;
    Distinct<3> corners(faces.size());
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * faces.size());
    for (const auto f : faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            indices.push_back(corners.add(
                {t.triangles[f][k], t.normal_triangles.empty() ? unset : t.normal_triangles[f][k],
                 t.uv_triangles.empty() ? unset : t.uv_triangles[f][k]}));
        }
    }
    std::vector<Vec3f> positions, normals, colours;
    std::vector<Vec2f> uvs;
    for (const auto& [v, n, uv] : corners.keys()) {
        positions.push_back(mesh.positions[v]);
        if (n != unset) normals.push_back(mesh.normals[n]);
        if (uv != unset) uvs.emplace_back(t.uvs[uv].x(), 1 - t.uvs[uv].y());  // v runs down there
        if (!mesh.colours.empty()) colours.push_back(mesh.colours[v]);
    }
    nlohmann::json attributes{{"POSITION", gltf.add_positions(positions)}};
    if (!normals.empty()) attributes["NORMAL"] = gltf.add_floats(normals);
    if (!uvs.empty()) attributes["TEXCOORD_0"] = gltf.add(uvs, 5126, "VEC2", 1, 34962);
    if (!colours.empty()) attributes["COLOR_0"] = gltf.add_floats(colours);
    nlohmann::json out{{"attributes", attributes},
                       {"indices", gltf.add(indices, 5125, "SCALAR", 1, 34963)}};
    if (!t.materials.empty()) out["material"] = t.material.empty() ? 0 : t.material[faces[0]];
    return out;
}

}  // namespace

std::string glb_bytes(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    if (mesh.positions.empty()) {
        throw std::invalid_argument("a glTF file holds at least one point, and the mesh has none");
    }
    Gltf gltf;
    gltf.json["asset"] = {{"version", "2.0"}, {"generator", "Aspic"}};
    gltf.json["scene"] = 0;
    for (const Material& m : t.materials) gltf.json["materials"].push_back(gltf_material(m));

    const auto add_node = [&](const std::string& name, nlohmann::json primitives) {
        gltf.json["scenes"][0]["nodes"].push_back(gltf.json["nodes"].size());
        gltf.json["nodes"].push_back({{"name", name}, {"mesh", gltf.json["meshes"].size()}});
        gltf.json["meshes"].push_back({{"name", name}, {"primitives", std::move(primitives)}});
    };
    if (t.triangles.empty()) {
        nlohmann::json attributes{{"POSITION", gltf.add_positions(mesh.positions)}};
        if (!mesh.colours.empty()) attributes["COLOR_0"] = gltf.add_floats(mesh.colours);
        add_node("points", {{{"attributes", attributes}, {"mode", 0}}});
    }
    const auto by_look = faces_by_look(t);
    for (auto at = by_look.begin(); at != by_look.end();) {
        const std::uint16_t group = at->first.first;
        auto primitives = nlohmann::json::array();
        for (; at != by_look.end() && at->first.first == group; ++at) {
            primitives.push_back(gltf_primitive(gltf, mesh, at->second));
        }
        add_node(t.groups.empty() ? "mesh" : t.groups[group], std::move(primitives));
    }
    gltf.json["buffers"].push_back({{"byteLength", gltf.bin.size()}});

    std::string json = gltf.json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t size = 12 + 8 + json.size() + 8 + gltf.bin.size();
    if (size > 0xffff'ffffu) {
        throw std::invalid_argument("a GLB file holds at most 4 GiB, this mesh needs " +
                                    std::to_string(size >> 20) + " MiB: write it as PLY");
    }
    std::string out = "glTF";
    out.reserve(size);
    for (const std::size_t word : {std::size_t{2}, size, json.size(), std::size_t{0x4E4F534A}}) {
        put_bytes(out, static_cast<std::uint32_t>(word));
    }
    out += json;
    put_bytes(out, static_cast<std::uint32_t>(gltf.bin.size()));
    put_bytes(out, std::uint32_t{0x004E4942});
    return out + gltf.bin;
}

bool is_written_here(MeshFormat format)
{
    return format <= MeshFormat::glb;
}

MeshFormat mesh_format(const fs::path& path)
{
    constexpr std::array<const char*, 8> endings{".obj",  ".ply", ".stl", ".glb",
                                                 ".gltf", ".dae", ".fbx", ".x3d"};
    std::string ending = path.extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const auto at = std::find(endings.begin(), endings.end(), ending);
    if (at != endings.end()) return static_cast<MeshFormat>(at - endings.begin());
    throw std::invalid_argument("cannot tell the format of " + path.string() +
                                " from its ending: .obj, .ply, .stl, .glb, .gltf, .dae, .fbx, .x3d "
                                "and .pc2 are written");
}

std::vector<fs::path> write_mesh(const fs::path& path, MeshFormat format, const TriMesh& mesh)
{
    std::vector<fs::path> beside;
    switch (format) {
    case MeshFormat::obj: {
        const std::string materials = mtl_text(mesh);
        std::string library;
        if (!materials.empty()) {
            library =
                (path.extension() == ".mtl" ? path.filename() : path.stem()).string() + ".mtl";
            beside.push_back(path.parent_path() / library);
            write_whole_file(beside[0], materials);
        }
        write_whole_file(path, obj_text(mesh, library));
        break;
    }
    case MeshFormat::ply:
        write_whole_file(path, ply_bytes(mesh));
        break;
    case MeshFormat::stl:
        write_whole_file(path, stl_bytes(mesh));
        break;
    case MeshFormat::glb:
        write_whole_file(path, glb_bytes(mesh));
        break;
    default:
        throw std::invalid_argument("only assimp writes this mesh format");
    }
    return beside;
}

}  // namespace geometry
