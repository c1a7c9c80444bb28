#pragma once

// Meshes as files of the formats that assimp writes. It runs in a process of its own and is given
// the mesh as binary glTF, so it writes what that holds: positions, normals, texture coordinates,
// colours, groups and materials, but no other attributes; and its polygons, where the format has
// any.

#include "geometry/io/library_process.hpp"
#include "geometry/io/write_mesh.hpp"

namespace geometry {

// Writes `mesh` to `path`, and beside it the files that it names, which are returned: of
// "a.0001.obj" its materials, "a.0001.mtl", and of a glTF its numbers, "a.0001.bin". Each appears
// whole or not at all; missing folders are made. `check` is called now and then while waiting; what
// it throws ends the writing. Throws std::runtime_error saying what could not be written and
// std::invalid_argument when the format cannot hold the mesh.
std::vector<std::filesystem::path> export_mesh(
    const std::filesystem::path& path, MeshFormat format, const TriMesh& mesh,
    const ProcessLimits& limits = {}, const std::function<void()>& check = [] {});

}  // namespace geometry
