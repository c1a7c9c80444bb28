#include "geometry/io/texture_files.hpp"

#include "geometry/base/whole_file.hpp"
#include "geometry/io/file_bytes.hpp"

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

// "wood.png" as the second of its name: "wood.1.png".
std::string numbered(const fs::path& name, int number)
{
    if (number == 0) return name.string();
    return name.stem().string() + "." + std::to_string(number) + name.extension().string();
}

bool holds(const fs::path& path, const std::string& bytes)
{
    std::error_code none;
    if (!fs::is_regular_file(path, none) || fs::file_size(path, none) != bytes.size()) return false;
    return read_whole_file(path) == bytes;
}

// The textures by the names that their files get.
std::map<std::string, const Texture*> named(const MeshTopology& topology,
                                            std::vector<std::string>& names)
{
    std::map<std::string, const Texture*> files;
    for (const Material& m : topology.materials) {
        std::string& name = names.emplace_back();
        for (int number = 0; m.texture && name.empty(); ++number) {
            const std::string wanted = numbered(plain_name(m.texture->source().name), number);
            const auto [at, is_new] = files.try_emplace(wanted, m.texture.get());
            if (is_new || at->second->source().file == m.texture->source().file) name = wanted;
        }
    }
    return files;
}

}  // namespace

std::vector<std::string> texture_names(const MeshTopology& topology)
{
    std::vector<std::string> names;
    named(topology, names);
    return names;
}

std::string only_texture(const MeshTopology& topology)
{
    std::string only;
    for (const std::string& name : texture_names(topology)) {
        if (name.empty() || name == only) continue;
        if (!only.empty()) return {};
        only = name;
    }
    return only;
}

std::vector<fs::path> write_textures(const fs::path& folder, const MeshTopology& topology)
{
    std::vector<std::string> names;
    std::vector<fs::path> written;
    for (const auto& [name, texture] : named(topology, names)) {
        written.push_back(folder / name);
        const std::string& file = texture->source().file;
        if (!holds(written.back(), file)) write_whole_file(written.back(), file);
    }
    return written;
}

}  // namespace geometry
