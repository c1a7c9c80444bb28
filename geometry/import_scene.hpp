#pragma once

// A mesh file as assimp read it, before anything is made of it. assimp runs in a process of its
// own, aspic-import, under limits of memory and time: some damaged files make it abort, crash,
// allocate or loop without end, and then only that process is lost.

#include "geometry/vec.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace geometry {

struct ImportedMesh {
    std::string name;
    std::uint32_t material = 0;         // into ImportedScene::materials
    std::vector<Vec3f> positions;       // V, in the file's unit; not welded, maybe not finite
    std::vector<Vec3f> normals;         // V or 0
    std::vector<Vec3f> colours;         // V or 0, as the file has them
    std::vector<Vec2f> uvs;             // V or 0
    std::vector<Triangle> triangles;    // into positions, not yet checked
    std::vector<std::uint32_t> points;  // vertices that the file calls points
    std::uint64_t lines = 0;            // line segments left out
};

struct ImportedMaterial {
    std::string name;
    Vec3f colour{0.7f, 0.7f, 0.7f};  // as the file has it
    float opacity = 1, roughness = 0.6f, metallic = 0;
};

// One use of a mesh in the file's tree of nodes.
struct ImportedNode {
    std::string name;
    std::uint32_t mesh = 0;
    std::array<double, 12> to_world{};  // rows of a 3 x 4 matrix
};

struct ImportedFile {
    std::string path;
    bool found = false;
};

struct ImportedScene {
    std::vector<ImportedMesh> meshes;
    std::vector<ImportedMaterial> materials;
    std::vector<ImportedNode> nodes;
    bool linear_colours = false;  // else they are display values, sRGB
    double unit = 0;              // m, of one unit of length; 0 when the file does not say
    bool has_axes = false;        // whether the file says which axis is up
    std::array<double, 9> to_y_up{1, 0, 0, 0, 1, 0, 0, 0, 1};  // rows, when it says so
    std::vector<ImportedFile> files;  // that were opened or looked for, the mesh file first
    std::string error;                // why nothing was read; empty on success
};

struct ImportLimits {
    double seconds = 120;
    double gigabytes = 8;  // of the importing process, 2^30 bytes each
};

struct ImportOptions {
    ImportLimits limits;
    std::filesystem::path root;  // side files must lie below; empty: anywhere

    // Called now and then while waiting; what it throws ends the import.
    std::function<void()> check = [] {};
};

// What `path` holds; ImportedScene::error when assimp refused it. Throws std::runtime_error when
// the file cannot be opened, when the importer crashed or went beyond its limits, and when
// aspic-import is missing: it is looked for at $ASPIC_IMPORT, beside the running program, and
// one folder above it.
ImportedScene import_scene(const std::filesystem::path& path, const ImportOptions& options = {});

// Throws std::runtime_error unless `path` is a file that can be read and is not empty.
void want_mesh_file(const std::filesystem::path& path);

// What travels between the two processes.
std::string pack(const ImportedScene& scene);

// Throws std::runtime_error unless `bytes` is exactly what pack() makes of some scene.
ImportedScene unpack(const char* bytes, std::size_t size);

}  // namespace geometry
