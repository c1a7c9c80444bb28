#include "geometry/io/import_scene.hpp"

#include <unistd.h>

#include <fstream>
#include <stdexcept>

namespace geometry {
namespace {

namespace fs = std::filesystem;

// Why a run gave no scene; empty when it did.
std::string why_no_scene(const LibraryRun& run, const ProcessLimits& limits)
{
    using End = LibraryRun::End;
    const std::string damaged = ": raise the limit, unless the file is damaged";
    const std::string export_again =
        "; try to open the file in a modelling program and to export it again, or as OBJ";
    switch (run.end) {
    case End::fine:
        return "";
    case End::out_of_memory:
        return "reading it takes more than " + shorter(limits.gigabytes) + " GiB of memory" +
               damaged;
    case End::out_of_time:
        return "reading it takes more than " + shorter(limits.seconds) + " s" + damaged;
    case End::gave_up:
        return "the importer failed: " + run.said + export_again;
    case End::crashed:
        return "the importer crashed (" + run.said +
               "): the file is damaged, or assimp does not support what is in it" + export_again;
    case End::not_understood:
        break;
    }
    return run.said;
}

}  // namespace

void want_mesh_file(const fs::path& path)
{
    std::error_code code;
    const fs::file_status status = fs::status(path, code);
    if (!fs::exists(status)) throw std::runtime_error("there is no file " + path.string());
    if (fs::is_directory(status)) {
        throw std::runtime_error(path.string() + " is a folder, expected a mesh file");
    }
    if (!fs::is_regular_file(status)) {
        throw std::runtime_error(path.string() + " is not a regular file");
    }
    if (::access(path.c_str(), R_OK) != 0) {
        throw std::runtime_error(path.string() + " cannot be read: permission denied");
    }
    if (fs::file_size(path, code) == 0) throw std::runtime_error(path.string() + " is empty");
}

std::string why_not_understood(const fs::path& path, const std::string& error)
{
    std::ifstream file(path, std::ios::binary);
    std::string begin;
    std::getline(file, begin);
    if (begin.starts_with("version https://git-lfs")) {
        return "is a pointer of Git LFS in place of the file: fetch the file with 'git lfs pull'";
    }
    if (error.find("No suitable reader found") != std::string::npos) {
        return "is of a format that is not read: export it as glTF, FBX, PLY or OBJ";
    }
    return "is damaged, or not of the format that its ending names: " + error;
}

namespace {

ImportedScene import_by(const char* job, const fs::path& path, const ImportOptions& options)
{
    want_mesh_file(path);
    ImportedScene scene;
    const LibraryRun run =
        run_library(assimp_program,
                    {job, fs::absolute(path).string(),
                     options.root.empty() ? "" : fs::absolute(options.root).string()},
                    {}, options.limits, options.check, [&](const char* bytes, std::size_t size) {
                        scene = unpack<ImportedScene>(bytes, size);
                    });
    if (const std::string why = why_no_scene(run, options.limits); !why.empty()) {
        throw std::runtime_error(path.string() + ": " + why);
    }
    return scene;
}

}  // namespace

ImportedScene import_scene(const fs::path& path, const ImportOptions& options)
{
    return import_by("read", path, options);
}

ImportedScene import_cameras(const fs::path& path, const ImportOptions& options)
{
    return import_by("cameras", path, options);
}

}  // namespace geometry
