// Binary glTF 2.0: a chunk of JSON that describes, and a chunk of numbers that it describes.
//   Khronos Group. glTF 2.0 Specification. 2021.

#include "geometry/base/no_index.hpp"
#include "geometry/base/numbering.hpp"
#include "geometry/io/file_bytes.hpp"
#include "geometry/io/write_mesh.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/texture.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <stdexcept>

namespace geometry {
namespace {

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
    // A whole file as a piece of the binary chunk; the piece's index.
    std::size_t add_file(const std::string& file)
    {
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", file.size()}});
        bin += file;
        bin.resize((bin.size() + 3) / 4 * 4);
        return json["bufferViews"].size() - 1;
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

// Index of the image in the file: equal ones are there once.
using Images = std::vector<const Texture*>;
std::size_t gltf_image(Gltf& gltf, Images& images, const Texture& texture)
{
    const Texture::Source& source = texture.source();
    for (std::size_t i = 0; i < images.size(); ++i) {
        if (images[i]->source().file == source.file) return i;
    }
    // glTF knows two kinds of picture.
    std::string type = media_type(texture), png;
    if (type != "image/png" && type != "image/jpeg") {
        png = encode_png(texture.picture());
        type = "image/png";
    }
    gltf.json["images"].push_back({{"name", std::filesystem::path(source.name).stem().string()},
                                   {"mimeType", type},
                                   {"bufferView", gltf.add_file(png.empty() ? source.file : png)}});
    images.push_back(&texture);
    return images.size() - 1;
}

std::size_t gltf_texture(Gltf& gltf, Images& images, const Texture& texture, const TextureUse& use)
{
    const auto wrap = [](TextureUse::Wrap w) {
        return w == TextureUse::Wrap::repeat ? 10497 : w == TextureUse::Wrap::clamp ? 33071 : 33648;
    };
    const std::size_t image = gltf_image(gltf, images, texture);
    gltf.json["samplers"].push_back(
        {{"magFilter", 9729}, {"minFilter", 9987}, {"wrapS", wrap(use.u)}, {"wrapT", wrap(use.v)}});
    gltf.json["textures"].push_back(
        {{"sampler", gltf.json["samplers"].size() - 1}, {"source", image}});
    return gltf.json["textures"].size() - 1;
}

nlohmann::json gltf_material(Gltf& gltf, Images& textures, const Material& m)
{
    nlohmann::json out{{"name", m.name},
                       {"doubleSided", true},
                       {"pbrMetallicRoughness",
                        {{"baseColorFactor", {m.colour.x(), m.colour.y(), m.colour.z(), m.opacity}},
                         {"metallicFactor", m.metallic},
                         {"roughnessFactor", m.roughness}}}};
    if (m.opacity < 1) out["alphaMode"] = "BLEND";
    if (m.normal_map) {
        out["normalTexture"] = {{"index", gltf_texture(gltf, textures, *m.normal_map, m.use)},
                                {"scale", m.bump}};
    }
    if (!m.texture) return out;
    out["pbrMetallicRoughness"]["baseColorTexture"] = {
        {"index", gltf_texture(gltf, textures, *m.texture, m.use)}};
    if (m.use.alpha == TextureUse::Alpha::blended) out["alphaMode"] = "BLEND";
    if (m.use.alpha == TextureUse::Alpha::cutout) {
        out["alphaMode"] = "MASK";
        out["alphaCutoff"] = m.use.cutoff;
    }
    return out;
}

// The faces of one primitive. glTF has one index a corner, so a vertex with several normals or
// texture coordinates is written several times.
nlohmann::json gltf_primitive(Gltf& gltf, const TriMesh& mesh,
                              const std::vector<std::uint32_t>& faces)
{
    const MeshTopology& t = *mesh.topology;
    Numbering<3> corners(faces.size());
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * faces.size());
    for (const auto f : faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            indices.push_back(
                corners.add({t.triangles[f][k],
                             t.normal_triangles.empty() ? no_index : t.normal_triangles[f][k],
                             t.uv_triangles.empty() ? no_index : t.uv_triangles[f][k]}));
        }
    }
    std::vector<Vec3f> positions, normals, colours;
    std::vector<Vec2f> uvs;
    for (const auto& [v, n, uv] : corners.keys()) {
        positions.push_back(mesh.positions[v]);
        if (n != no_index) normals.push_back(mesh.normals[n]);
        if (uv != no_index)
            uvs.emplace_back(t.uvs[uv].x(), 1 - t.uvs[uv].y());  // v runs down there
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
        throw std::invalid_argument("glTF needs at least one point, and the mesh has none");
    }
    Gltf gltf;
    gltf.json["asset"] = {{"version", "2.0"}, {"generator", "Aspic"}};
    gltf.json["scene"] = 0;
    Images images;
    for (const Material& m : t.materials) {
        gltf.json["materials"].push_back(gltf_material(gltf, images, m));
    }

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
        throw std::invalid_argument("a GLB file is limited to 4096 MiB, and this mesh needs " +
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

std::string glb_polygons(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    std::string out;
    if (t.polygon.size() != t.triangles.size()) return out;
    const Outlines faces = outlines(t);
    std::vector<std::size_t> outline_at(t.triangles.size(), faces.count());  // of first triangles
    for (std::size_t p = 0; p < faces.count(); ++p) outline_at[faces.first_triangle(p)] = p;
    const auto put = [](std::string& to, std::size_t number) {
        put_bytes(to, static_cast<std::uint32_t>(number));
    };
    for (const auto& look : faces_by_look(t)) {
        std::string list;
        std::size_t count = 0;
        for (std::size_t i = 0; i < look.second.size(); ++i) {
            const std::size_t f = look.second[i], p = outline_at[f];
            if (p == faces.count()) continue;
            ++count;
            put(list, faces[p].size());
            // The triangles of a polygon follow each other in the primitive too.
            for (const std::uint32_t corner : faces[p]) put(list, corner - 3 * f + 3 * i);
        }
        put(out, count);
        out += list;
    }
    return out;
}

}  // namespace geometry
