#pragma once

// Blocks of cubes that are torn, and what becomes of meshes in them.

#include "geometry/cubes/cubes.hpp"
#include "geometry/embed/cut_torn.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/mesh/mesh.hpp"

#include <Eigen/Geometry>

#include <optional>
#include <set>

namespace torn_blocks {

using namespace geometry;

inline Cubes block(const Vec3i& n, double size, const Vec3& origin)
{
    std::vector<Vec3i> cells;
    for (int z = 0; z < n.z(); ++z) {
        for (int y = 0; y < n.y(); ++y) {
            for (int x = 0; x < n.x(); ++x) cells.emplace_back(x, y, z);
        }
    }
    return solid_cubes(cells, size, {}, origin);
}

// Links between corners that `apart` says are apart.
template <class Apart>
std::vector<std::uint32_t> links_between(const Cubes& cubes, const Apart& apart)
{
    std::set<std::uint32_t> broken;
    for (const auto& corners : cubes.corners) {
        for (std::uint32_t a = 0; a < 8; ++a) {
            for (std::uint32_t d = 0; d < 3; ++d) {
                const std::uint32_t i = corners[a], j = corners[a | 1u << d];
                if (i != j && apart(cubes.corner[i], cubes.corner[j])) broken.insert(3 * i + d);
            }
        }
    }
    return {broken.begin(), broken.end()};
}

inline std::vector<std::uint32_t> links_across(const Cubes& cubes, int axis, int below)
{
    return links_between(cubes, [&](const Vec3i& a, const Vec3i& b) {
        return (a[axis] <= below) != (b[axis] <= below);
    });
}

inline TriMesh torn(const TriMesh& rest, const Cubes& cubes, const std::vector<Vec3>& x,
                    const std::vector<std::uint32_t>& broken, const Closing& closing = {})
{
    const auto parted = find_parted(cubes, broken);
    const Binding binding = bind(rest, cubes);
    TriMesh carried = embed(binding, rest, cubes, x, marked(cubes, parted));
    return cut_torn(binding, rest, std::move(carried), cubes, x, broken, parted, closing);
}

// Far enough for what is moved to be told from what is not.
inline const Transform turned = [] {
    Transform t = Transform::Identity();
    t.translate(Vec3(0.4, -0.2, 0.7));
    t.rotate(Eigen::AngleAxisd(1.3, Vec3(1, 2, -1).normalized()));
    return t;
}();

// The same as a solid, cut and closed.
inline TriMesh closed(const TriMesh& rest, const Cubes& cubes, const std::vector<Vec3>& x,
                      const std::vector<std::uint32_t>& broken,
                      const std::optional<Material>& material = {})
{
    const TriangleBvh solid(rest);
    return torn(rest, cubes, x, broken, {&solid, material});
}

inline double area(const TriMesh& mesh, std::size_t f)
{
    const auto& [a, b, c] = mesh.triangles()[f];
    const auto& p = mesh.positions;
    return 0.5 * double((p[b] - p[a]).cross(p[c] - p[a]).norm());
}

}  // namespace torn_blocks
