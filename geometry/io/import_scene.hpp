#pragma once

// A mesh file as assimp read it, before anything is made of it.

#include "geometry/io/assimp_messages.hpp"
#include "geometry/io/library_process.hpp"

#include <filesystem>
#include <functional>

namespace geometry {

struct ImportOptions {
    ProcessLimits limits;
    std::filesystem::path root;  // side files must lie below; empty: anywhere

    // Called now and then while waiting; what it throws ends the import.
    std::function<void()> check = [] {};
};

// What `path` holds; ImportedScene::error when assimp refused it. Throws std::runtime_error when
// the file cannot be opened, when assimp crashed on it or went beyond the limits, and when
// aspic-assimp is missing (run_library).
ImportedScene import_scene(const std::filesystem::path& path, const ImportOptions& options = {});

// What a file is whose scene has this error, for people: to follow its name.
std::string why_not_understood(const std::filesystem::path& path, const std::string& error);

// Its cameras alone, likewise.
ImportedScene import_cameras(const std::filesystem::path& path, const ImportOptions& options = {});

// Throws std::runtime_error unless `path` is a file that can be read and is not empty.
void want_mesh_file(const std::filesystem::path& path);

}  // namespace geometry
