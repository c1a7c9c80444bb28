#include "geometry/io/find_textures.hpp"

#include "geometry/base/whole_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

namespace geometry {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 30;  // bytes

// As files are named here: "..\wood%20old.png" is "../wood old.png".
std::string plain_path(std::string path)
{
    std::replace(path.begin(), path.end(), '\\', '/');
    if (path.starts_with("file://")) path.erase(0, 7);
    return path;
}

std::string without_escapes(const std::string& path)
{
    std::string out;
    const auto digit = [](char c) {
        return c >= '0' && c <= '9'                 ? c - '0'
               : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 87
                                                    : -1;
    };
    for (std::size_t i = 0; i < path.size(); ++i) {
        const bool escape = path[i] == '%' && i + 2 < path.size() && digit(path[i + 1]) >= 0 &&
                            digit(path[i + 2]) >= 0;
        out += escape ? static_cast<char>(16 * digit(path[i + 1]) + digit(path[i + 2])) : path[i];
        if (escape) i += 2;
    }
    return out;
}

bool allowed(const fs::path& path, const fs::path& root)
{
    std::error_code none;
    if (!fs::is_regular_file(path, none) || fs::file_size(path, none) > largest_file) return false;
    if (root.empty()) return true;
    const fs::path top = fs::weakly_canonical(root), real = fs::weakly_canonical(path);
    return std::mismatch(top.begin(), top.end(), real.begin(), real.end()).first == top.end();
}

// The textures while they are found.
struct Search {
    const ImportedScene& scene;
    fs::path folder, root;
    std::map<std::string, std::shared_ptr<const Texture>> known;  // by path
    std::map<const Texture*, TextureUse::Alpha> alpha;
    FoundTextures out;

    void warn(const ImportedMaterial& m, const ImportedPicture& p, const std::string& what)
    {
        out.warnings.push_back(
            fmt::format("material \"{}\" is drawn {}: {}.", m.name,
                        &p == &m.normals ? "without its normal map" : "in its plain colour", what));
    }
};

// `p` is one of the material's pictures.
std::optional<Texture::Source> source_of(Search& search, const ImportedMaterial& m,
                                         const ImportedPicture& p)
{
    if (p.embedded >= 0 && std::size_t(p.embedded) < search.scene.embedded.size()) {
        const EmbeddedPicture& e = search.scene.embedded[std::size_t(p.embedded)];
        return Texture::Source{e.name, e.file};
    }
    bool outside = false;
    for (const fs::path& place : picture_places(p.path, search.folder)) {
        search.out.side_files.push_back(place);
        if (!allowed(place, search.root)) {
            outside = outside || allowed(place, {});
            continue;
        }
        if (auto bytes = read_whole_file(place)) {
            return Texture::Source{place.filename().string(), std::move(*bytes)};
        }
    }
    search.warn(m, p,
                "its picture " + plain_path(p.path) +
                    (outside ? " lies outside of the project; put the file beside the model, or "
                               "allow it by --root or --allow-outside"
                             : " cannot be opened; put the file beside the model, or correct its "
                               "path in the material"));
    return std::nullopt;
}

std::shared_ptr<const Texture> texture_of(Search& search, const ImportedMaterial& m,
                                          const ImportedPicture& p)
{
    if (p.path.empty()) return nullptr;
    const auto known = search.known.find(p.path);
    if (known != search.known.end() && known->second) return known->second;
    std::shared_ptr<const Texture>& texture = search.known[p.path];
    auto source = source_of(search, m, p);
    if (!source) return nullptr;
    const std::string name = source->name;
    try {
        auto made = std::make_shared<const Texture>(std::move(*source));
        // All of it is read now, so that a damaged one is told of here.
        search.alpha[made.get()] = alpha_of(made->picture());
        texture = std::move(made);
    } catch (const std::runtime_error& error) {
        search.warn(
            m, p, fmt::format("its picture {} {}; convert it to PNG or JPEG", name, error.what()));
    }
    return texture;
}

// What OBJ calls a bump map holds heights, or normals: its pixels tell. Null where it is not used.
std::shared_ptr<const Texture> normal_map_of(Search& search, const ImportedMaterial& m)
{
    const ImportedPicture& p = m.normals;
    if (p.path.empty()) return nullptr;
    if (m.normals_elsewhere) {
        search.warn(m, p,
                    "it lies at other texture coordinates than the picture of the colour; use one "
                    "UV map and one placement for both");
        return nullptr;
    }
    auto texture = texture_of(search, m, p);
    if (!texture) return nullptr;
    const std::string& name = texture->source().name;
    const PictureOf told = told_by(texture->picture());
    if (told == PictureOf::heights) {  // of whatever name: COLLADA knows bumps only
        search.warn(m, p,
                    fmt::format("its bump map {} has heights; bake a normal map of it", name));
        return nullptr;
    }
    if (told == PictureOf::normals || !m.bump_map) return texture;
    search.warn(m, p,
                fmt::format("whether its bump map {} has heights or normals cannot be told; if it "
                            "has normals, name it as a normal map (norm in an .mtl, or glTF)",
                            name));
    return nullptr;
}

TextureUse use_of(Search& search, const ImportedMaterial& m, const Texture* texture)
{
    using Alpha = ImportedMaterial::Alpha;
    TextureUse use;
    const auto& wrap = m.picture.path.empty() ? m.normals.wrap : m.picture.wrap;
    use.u = static_cast<TextureUse::Wrap>(std::min<int>(wrap[0], 2));
    use.v = static_cast<TextureUse::Wrap>(std::min<int>(wrap[1], 2));
    use.cutoff = std::clamp(m.cutoff, 0.f, 1.f);
    if (!texture) return use;
    use.alpha = m.alpha == Alpha::unsaid ? search.alpha[texture]
                                         : static_cast<TextureUse::Alpha>(int(m.alpha) - 1);
    return use;
}

// glTF 2.0 multiplies a picture by the colours of vertices (COLOR_0). White ones change nothing.
void warn_of_vertex_colours(Search& search)
{
    if (!search.scene.linear_colours) return;  // it is no glTF
    std::set<std::uint32_t> tinted;
    for (const ImportedMesh& mesh : search.scene.meshes) {
        const bool white = std::all_of(mesh.colours.begin(), mesh.colours.end(),
                                       [](const Vec3f& c) { return (c.array() > 0.998f).all(); });
        if (!white) tinted.insert(mesh.material);
    }
    for (const std::uint32_t m : tinted) {
        if (m >= search.scene.materials.size()) continue;
        const ImportedMaterial& material = search.scene.materials[m];
        if (material.picture.path.empty()) continue;
        search.out.warnings.push_back(fmt::format("material \"{}\": the vertex colours that "
                                                  "multiply its picture are not used; multiply "
                                                  "the picture by them instead.",
                                                  material.name));
    }
}

// Sentences about what materials have and nothing here uses.
void warn_of_unused(Search& search)
{
    warn_of_vertex_colours(search);
    for (const ImportedMaterial& m : search.scene.materials) {
        if (m.picture.turned) {
            search.out.warnings.push_back(fmt::format("material \"{}\": the turn of its picture is "
                                                      "not used, nor are the scale and offset that "
                                                      "it has; apply them to the texture "
                                                      "coordinates instead.",
                                                      m.name));
        }
        const fs::path mask = fs::path(plain_path(m.opacity_picture)).filename();
        if (mask.empty() || mask == fs::path(plain_path(m.picture.path)).filename()) continue;
        search.out.warnings.push_back(fmt::format(
            "material \"{}\": its picture {} of opacity is not used; put the opacity into the "
            "alpha of the picture that holds the colour.",
            m.name, mask.string()));
    }
}

}  // namespace

std::vector<fs::path> picture_places(const std::string& named, const fs::path& folder)
{
    std::vector<fs::path> all;
    const std::string plain = plain_path(named);
    for (const std::string& path : {plain, without_escapes(plain)}) {
        const fs::path asked(path), name = asked.filename();
        // The same object where `path` is absolute.
        for (const fs::path& place : {folder / asked, folder / name, folder / "textures" / name}) {
            const fs::path clean = place.lexically_normal();
            if (std::find(all.begin(), all.end(), clean) == all.end()) all.push_back(clean);
        }
    }
    return all;
}

FoundTextures find_textures(const ImportedScene& scene, const fs::path& model, const fs::path& root)
{
    Search search{scene, fs::absolute(model).parent_path(), root, {}, {}, {}};
    for (const ImportedMaterial& m : scene.materials) {
        const auto texture = texture_of(search, m, m.picture);
        search.out.of_material.push_back(texture);
        search.out.normal_maps.push_back(normal_map_of(search, m));
        search.out.use.push_back(use_of(search, m, texture.get()));
    }
    warn_of_unused(search);
    return std::move(search.out);
}

}  // namespace geometry
