#pragma once

// The pictures that a mesh file's materials name: looked for beside it, and read.

#include "geometry/io/assimp_messages.hpp"
#include "geometry/mesh/texture.hpp"

#include <filesystem>

namespace geometry {

struct FoundTextures {
    // M, of the scene's materials: null where one has none, or none that can be read.
    std::vector<std::shared_ptr<const Texture>> of_material;
    std::vector<TextureUse> use;                              // M
    std::vector<std::shared_ptr<const Texture>> normal_maps;  // M, likewise
    std::vector<std::string> warnings;                        // each a sentence
    std::vector<std::filesystem::path> side_files;            // that were opened or looked for
};

// Where a picture that a model in `folder` names may lie, best first: at its path, and by its name
// alone in that folder and in `textures` below it.
std::vector<std::filesystem::path> picture_places(const std::string& named,
                                                  const std::filesystem::path& folder);

// Paths are taken from the folder of `model`. Pictures are looked for in picture_places(). Side
// files must lie below `root`, unless that is empty. Materials that name one file share one
// texture.
FoundTextures find_textures(const ImportedScene& scene, const std::filesystem::path& model,
                            const std::filesystem::path& root);

}  // namespace geometry
