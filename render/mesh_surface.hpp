#pragma once

// Meshes as things to draw: the attribute that colours them, clouds of points, and the edges of
// faces.

#include "render/scene.hpp"

namespace render {

// `mesh` with the attribute `displacement` (m): each vertex's distance from its place in `rest`.
// `mesh` itself where it has an attribute of that name, or where `rest` is null or has another
// number of vertices.
std::shared_ptr<const TriMesh> with_displacement(const std::shared_ptr<const TriMesh>& mesh,
                                                 const TriMesh* rest);

// The points of a mesh without faces as balls, painted as its surface would be. A cloud has no
// faces that could have a material: by material it shows its vertices' own colours.
Balls cloud_balls(const TriMesh& cloud, const Paint& paint, float radius);

// The edges of the mesh's faces, each once.
Lines edge_lines(const TriMesh& mesh);

}  // namespace render
