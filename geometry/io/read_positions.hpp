#pragma once

// The vertices of a file by their numbers, for what must keep them: neither welded nor left out.

#include "geometry/base/vec.hpp"

#include <filesystem>
#include <vector>

namespace geometry {

// The positions that a file lists, in its order: the vertices of a .ply, the `v` lines of an .obj,
// the points of an .xyz, .pts or .asc, or those of a .pc2 at frame `frame`. Single precision.
// Throws std::runtime_error naming the file: when it cannot be read, when its ending is another,
// and when a point cache has no such frame or one that nobody has written.
std::vector<Vec3f> read_positions(const std::filesystem::path& path, int frame);

}  // namespace geometry
