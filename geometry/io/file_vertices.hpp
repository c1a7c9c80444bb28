#pragma once

// The vertices of a file in its order, as other programs number them when they read it: a point
// cache has to have one point for each.

#include "geometry/base/vec.hpp"

#include <span>
#include <string_view>
#include <vector>

namespace geometry {

struct TriMesh;

// The positions of an OBJ's lines `v`, in the file's unit. Throws std::runtime_error on a line that
// does not begin with three numbers.
std::vector<Vec3f> obj_vertices(std::string_view text);

// Gives the mesh the vertices `of_file`, all of them and in that order. Faces use the first of
// those at one place; colours and attributes go with the place, those of vertices elsewhere are
// white and 0. A vertex of the mesh is that of the file which is nearest, within 1e-6 of what the
// file spans. With `apart`, vertices of the mesh at one place stay apart, each with one of the
// file, in order. Throws std::runtime_error where the mesh has a vertex that the file has not, and
// where the file has another number of vertices at the place of several that stay apart.
void keep_file_vertices(TriMesh& mesh, std::span<const Vec3f> of_file, bool apart = false);

}  // namespace geometry
