#include "geometry/io/read_mesh.hpp"

#include "geometry/io/assemble_mesh.hpp"
#include "geometry/io/file_vertices.hpp"
#include "geometry/io/own_header.hpp"
#include "geometry/io/read_ply.hpp"
#include "geometry/io/read_points.hpp"
#include "geometry/mesh/mesh.hpp"

#include <cctype>
#include <fstream>
#include <optional>
#include <set>
#include <stdexcept>

namespace geometry {
namespace {

bool ends_in(const std::filesystem::path& path, const char* wanted)
{
    std::string ending = path.extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending == wanted;
}

bool is_ply(const std::filesystem::path& path)
{
    return ends_in(path, ".ply");
}

std::string bytes_of(const std::filesystem::path& path)
{
    want_mesh_file(path);
    std::ifstream in(path, std::ios::binary);
    std::string bytes(std::filesystem::file_size(path), '\0');
    in.read(bytes.data(), std::ssize(bytes));
    if (!in) throw std::runtime_error(path.string() + " could not be read to its end");
    return bytes;
}

ImportedScene scene_read_here(const std::filesystem::path& path)
{
    const std::string bytes = bytes_of(path);
    try {
        return is_ply(path) ? read_ply(bytes) : read_points(bytes);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path.string() + ": " + error.what());
    }
}

// The unit and axis that our own OBJ, PLY and STL state in a comment.
void add_own_header(const std::filesystem::path& path, ImportedScene& scene)
{
    if (scene.unit > 0 || scene.has_axes) return;
    std::string bytes(160, '\0');
    std::ifstream(path, std::ios::binary).read(bytes.data(), std::ssize(bytes));
    const std::optional<FileFrame> frame = frame_of_header(bytes);
    if (!frame) return;
    scene.unit = frame->unit;
    scene.has_axes = true;
    if (frame->z_up) scene.to_y_up = {1, 0, 0, 0, 0, 1, 0, -1, 0};
}

// The vertices whose order is to be kept; none, where it is not.
std::vector<Vec3f> vertices_to_keep(const std::filesystem::path& path, const ImportedScene& scene,
                                    const ReadOptions& options)
{
    if (!options.keep_order) return {};
    if (is_ply(path) || is_points_file(path)) {
        return scene.meshes.empty() ? std::vector<Vec3f>{} : scene.meshes.front().own_positions();
    }
    if (ends_in(path, ".obj")) return obj_vertices(bytes_of(path));
    throw std::runtime_error(
        "the order of vertices is known of OBJ and PLY alone: export it as one "
        "of these, or set keep_order = false");
}

// Each file once that was looked for and never found, seen from the model's folder. One that is not
// where it should be is looked for in other folders too, and by names that nobody gave: without its
// extension, with the model's own name, or by some letters out of the middle of its path.
std::vector<std::string> files_not_found(const std::vector<ImportedFile>& files,
                                         const std::filesystem::path& model)
{
    const std::filesystem::path folder = std::filesystem::absolute(model).parent_path();
    std::set<std::string> known;
    std::string paths;  // of those that are missing
    for (const ImportedFile& f : files) {
        if (f.found) known.insert(std::filesystem::path(f.path).filename());
    }
    std::vector<std::string> missing;
    for (const ImportedFile& f : files) {
        const auto asked = std::filesystem::path(f.path).lexically_normal();
        const std::string ending = asked.extension(), name = asked.lexically_proximate(folder);
        const bool guess = ending.empty() || ending == "." || asked.stem() == model.stem() ||
                           paths.find("/" + name) != std::string::npos;
        if (f.found || (guess && !missing.empty())) continue;
        if (!known.insert(asked.filename()).second) continue;
        missing.push_back(name);
        paths += asked.string() + "\n";
    }
    return missing;
}

}  // namespace

ReadMesh read_mesh(const std::filesystem::path& path, const ReadOptions& options)
{
    const bool here = is_ply(path) || is_points_file(path);
    ImportedScene scene = here ? scene_read_here(path) : import_scene(path, options.import);
    if (!scene.error.empty()) {
        throw std::runtime_error(path.string() + " " + why_not_understood(path, scene.error));
    }
    add_own_header(path, scene);
    try {
        FoundTextures textures = find_textures(scene, path, options.import.root);
        ReadMesh out =
            assemble_mesh(scene, options, textures, vertices_to_keep(path, scene, options));
        out.side_files = std::move(textures.side_files);
        out.converted_unit = ends_in(path, ".dae");
        const std::string itself = std::filesystem::absolute(path).string();
        for (const ImportedFile& f : scene.files) {
            if (f.path == itself) continue;
            out.side_files.push_back(f.path);
        }
        for (const std::string& name : files_not_found(scene.files, path)) {
            out.warnings.push_back(
                "the file refers to " + name +
                ", which cannot be opened. Put it there, as seen from the file's folder, or allow "
                "it by --root or --allow-outside where it lies outside of the project.");
        }
        const auto warn = [&](const std::vector<std::string>& more) {
            out.warnings.insert(out.warnings.end(), more.begin(), more.end());
        };
        warn(textures.warnings);
        warn(scene.warnings);
        return out;
    } catch (const std::runtime_error& error) {
        std::string text = path.string() + ": " + error.what();
        for (const std::string& w : scene.warnings) text += " " + w;
        throw std::runtime_error(text);
    }
}

}  // namespace geometry
