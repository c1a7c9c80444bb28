#pragma once

// Cubes as things to draw.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh.hpp"
#include "render/scene.hpp"
#include "render/surface_layout.hpp"

#include <span>

namespace render {

// The cubes that can be seen, and how they turn into triangles and lines: the same for all frames.
// A cube with a neighbour on each of its six sides is hidden by them.
struct CubeShell {
    std::vector<std::uint32_t> cube;                   // S, into Cubes: those to draw
    std::vector<std::array<std::uint32_t, 8>> corner;  // S, their corners
    std::vector<std::array<std::uint32_t, 2>> edge;    // corners, each edge once
    std::size_t corners = 0;                           // of all cubes
    // Of the triangles: 8 vertices a cube, 3 normals a vertex, all hard edges.
    std::shared_ptr<const geometry::MeshTopology> topology;
    std::shared_ptr<const SurfaceLayout> layout;
};
CubeShell cube_shell(const geometry::Cubes& cubes);

// The cubes of the shell with their corners at `x`, each shrunk about its centre to `scale` of its
// size, so that they can be told apart. Normals are those of each side's diagonals.
// Throws std::invalid_argument when there are not as many positions as corners.
TriMesh solid_cubes(const CubeShell& shell, std::span<const Vec3> x, float scale);

// The edges of the cubes of the shell.
Lines cube_lines(const CubeShell& shell, std::span<const Vec3> x);

}  // namespace render
