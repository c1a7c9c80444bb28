#include "geometry/io/export_mesh.hpp"

#include "geometry/base/whole_file.hpp"
#include "geometry/io/assimp_messages.hpp"

#include <stdexcept>

namespace geometry {
namespace {

namespace fs = std::filesystem;

// By what assimp 5.2 calls it. Its FBX is the one in text: what it writes in binary it does not
// read.
const char* assimp_name(MeshFormat format)
{
    switch (format) {
    case MeshFormat::obj:
        return "obj";
    case MeshFormat::ply:
        return "plyb";
    case MeshFormat::stl:
        return "stlb";
    case MeshFormat::glb:
        return "glb2";
    case MeshFormat::gltf:
        return "gltf2";
    case MeshFormat::dae:
        return "collada";
    case MeshFormat::fbx:
        return "fbxa";
    case MeshFormat::x3d:
        return "x3d";
    }
    throw std::invalid_argument("no such mesh format");
}

bool holds_polygons(MeshFormat format)
{
    return format != MeshFormat::stl && format != MeshFormat::glb && format != MeshFormat::gltf;
}

// Why a run gave no files; empty when it did.
std::string why_no_files(const LibraryRun& run, const ProcessLimits& limits)
{
    using End = LibraryRun::End;
    const std::string instead = ": write the mesh as OBJ, PLY or GLB, which need no assimp";
    switch (run.end) {
    case End::fine:
        return "";
    case End::out_of_memory:
        return "assimp needs more than " + shorter(limits.gigabytes) + " GiB of memory" + instead;
    case End::out_of_time:
        return "assimp needs more than " + shorter(limits.seconds) + " s" + instead;
    case End::gave_up:
    case End::crashed:
        return "assimp failed (" + run.said + ")" + instead;
    case End::not_understood:
        break;
    }
    return run.said;
}

}  // namespace

std::vector<fs::path> export_mesh(const fs::path& path, MeshFormat format, const TriMesh& mesh,
                                  const ProcessLimits& limits, const std::function<void()>& check)
{
    ExportedFiles made;
    // Of an OBJ assimp takes what follows the last dot for an ending.
    const fs::path whole = path.extension() == ".mtl" ? path.filename() : path.stem();
    const std::string name =
        format == MeshFormat::obj ? whole.string() + ".obj" : path.stem().string();
    std::string given = glb_bytes(mesh);
    if (holds_polygons(format)) given += glb_polygons(mesh);
    const LibraryRun run = run_library(
        assimp_program, {"write", assimp_name(format), name}, given, limits, check,
        [&](const char* bytes, std::size_t size) { made = unpack<ExportedFiles>(bytes, size); });
    std::string why = why_no_files(run, limits);
    if (why.empty() && !made.error.empty()) why = "assimp refused the mesh: " + made.error;
    if (why.empty() && made.files.empty()) why = "assimp made no file";
    if (!why.empty()) throw std::runtime_error("could not write " + path.string() + ": " + why);

    // What it names first, so that it never names what is not there.
    std::vector<fs::path> beside;
    for (std::size_t i = 1; i < made.files.size(); ++i) {
        beside.push_back(path.parent_path() / fs::path(made.files[i].name).filename());
        write_whole_file(beside.back(), made.files[i].bytes);
    }
    write_whole_file(path, made.files[0].bytes);
    return beside;
}

}  // namespace geometry
