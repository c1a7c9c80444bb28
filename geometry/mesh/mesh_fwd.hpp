#pragma once

// Meshes by name, for headers that take or hold them by reference or pointer: few files need to
// know what a mesh is made of, and only these are compiled again when it changes.

#include "geometry/base/vec.hpp"

#include <memory>
#include <string>
#include <vector>

namespace geometry {

struct Attribute;
struct Material;
struct MeshTopology;
struct TriMesh;

// geometry/mesh/mesh.hpp says what it returns.
Box bounds(const TriMesh& mesh);

}  // namespace geometry
