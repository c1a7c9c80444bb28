#pragma once

// Textures as files beside a mesh file that names them.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/texture.hpp"

#include <filesystem>

namespace geometry {

// The names of each material's texture and normal map as files beside the mesh, empty where it has
// none. They hold a digest of the content, "wood.1f6e02a9.png": other meshes and frames write into
// the same folder, at the same time, textures that differ and are called alike. No name has a
// space, at which some readers stop.
struct TextureNames {
    std::vector<std::string> colour, normals;
};
TextureNames texture_names(const MeshTopology& topology);

// Of all materials the one texture's name; empty when they have none or several.
std::string only_texture(const MeshTopology& topology);

// Writes each texture, and each normal map where they are wanted, to `folder` by its name, and
// returns the paths. A file that holds the same
// bytes already is left alone: all frames of a shot name one file. Throws std::runtime_error as
// write_whole_file() does.
std::vector<std::filesystem::path> write_textures(const std::filesystem::path& folder,
                                                  const MeshTopology& topology, bool normal_maps);

}  // namespace geometry
