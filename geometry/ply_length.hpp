#pragma once

#include <filesystem>
#include <string>

namespace geometry {

// Why the PLY file at `path` cannot be whole: its header announces more than follows. Empty when
// nothing speaks against it, or when its header is not understood. assimp takes such files and
// fills up with zeros.
std::string what_ply_lacks(const std::filesystem::path& path);

}  // namespace geometry
