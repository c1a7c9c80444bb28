#pragma once

// Surfaces covered with a checkered pattern, which shows how they stretch and how texture
// coordinates lie.

#include "render/scene.hpp"

namespace render {

// The topology of `mesh` with a checkered texture in place of its materials' colours and textures;
// roughness, metallic and opacity stay. Where all faces have texture coordinates, one unit of these
// has `per_unit` squares along each side. Other meshes are checkered in squares of `square` m where
// their vertices lie in `rest`, which must have as many: each face is seen along that axis of the
// world which it faces most, so that the squares are cut where faces turn by more than 45 degrees.
std::shared_ptr<const geometry::MeshTopology> checkered(const TriMesh& mesh, const TriMesh& rest,
                                                        double per_unit, double square);

}  // namespace render
