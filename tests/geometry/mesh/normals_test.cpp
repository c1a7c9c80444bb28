#include "geometry/mesh/normals.hpp"

#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace {

using namespace geometry;
using std::numbers::pi;

TEST(Normals, ACreaseBelowARightAngleKeepsABoxHard)
{
    TriMesh mesh = box({1, 2, 3}, {2, 2, 2});
    const TriMesh exact = mesh;
    compute_normals(mesh, 0.7);
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.normals.size(), exact.normals.size());
    EXPECT_GT(meshes::worst_normal(mesh), 1 - 1e-6);
}

TEST(Normals, SmoothedABoxCornerPointsAlongTheDiagonal)
{
    // Angle weights count each of the three sides of a corner with a right angle, however its
    // squares are cut into triangles.
    TriMesh mesh = box({1, 1, 1}, {1, 1, 1});
    compute_normals(mesh, pi);
    ASSERT_EQ(mesh.normals.size(), 8u);
    for (std::size_t f = 0; f < mesh.triangles().size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f p = mesh.positions[mesh.triangles()[f][k]].normalized();
            EXPECT_LT((mesh.normals[mesh.topology->normal_triangles[f][k]] - p).norm(), 1e-6);
        }
    }
}

TEST(Normals, OnASphereTheyPointOutwards)
{
    TriMesh mesh = icosphere(2, 4);
    const auto exact = mesh.normals;
    compute_normals(mesh, pi);
    ASSERT_EQ(mesh.normals.size(), exact.size());
    // Edges span 0.07 rad; the angle-weighted mean is of second order in that.
    for (std::size_t i = 0; i < exact.size(); ++i) {
        EXPECT_LT((mesh.normals[i] - mesh.positions[i].normalized()).norm(), 0.005);
    }
}

TEST(Normals, FacesWithoutAreaBorrowTheirVertices)
{
    // Triangle 1 is a needle along the edge of triangle 0; vertex 3 lies on that edge only.
    TriMesh mesh =
        meshes::soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5f, 0, 0}}, {{0, 1, 2}, {0, 3, 1}});
    compute_normals(mesh, 0.5);
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.normals[mesh.topology->normal_triangles[1][0]], Vec3f(0, 0, 1));
}

TEST(Normals, AnEmptyMeshHasNone)
{
    TriMesh mesh;
    compute_normals(mesh, 1);
    EXPECT_TRUE(mesh.normals.empty());
}

TEST(Normals, AFanOfManyFacesTakesLinearTime)
{
    // 200,000 faces around one tip: comparing all with all would be 4e10 steps.
    const std::uint32_t n = 200'000;
    std::vector<Vec3f> positions{{0, 1, 0}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < n; ++i) {
        const double a = 2 * pi * i / n;
        positions.emplace_back(float(std::cos(a)), 0.f, float(-std::sin(a)));
        triangles.push_back({0, 1 + i, 1 + (i + 1) % n});
    }
    TriMesh mesh = meshes::soup(positions, triangles);
    compute_normals(mesh, 0.7);
    EXPECT_LT((mesh.normals[mesh.topology->normal_triangles[0][0]] - Vec3f::UnitY()).norm(), 1e-3);
}

TEST(Normals, AreTheSameBytesForAnyNumberOfThreads)
{
    TriMesh one = torus(1, 0.3, 300, 100);
    TriMesh many = one;
    {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        compute_normals(one, 0.7);
    }
    compute_normals(many, 0.7);
    ASSERT_EQ(one.normals.size(), many.normals.size());
    EXPECT_TRUE(one.normals == many.normals);
    EXPECT_EQ(one.topology->normal_triangles, many.topology->normal_triangles);
}

}  // namespace
