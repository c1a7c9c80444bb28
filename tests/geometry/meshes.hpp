#pragma once

// Meshes of many kinds, sound and broken, for tests that hold for all of them; and what is asked of
// every mesh.

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"

#include <gtest/gtest.h>

#include <map>

namespace meshes {

using geometry::TriMesh;

struct Specimen {
    std::string name;
    TriMesh mesh;
    bool closed = true;
};

// A mesh of triangles alone.
inline TriMesh soup(std::vector<geometry::Vec3f> positions,
                    std::vector<geometry::Triangle> triangles)
{
    TriMesh mesh;
    mesh.positions = std::move(positions);
    geometry::MeshTopology topology;
    topology.triangles = std::move(triangles);
    mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return mesh;
}

inline TriMesh moved(TriMesh mesh, const geometry::Vec3& by)
{
    geometry::move(mesh, geometry::placement(by, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}));
    return mesh;
}

inline TriMesh with_material(TriMesh mesh, geometry::Material material, std::string group)
{
    geometry::MeshTopology topology = *mesh.topology;
    topology.materials = {std::move(material)};
    topology.material.assign(topology.triangles.size(), 0);
    topology.groups = {std::move(group)};
    topology.group.assign(topology.triangles.size(), 0);
    mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return mesh;
}

inline std::vector<Specimen> sound()
{
    using namespace geometry;
    std::vector<Specimen> all{
        {"box", box({1, 2, 3}, {1, 1, 1})}, {"fine box", box({0.3, 0.2, 0.1}, {3, 2, 5})},
        {"icosphere", icosphere(0.7, 3)},   {"uv sphere", uv_sphere(2, 24, 12)},
        {"grid", grid(2, 1, 4, 3), false},  {"cylinder", cylinder(0.5, 2, 32, 3)},
        {"torus", torus(1, 0.3, 40, 16)},
    };
    const TriMesh red = with_material(box({1, 1, 1}, {2, 2, 2}), {"red", {0.8f, 0.1f, 0.05f}}, "a");
    const TriMesh glass = with_material(moved(icosphere(0.5, 2), {2, 0, 0}),
                                        {"glass", {0.2f, 0.6f, 0.9f}, 0.25f, 0.1f, 0.f}, "b");
    const std::array<const TriMesh*, 2> both{&red, &glass};
    all.push_back({"two materials", merge(both)});
    return all;
}

// Every index in range, every array of its right length or empty, every normal unit and of one
// vertex only, every number finite.
inline void expect_consistent(const TriMesh& mesh)
{
    const geometry::MeshTopology& t = *mesh.topology;
    const std::size_t faces = t.triangles.size();
    const auto within = [](const std::vector<geometry::Triangle>& triangles, std::size_t count) {
        for (const auto& triangle : triangles) {
            for (const auto v : triangle) {
                if (v >= count) return false;
            }
        }
        return true;
    };
    EXPECT_TRUE(within(t.triangles, mesh.positions.size()));
    EXPECT_TRUE(within(t.normal_triangles, mesh.normals.size()));
    EXPECT_TRUE(within(t.uv_triangles, t.uvs.size()));
    for (const std::size_t size : {t.normal_triangles.size(), t.uv_triangles.size(),
                                   t.material.size(), t.group.size(), t.polygon.size()}) {
        EXPECT_TRUE(size == 0 || size == faces);
    }
    for (std::size_t f = 0; f < t.polygon.size(); ++f) {
        const std::uint32_t next = f == 0 ? 0 : t.polygon[f - 1] + 1;
        ASSERT_TRUE(t.polygon[f] == next || (f > 0 && t.polygon[f] + 1 == next)) << f;
    }
    for (const auto m : t.material) ASSERT_LT(m, t.materials.size());
    for (const auto g : t.group) ASSERT_LT(g, t.groups.size());
    EXPECT_TRUE(mesh.colours.empty() || mesh.colours.size() == mesh.positions.size());
    for (const auto& a : mesh.attributes) EXPECT_EQ(a.values.size(), mesh.positions.size());
    for (const auto& p : mesh.positions) ASSERT_TRUE(p.allFinite());
    for (const auto& n : mesh.normals) ASSERT_NEAR(n.norm(), 1, 1e-5);  // float: a few ulps

    std::vector<std::int64_t> owner(mesh.normals.size(), -1);
    for (std::size_t f = 0; f < t.normal_triangles.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            auto& of = owner[t.normal_triangles[f][k]];
            ASSERT_TRUE(of < 0 || of == t.triangles[f][k]) << "a normal that two vertices share";
            of = t.triangles[f][k];
        }
    }
}

// Every edge is used once in each direction.
inline bool closed(const TriMesh& mesh)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
    for (const auto& t : mesh.triangles()) {
        for (std::size_t k = 0; k < 3; ++k) ++count[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [edge, n] : count) {
        const auto back = count.find({edge.second, edge.first});
        if (n != 1 || back == count.end() || back->second != 1) return false;
    }
    return true;
}

// The least dot product between a corner's normal and its face's.
inline double worst_normal(const TriMesh& mesh)
{
    double worst = 1;
    const auto& t = *mesh.topology;
    for (std::size_t f = 0; f < t.normal_triangles.size(); ++f) {
        const auto& p = mesh.positions;
        const auto& [a, b, c] = t.triangles[f];
        const geometry::Vec3f n = (p[b] - p[a]).cross(p[c] - p[a]).normalized();
        for (const auto i : t.normal_triangles[f]) {
            worst = std::min(worst, double(n.dot(mesh.normals[i])));
        }
    }
    return worst;
}

}  // namespace meshes
