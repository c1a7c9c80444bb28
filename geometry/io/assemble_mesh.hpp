#pragma once

// What a mesh file holds, made into one mesh.

#include "geometry/io/find_textures.hpp"
#include "geometry/io/read_options.hpp"

#include <span>

namespace geometry {

// The mesh of a scene that was read: vertices welded where their positions agree in every bit
// (with Weld::groups those of one group alone), instances placed, mirrored ones wound to face
// outwards still, groups named after the file's nodes. Faces that use a vertex which is not finite
// or not there, or one vertex twice, are left out with a warning, and so are lines, unless
// options.line_thickness makes tubes of them. Vertices that are welded have the colour and the
// attributes of the first of them. Without faces, the points. Throws std::runtime_error when
// nothing is left. `textures` are those of its materials. With vertices `of_file`, in its unit and
// axes, the mesh has these in their order (keep_file_vertices()).
ReadMesh assemble_mesh(const ImportedScene& scene, const ReadOptions& options = {},
                       const FoundTextures& textures = {}, std::span<const Vec3f> of_file = {});

}  // namespace geometry
