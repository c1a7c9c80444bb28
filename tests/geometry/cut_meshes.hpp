#pragma once

// Meshes with an opening.

#include "tests/geometry/test_meshes.hpp"

#include <vector>

namespace test_meshes {

// Without the faces whose middle lies above a height.
inline geometry::TriMesh cut_above(const geometry::TriMesh& mesh, float height)
{
    std::vector<geometry::Triangle> left;
    for (const auto& t : mesh.triangles()) {
        float sum = 0;
        for (const auto v : t) sum += mesh.positions[v].y();
        if (sum < 3 * height) left.push_back(t);
    }
    return mesh_of(mesh.positions, left);
}

}  // namespace test_meshes
