#pragma once

// Meshes that tests and benchmarks make in code.

#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"

#include <cmath>
#include <map>

namespace test_meshes {

using geometry::Triangle;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;

inline TriMesh mesh_of(std::vector<Vec3f> positions, std::vector<Triangle> triangles)
{
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = std::move(triangles);
    TriMesh mesh;
    mesh.topology = topology;
    mesh.positions = std::move(positions);
    return mesh;
}

// An icosahedron on the unit sphere, each triangle cut in four `levels` times: 20 * 4^levels.
inline TriMesh icosphere(int levels)
{
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::vector<Vec3> p{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                        {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    std::vector<Triangle> t{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                            {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                            {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                            {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (Vec3& v : p) v.normalize();
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, added] =
                middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(p.size()));
            if (added) p.push_back((p[a] + p[b]).normalized());
            return at->second;
        };
        std::vector<Triangle> finer;
        for (const auto& [a, b, c] : t) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        t = std::move(finer);
    }
    std::vector<Vec3f> positions;
    for (const Vec3& v : p) positions.push_back(v.cast<float>());
    return mesh_of(std::move(positions), std::move(t));
}

// A sphere with smooth bumps and dents, closed: 81,920 triangles at 6 levels.
inline TriMesh bumpy_sphere(int levels)
{
    TriMesh mesh = icosphere(levels);
    for (Vec3f& p : mesh.positions) {
        const Vec3 q = p.cast<double>();
        const double bump = 0.12 * std::sin(5 * q.x() + 1) * std::cos(4 * q.y()) +
                            0.08 * std::sin(9 * q.z() + 3 * q.x()) * std::cos(7 * q.y() + 2);
        p = (q * (1 + bump)).cast<float>();
    }
    return mesh;
}

// An axis-aligned box of 12 triangles.
inline TriMesh box(const Vec3& lo, const Vec3& hi)
{
    std::vector<Vec3f> p;
    for (int a = 0; a < 8; ++a) {
        p.push_back(
            Vec3((a & 1) ? hi.x() : lo.x(), (a & 2) ? hi.y() : lo.y(), (a & 4) ? hi.z() : lo.z())
                .cast<float>());
    }
    return mesh_of(std::move(p), {{0, 2, 3},
                                  {0, 3, 1},
                                  {4, 5, 7},
                                  {4, 7, 6},
                                  {0, 1, 5},
                                  {0, 5, 4},
                                  {2, 6, 7},
                                  {2, 7, 3},
                                  {0, 4, 6},
                                  {0, 6, 2},
                                  {1, 3, 7},
                                  {1, 7, 5}});
}

// Both meshes as one; nothing is welded.
inline TriMesh both(const TriMesh& a, const TriMesh& b)
{
    auto positions = a.positions;
    auto triangles = a.triangles();
    const auto shift = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), b.positions.begin(), b.positions.end());
    for (const auto& [i, j, k] : b.triangles()) {
        triangles.push_back({i + shift, j + shift, k + shift});
    }
    return mesh_of(std::move(positions), std::move(triangles));
}

// `count` triangles with corners anywhere in the unit cube: they overlap, cross and stand open.
inline TriMesh random_soup(std::uint32_t count, std::uint64_t seed, double size = 1)
{
    const geometry::Random random(seed);
    std::vector<Vec3f> p;
    std::vector<Triangle> t;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3 at(random.unit(12 * i), random.unit(12 * i + 1), random.unit(12 * i + 2));
        for (std::uint32_t k = 0; k < 3; ++k) {
            const Vec3 d(random.unit(12 * i + 3 + 3 * k), random.unit(12 * i + 4 + 3 * k),
                         random.unit(12 * i + 5 + 3 * k));
            p.push_back((at + size * (d - Vec3::Constant(0.5))).cast<float>());
        }
        t.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh_of(std::move(p), std::move(t));
}

// Every face turned round.
inline geometry::TriMesh inside_out(const geometry::TriMesh& mesh)
{
    auto triangles = mesh.triangles();
    for (auto& t : triangles) std::swap(t[1], t[2]);
    return mesh_of(mesh.positions, triangles);
}

}  // namespace test_meshes
