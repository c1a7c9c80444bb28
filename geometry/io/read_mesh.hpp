#pragma once

// Mesh files of every format that assimp reads, made into one clean TriMesh in metres, y up.

#include "geometry/io/read_options.hpp"

namespace geometry {

// The mesh in `path`, made from what the file holds as assemble_mesh() does. Throws
// std::runtime_error naming the file when no face and no point of it is usable, and what
// import_scene throws.
ReadMesh read_mesh(const std::filesystem::path& path, const ReadOptions& options = {});

}  // namespace geometry
