#pragma once

// What aspic-assimp does. What is wrong with a file is an error in what is made; memory that runs
// out is std::bad_alloc.

#include "geometry/io/assimp/collada_lenses.hpp"
#include "geometry/io/assimp_messages.hpp"

#include <span>
#include <string>

struct aiScene;

namespace geometry::assimp {

// Everything that a file holds but its cameras, or these alone.
enum class Wanted { meshes, cameras };

// The mesh file at `path`. Files beside it that it names must lie below `root`, unless empty.
void read(const std::string& path, const std::string& root, Wanted wanted, ImportedScene& out);

// The cameras of a scene into `out`. It may be one of a glTF file, or of a COLLADA file with
// lenses.
void read_cameras(const aiScene& scene, bool gltf, std::span<const ColladaLens> lenses,
                  ImportedScene& out);

// The binary glTF file that descriptor `input` holds, with glb_polygons() after it or nothing, in
// the format that assimp calls `format`;
// files beside it are called `name`.
void write(int input, const std::string& format, const std::string& name, ExportedFiles& out);

}  // namespace geometry::assimp
