#include "geometry/io/write_mesh.hpp"

#include "geometry/base/whole_file.hpp"
#include "geometry/io/texture_files.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <stdexcept>

namespace geometry {

namespace fs = std::filesystem;

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
    throw std::invalid_argument("the ending of " + path.string() +
                                " names no format that is written: expected .obj, .ply, .stl, "
                                ".glb, .gltf, .dae, .fbx, .x3d or .pc2");
}

std::vector<fs::path> write_mesh(const fs::path& path, MeshFormat format, const TriMesh& mesh,
                                 const FileFrame& frame)
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
            // What it names first, so that it never names what is not there.
            for (const fs::path& file : write_textures(path.parent_path(), *mesh.topology, true)) {
                beside.push_back(file);
            }
            write_whole_file(beside[0], materials);
        }
        write_whole_file(path, obj_text(mesh, library, frame));
        break;
    }
    case MeshFormat::ply:
        if (!only_texture(*mesh.topology).empty()) {
            beside = write_textures(path.parent_path(), *mesh.topology, false);
        }
        write_whole_file(path, ply_bytes(mesh, frame));
        break;
    case MeshFormat::stl:
        write_whole_file(path, stl_bytes(mesh, frame));
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
