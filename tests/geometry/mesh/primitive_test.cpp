#include "geometry/mesh/primitive.hpp"

#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace {

using namespace geometry;
using std::numbers::pi;

TEST(Primitive, EveryShapeIsConsistentAndFacesOutwards)
{
    for (const auto& [name, mesh, closed] : meshes::sound()) {
        SCOPED_TRACE(name);
        meshes::expect_consistent(mesh);
        EXPECT_EQ(meshes::closed(mesh), closed);
        // The coarsest here, the uv sphere's polar triangles, turn 15 degrees between vertices.
        EXPECT_GT(meshes::worst_normal(mesh), 0.9);
        if (closed) {
            EXPECT_GT(enclosed_volume(mesh), 0);
        }
    }
}

TEST(Primitive, ABoxHasItsSizeVolumeAndCounts)
{
    const TriMesh mesh = box({1, 2, 3}, {2, 3, 4});
    EXPECT_NEAR(enclosed_volume(mesh), 6, 6e-6);  // float positions
    // Lattice points on the surface: 3*4*5 - 1*2*3; two triangles for each of 2(2*3 + 3*4 + 4*2).
    EXPECT_EQ(mesh.positions.size(), 54u);
    EXPECT_EQ(mesh.triangles().size(), 104u);
    EXPECT_EQ(bounds(mesh).lo, Vec3(-0.5, -1, -1.5));
    EXPECT_EQ(bounds(mesh).hi, Vec3(0.5, 1, 1.5));
    // Normals: one a vertex inside a side, two on an edge, three at a corner: per side all lattice
    // points of it, 2(3*4 + 4*5 + 5*3).
    EXPECT_EQ(mesh.normals.size(), 94u);
}

TEST(Primitive, SpheresLieOnTheSphereAndNearItsVolume)
{
    for (const TriMesh& mesh : {icosphere(0.5, 4), uv_sphere(0.5, 96, 48)}) {
        for (const Vec3f& p : mesh.positions) ASSERT_NEAR(p.norm(), 0.5, 1e-7);
        // An inscribed shape whose edges span an angle a misses about a^2 / 4 of the volume;
        // a = 2 pi / 96 here or less.
        const double exact = 4. / 3 * pi * 0.125;
        EXPECT_LT(enclosed_volume(mesh), exact);
        EXPECT_GT(enclosed_volume(mesh), exact * (1 - 0.005));
    }
    EXPECT_EQ(icosphere(1, 2).positions.size(), 162u);    // 10 * 4^2 + 2
    EXPECT_EQ(uv_sphere(1, 8, 6).positions.size(), 42u);  // 8 * 5 + 2 poles
}

TEST(Primitive, ACylinderIsAPrismOverARegularPolygon)
{
    const TriMesh mesh = cylinder(0.5, 2, 12, 3);
    const double area = 0.5 * 12 * 0.25 * std::sin(2 * pi / 12);
    EXPECT_NEAR(enclosed_volume(mesh), 2 * area, 1e-6);
    EXPECT_EQ(mesh.triangles().size(), 12u * 2 * 3 + 2 * 12);
}

TEST(Primitive, ATorusHasPappusVolume)
{
    // Pappus: 2 pi^2 R r^2, the polygons missing about (2 pi / n)^2 / 6 in each direction's area.
    const double exact = 2 * pi * pi * 1 * 0.09;
    EXPECT_NEAR(enclosed_volume(torus(1, 0.3, 200, 100)), exact, 0.002 * exact);
}

TEST(Primitive, BadSizesAndCountsAreRefused)
{
    EXPECT_THROW(box({0, 1, 1}, {1, 1, 1}), std::invalid_argument);
    EXPECT_THROW(box({1, 1, 1}, {1, 0, 1}), std::invalid_argument);
    EXPECT_THROW(box({1, 1, std::nan("")}, {1, 1, 1}), std::invalid_argument);
    EXPECT_THROW(box({1, 1, 1}, {100000, 100000, 1}), std::invalid_argument);
    EXPECT_THROW(uv_sphere(1, 2, 5), std::invalid_argument);
    EXPECT_THROW(icosphere(-1, 1), std::invalid_argument);
    EXPECT_THROW(icosphere(1, 40), std::invalid_argument);
    EXPECT_THROW(grid(1, 1, 0, 1), std::invalid_argument);
    EXPECT_THROW(cylinder(1, 1, 2, 1), std::invalid_argument);
    EXPECT_THROW(torus(1, 1, 8, 8), std::invalid_argument);
}

}  // namespace
