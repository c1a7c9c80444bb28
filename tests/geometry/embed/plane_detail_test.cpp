#include "geometry/embed/plane_detail.hpp"

#include "geometry/cubes/plane.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

using namespace geometry;

namespace {

// 8 by 8 cells of 0.25 m from the origin, across `axis`.
Cubes patch_across(int axis)
{
    return plane_cubes(rectangle_cells(8, 8), {axis, 0.25, Vec3::Zero()}, 0.01);
}

// A grid of n by n quads `height` above the patch, `rim` within its rim, facing along `axis`.
TriMesh sheet_over(int axis, double height, std::uint32_t n, double rim = 0.1)
{
    const auto [u, v] = plane_axes(axis);
    std::vector<Vec3f> p, normals;
    std::vector<Triangle> t;
    for (std::uint32_t j = 0; j <= n; ++j) {
        for (std::uint32_t i = 0; i <= n; ++i) {
            Vec3 at;
            at[axis] = height, at[u] = rim + (2 - 2 * rim) * i / n,
            at[v] = rim + (2 - 2 * rim) * j / n;
            p.push_back(at.cast<float>());
            normals.push_back(Vec3f::Unit(axis));
            if (i == n || j == n) continue;
            const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            t.insert(t.end(), {{a, b, d}, {a, d, c}});
        }
    }
    TriMesh mesh = test_meshes::mesh_of(p, t);
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    topology->normal_triangles = t;
    mesh.topology = topology;
    mesh.normals = normals;
    return mesh;
}

std::vector<Vec3f> as_floats(const std::vector<Vec3>& all)
{
    std::vector<Vec3f> out;
    for (const Vec3& p : all) out.push_back(p.cast<float>());
    return out;
}

}  // namespace

// A detail that is linear across the patch is interpolated exactly: the sheet on the patch is
// tilted by slope s, its normals by atan s, and farther away by the weight w^2 (3 - 2 w),
// w = 1 - height / distance, which is 1/2 halfway and 0 at the distance.
TEST(Patch, TiltsWhatLiesOverItLessTheFartherItIs)
{
    constexpr double s = 0.3;
    for (const int axis : {0, 1, 2}) {
        const Cubes patch = patch_across(axis);
        const int u = plane_axes(axis)[0];
        const std::vector<Vec3> rest = corner_positions(patch);
        std::vector<Vec3> x = rest;
        for (Vec3& p : x) p[axis] += s * p[u];
        for (const auto& [height, share] : {std::pair(0.0, 1.0), {0.2, 0.5}, {-0.2, 0.5}}) {
            const TriMesh mesh = sheet_over(axis, height, 12);
            const PlaneDetail binding = bind_plane_detail(mesh, patch, 0.4);
            ASSERT_EQ(binding.vertices.size(), mesh.positions.size());
            const TriMesh out = add_plane_detail(binding, mesh, patch, x, as_floats(rest));
            const double slope = share * s;
            Vec3 normal = Vec3::Unit(axis) - slope * Vec3::Unit(u);
            normal.normalize();
            for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
                Vec3 expected = mesh.positions[i].cast<double>();
                expected[axis] += slope * expected[u];
                EXPECT_LT((out.positions[i].cast<double>() - expected).norm(), 1e-6);
                EXPECT_LT((out.normals[i].cast<double>() - normal).norm(), 1e-5);
            }
        }
        EXPECT_TRUE(bind_plane_detail(sheet_over(axis, 0.4, 12), patch, 0.4).vertices.empty());
    }
}

// All sides of the rim move, what rounding leaves outside too; what lies farther out does not.
TEST(Patch, ReachesItsRimOnAllSides)
{
    for (const int axis : {0, 1, 2}) {
        const Cubes patch = patch_across(axis);
        const std::vector<Vec3> rest = corner_positions(patch);
        std::vector<Vec3> x = rest;
        for (Vec3& p : x) p[axis] += 0.5;
        for (const double outside : {0.0, 1e-6}) {
            const TriMesh mesh = sheet_over(axis, 0, 4, -outside);
            const PlaneDetail binding = bind_plane_detail(mesh, patch, 0.4);
            const TriMesh out = add_plane_detail(binding, mesh, patch, x, as_floats(rest));
            for (const Vec3f& p : out.positions) EXPECT_NEAR(p[axis], 0.5, 1e-6) << p.transpose();
        }
        EXPECT_EQ(bind_plane_detail(sheet_over(axis, 0, 4, -0.01), patch, 0.4).vertices.size(), 9u);
    }
}

// What the object does alone is no detail; what it does besides is carried along.
TEST(Patch, AddsOnlyWhatThePatchDoesBesideItsObject)
{
    const Cubes patch = patch_across(1);
    const TriMesh rest = sheet_over(1, 0, 5);
    const PlaneDetail binding = bind_plane_detail(rest, patch, 0.4);
    const Eigen::AngleAxisd turn(1.2, Vec3(1, 2, 3).normalized());
    std::vector<Vec3> carried;
    for (const Vec3& p : corner_positions(patch)) carried.push_back(turn * p + Vec3(4, 5, 6));
    TriMesh mesh = rest;
    for (Vec3f& p : mesh.positions) p = (turn * p.cast<double>() + Vec3(4, 5, 6)).cast<float>();
    std::vector<Vec3> rounded;  // the object's mesh is in single precision
    for (const Vec3f& p : as_floats(carried)) rounded.push_back(p.cast<double>());
    EXPECT_EQ(add_plane_detail(binding, mesh, patch, rounded, as_floats(carried)).positions,
              mesh.positions);
    // One particle moves: the vertices of the four cells around it, by how near they are to it.
    std::uint32_t moved = 0;
    while (patch.corner_position(moved) != Vec3(1, 0, 1)) ++moved;
    rounded[moved] += Vec3(0, 0.5, 0);
    const TriMesh out = add_plane_detail(binding, mesh, patch, rounded, as_floats(carried));
    for (std::size_t i = 0; i < rest.positions.size(); ++i) {
        const Vec3 from = (rest.positions[i].cast<double>() - Vec3(1, 0, 1)) / 0.25;
        const double share =
            std::max(0.0, 1 - std::abs(from.x())) * std::max(0.0, 1 - std::abs(from.z()));
        EXPECT_NEAR(out.positions[i].y() - mesh.positions[i].y(), 0.5 * share, 1e-6);
    }
}

TEST(Patch, SaysWhatDoesNotBelongTogether)
{
    const TriMesh mesh = sheet_over(1, 0, 3);
    EXPECT_THROW(bind_plane_detail(mesh, solid_cubes({{0, 0, 0}}, 1), 1), std::invalid_argument);
    const Cubes patch = patch_across(1);
    const std::vector<Vec3> x = corner_positions(patch);
    const PlaneDetail binding = bind_plane_detail(mesh, patch, 1);
    EXPECT_THROW(add_plane_detail(binding, mesh, patch, std::span(x).first(3), as_floats(x)),
                 std::invalid_argument);
    EXPECT_THROW(add_plane_detail(binding, mesh, patch, x, {}), std::invalid_argument);
    EXPECT_THROW(add_plane_detail(binding, {}, patch, x, as_floats(x)), std::invalid_argument);
    TriMesh odd = mesh;
    odd.positions[0].x() = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(bind_plane_detail(odd, patch, 1).vertices.size(), mesh.positions.size() - 1);
}
