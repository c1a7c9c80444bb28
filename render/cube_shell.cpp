#include "render/cube_shell.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/plane.hpp"

#include <algorithm>
#include <stdexcept>

namespace render {
namespace {

using geometry::Triangle;

// Corners of each side, counter-clockwise from outside; see geometry::Cubes for their numbers.
constexpr std::array<std::array<std::uint32_t, 4>, 6> sides = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

// The side of a cube by its lowest and highest corner: the cube on the other side names it alike.
std::uint64_t side_key(const std::array<std::uint32_t, 8>& corners, std::size_t side)
{
    const auto [low, high] = std::minmax_element(sides[side].begin(), sides[side].end());
    return std::uint64_t{corners[*low]} << 32 | corners[*high];
}

constexpr std::size_t corners_a_task = 1024;

void check(const CubeShell& shell, std::span<const Vec3> x)
{
    if (x.size() != shell.corners) {
        throw std::invalid_argument("cubes with " + std::to_string(shell.corners) +
                                    " corners cannot be drawn at " + std::to_string(x.size()) +
                                    " positions: state and cubes do not belong together");
    }
}

std::shared_ptr<const geometry::MeshTopology> cube_topology(std::size_t cubes)
{
    auto out = std::make_shared<geometry::MeshTopology>();
    out->triangles.reserve(12 * cubes);
    out->normal_triangles.reserve(12 * cubes);
    for (std::uint32_t c = 0; c < cubes; ++c) {
        for (std::uint32_t side = 0; side < 6; ++side) {
            for (const std::array<std::uint32_t, 3>& half :
                 {std::array<std::uint32_t, 3>{0, 1, 2}, {0, 2, 3}}) {
                Triangle t{}, n{};
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t a = sides[side][half[k]];
                    t[k] = 8 * c + a;
                    n[k] = 24 * c + 3 * a + side / 2;  // a vertex has one side along each axis
                }
                out->triangles.push_back(t);
                out->normal_triangles.push_back(n);
            }
        }
    }
    return out;
}

}  // namespace

CubeShell cube_shell(const geometry::Cubes& cubes)
{
    const std::size_t count = cubes.count();
    std::vector<std::uint64_t> keys(6 * count);
    for (std::size_t c = 0; c < count; ++c) {
        for (std::size_t side = 0; side < 6; ++side) {
            keys[6 * c + side] = side_key(cubes.corners[c], side);
        }
    }
    std::sort(keys.begin(), keys.end());
    const bool flat = geometry::flat_axis(cubes) >= 0;
    const auto open = [&](std::size_t c) {
        if (flat) return true;
        for (std::size_t side = 0; side < 6; ++side) {
            const auto [first, last] =
                std::equal_range(keys.begin(), keys.end(), side_key(cubes.corners[c], side));
            if (last - first < 2) return true;
        }
        return false;
    };

    CubeShell shell;
    shell.corners = cubes.corner_count();
    for (std::size_t c = 0; c < count; ++c) {
        if (!open(c)) continue;
        shell.cube.push_back(static_cast<std::uint32_t>(c));
        shell.corner.push_back(cubes.corners[c]);
        for (std::uint32_t a = 0; a < 8; ++a) {
            for (const std::uint32_t bit : {1u, 2u, 4u}) {
                if ((a & bit) == 0) {
                    shell.edge.push_back({cubes.corners[c][a], cubes.corners[c][a | bit]});
                }
            }
        }
    }
    std::sort(shell.edge.begin(), shell.edge.end());
    shell.edge.erase(std::unique(shell.edge.begin(), shell.edge.end()), shell.edge.end());

    shell.topology = cube_topology(shell.cube.size());
    TriMesh mesh = solid_cubes(shell, geometry::corner_positions(cubes), 1);
    shell.layout = std::make_shared<const SurfaceLayout>(surface_layout(mesh));
    return shell;
}

TriMesh solid_cubes(const CubeShell& shell, std::span<const Vec3> x, float scale)
{
    check(shell, x);
    TriMesh mesh;
    mesh.topology = shell.topology;
    mesh.positions.resize(8 * shell.cube.size());
    mesh.normals.resize(24 * shell.cube.size());
    geometry::parallel_for(
        shell.cube.size(), corners_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                std::array<Vec3, 8> p;
                Vec3 centre = Vec3::Zero();
                for (std::size_t a = 0; a < 8; ++a) centre += p[a] = x[shell.corner[c][a]];
                centre /= 8;
                for (std::size_t a = 0; a < 8; ++a) {
                    mesh.positions[8 * c + a] =
                        (centre + double(scale) * (p[a] - centre)).cast<float>();
                }
                for (std::size_t side = 0; side < 6; ++side) {
                    const auto& s = sides[side];
                    const Vec3 n = (p[s[2]] - p[s[0]]).cross(p[s[3]] - p[s[1]]);
                    const double length = n.norm();
                    const Vec3f unit =
                        length > 0 ? Vec3f((n / length).cast<float>()) : Vec3f(Vec3f::UnitY());
                    for (const auto a : s) mesh.normals[24 * c + 3 * a + side / 2] = unit;
                }
            }
        });
    return mesh;
}

Lines cube_lines(const CubeShell& shell, std::span<const Vec3> x)
{
    check(shell, x);
    Lines lines;
    lines.ends.reserve(2 * shell.edge.size());
    for (const auto& edge : shell.edge) {
        for (const auto i : edge) lines.ends.push_back(x[i].cast<float>());
    }
    return lines;
}

}  // namespace render
