#pragma once

// Meshes as things to draw: the attribute that colours them, and the edges of their faces.

#include "render/scene.hpp"

namespace render {

// `mesh` with the attribute `displacement` (m): each vertex's distance from its place in `rest`.
// `mesh` itself where it has an attribute of that name, or where `rest` is null or has another
// number of vertices.
std::shared_ptr<const TriMesh> with_displacement(const std::shared_ptr<const TriMesh>& mesh,
                                                 const TriMesh* rest);

// The edges of the mesh's faces, each once.
Lines edge_lines(const TriMesh& mesh);

}  // namespace render
