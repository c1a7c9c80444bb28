#pragma once

// Which of several meshes are coloured by an attribute.

#include "geometry/mesh/mesh.hpp"
#include "graph/types/value.hpp"
#include "render/mesh_surface.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace nodes::render {

using Meshes = std::vector<graph::Wire<geometry::TriMesh>>;

inline bool has_attribute(const geometry::TriMesh& mesh, const std::string& name)
{
    return std::any_of(mesh.attributes.begin(), mesh.attributes.end(),
                       [&](const auto& a) { return a.name == name; });
}

inline bool any_has(const Meshes& meshes, const std::string& name)
{
    return std::any_of(meshes.begin(), meshes.end(),
                       [&](const auto& mesh) { return has_attribute(*mesh, name); });
}

// With their displacement from `rest` (which may be null) where they have as many vertices.
inline Meshes with_displacements(Meshes meshes, const geometry::TriMesh* rest)
{
    for (auto& mesh : meshes) mesh = ::render::with_displacement(mesh, rest);
    return meshes;
}

}  // namespace nodes::render
