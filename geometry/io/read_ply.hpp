#pragma once

// Reads PLY files.

#include "geometry/io/import_scene.hpp"

#include <string_view>

namespace geometry {

// The PLY file whose bytes these are (text, or binary of either byte order): vertices with normals,
// colours and texture coordinates, faces and triangle strips; further numbers of vertices become
// attributes; lists and other elements are passed over. Read here because assimp 5.2 loses the
// first bytes of binary data that look like line ends, and fills truncated files up with zeros.
// Turk. The PLY polygon file format. Stanford University, 1994. Throws std::runtime_error saying
// what is wrong with a file that is cut short or no PLY.
ImportedScene read_ply(std::string_view bytes);

// Whether read_ply() takes a property of this name for a position, normal, colour or texture
// coordinate.
bool has_meaning_in_ply(std::string_view name);

}  // namespace geometry
