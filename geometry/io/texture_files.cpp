#include "geometry/io/texture_files.hpp"

#include "geometry/base/whole_file.hpp"
#include "geometry/io/file_bytes.hpp"

#include <fmt/format.h>

#include <map>

namespace geometry {
namespace {

namespace fs = std::filesystem;

std::string plain_name(const std::string& name)
{
    std::string plain = one_line(name, "texture.png");
    for (char& c : plain) c = c == ' ' || c == '/' || c == '\\' ? '_' : c;
    return plain;
}

// "wood.1f6e02a9.png", by the texture's content. A name that says so already, as in a file that was
// written here, stays as it is.
std::string file_name(const Texture& texture)
{
    const fs::path name = plain_name(texture.source().name);
    const std::string digest = fmt::format(".{:08x}", texture.digest() & 0xffffffffu);
    if (name.stem().string().ends_with(digest)) return name.string();
    return name.stem().string() + digest + name.extension().string();
}

bool holds(const fs::path& path, const std::string& bytes)
{
    std::error_code none;
    if (!fs::is_regular_file(path, none) || fs::file_size(path, none) != bytes.size()) return false;
    return read_whole_file(path) == bytes;
}

// Textures by the names that their files get.
using Files = std::map<std::string, const Texture*>;

std::string add_to(Files& files, const Texture* texture)
{
    if (!texture) return {};
    std::string name = file_name(*texture);
    files.try_emplace(name, texture);
    return name;
}

Files named(const MeshTopology& topology, TextureNames& names, bool normal_maps)
{
    Files files;
    for (const Material& m : topology.materials) {
        names.colour.push_back(add_to(files, m.texture.get()));
    }
    for (const Material& m : topology.materials) {
        if (normal_maps) names.normals.push_back(add_to(files, m.normal_map.get()));
    }
    return files;
}

}  // namespace

TextureNames texture_names(const MeshTopology& topology)
{
    TextureNames names;
    named(topology, names, true);
    return names;
}

std::string only_texture(const MeshTopology& topology)
{
    std::string only;
    const TextureNames names = texture_names(topology);
    for (const std::string& name : names.colour) {
        if (name.empty() || name == only) continue;
        if (!only.empty()) return {};
        only = name;
    }
    return only;
}

std::vector<fs::path> write_textures(const fs::path& folder, const MeshTopology& topology,
                                     bool normal_maps)
{
    TextureNames names;
    std::vector<fs::path> written;
    for (const auto& [name, texture] : named(topology, names, normal_maps)) {
        written.push_back(folder / name);
        const std::string& file = texture->source().file;
        if (!holds(written.back(), file)) write_whole_file(written.back(), file);
    }
    return written;
}

}  // namespace geometry
