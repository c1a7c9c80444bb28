// The rims of a mesh's flat faces, and the points that rigid parts touch each other with.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/body/flat_faces.hpp"
#include "physics/body/make_part_shapes.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace physics {
namespace {

using geometry::TriMesh;
using geometry::Vec3f;

const Vec3f size(0.4f, 0.3f, 0.2f);

// How many of a box's pairs of sides a place lies on: 2 on its edges, 3 at its corners.
int sides_at(const Vec3f& p)
{
    int out = 0;
    for (int i = 0; i < 3; ++i) out += std::abs(std::abs(p[i]) - size[i] / 2) < 1e-6f ? 1 : 0;
    return out;
}

void expect_rims_at_edges_of_the_box(const TriMesh& box)
{
    const std::vector<Rims> rims = rims_of_flat_faces(box, 1e-4);
    ASSERT_EQ(rims.size(), box.triangles().size());
    for (std::size_t t = 0; t < rims.size(); ++t) {
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3f p = box.positions[box.triangles()[t][i]];
            const Vec3f q = box.positions[box.triangles()[t][(i + 1) % 3]];
            EXPECT_EQ(rims[t].corner[i], sides_at(p) >= 2) << "triangle " << t << ", corner " << i;
            EXPECT_EQ(rims[t].side[i], sides_at(0.5f * (p + q)) >= 2)
                << "triangle " << t << ", side " << i;
        }
    }
}

TEST(FlatFaces, OfABoxEndAtItsEdges)
{
    expect_rims_at_edges_of_the_box(geometry::box(size.cast<double>(), {4, 3, 2}));
}

// Each triangle has vertices of its own.
TEST(FlatFaces, AreFoundAcrossVerticesThatAreNotJoined)
{
    const TriMesh box = geometry::box(size.cast<double>(), {4, 3, 2});
    TriMesh soup;
    geometry::MeshTopology topology;
    for (const auto& t : box.triangles()) {
        const auto first = static_cast<std::uint32_t>(soup.positions.size());
        for (const auto v : t) soup.positions.push_back(box.positions[v]);
        topology.triangles.push_back({first, first + 1, first + 2});
    }
    soup.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    expect_rims_at_edges_of_the_box(soup);
}

TEST(FlatFaces, OfABallAreItsTriangles)
{
    for (const Rims& rims : rims_of_flat_faces(geometry::icosphere(0.1, 2), 1e-4)) {
        for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(rims.side[i] && rims.corner[i]);
    }
}

// Two triangles that are bent along their common side: the tip is 0.002 above the other's plane.
TEST(FlatFaces, EndWhereSurfacesLeaveThePlane)
{
    TriMesh bent;
    bent.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0.002f, 1}};
    geometry::MeshTopology topology;
    topology.triangles = {{0, 2, 1}, {1, 2, 3}};
    bent.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    const auto common = [&](double off) {
        const std::vector<Rims> rims = rims_of_flat_faces(bent, off);
        EXPECT_TRUE(rims[0].side[0] && rims[0].side[2]);
        EXPECT_EQ(rims[0].side[1], rims[1].side[0]);
        return rims[0].side[1];
    };
    EXPECT_FALSE(common(0.003));
    EXPECT_TRUE(common(0.001));
}

std::vector<geometry::Vec3> points_of(bool rigid)
{
    const TriMesh mesh = geometry::box(size.cast<double>(), {1, 1, 1});
    geometry::Cubes cubes = fixtures::box(20, 15, 10, 0.02);
    cubes.origin = -0.5 * size.cast<double>();
    CornerBody body = make_corner_body(cubes, {}, &mesh);
    if (rigid) body.rigid.assign(body.parts, 1);
    const PartShapes shapes = make_part_shapes({cubes, &mesh}, body, {});
    std::vector<geometry::Vec3> out;
    for (std::size_t h = 0; h < shapes.holder.size(); ++h) {
        for (auto p = shapes.point_at[h]; p < shapes.point_at[h + 1]; ++p) {
            out.emplace_back(cubes.origin +
                             cubes.size * (cubes.cell[shapes.holder[h]].cast<double>() +
                                           shapes.point[p].place.cast<double>()));
        }
    }
    return out;
}

TEST(PartShapes, ARigidBoxTouchesOthersAlongItsEdges)
{
    constexpr double near = 0.2 * 0.02;
    const auto all = points_of(false), rims = points_of(true);
    EXPECT_LT(5 * rims.size(), all.size());
    const geometry::Vec3 half = 0.5 * size.cast<double>();
    std::array<std::size_t, 12> of_edge{};
    for (const geometry::Vec3& p : rims) {
        const geometry::Vec3 in = half - p.cwiseAbs();
        Eigen::Index along = 0;
        in.maxCoeff(&along);
        for (Eigen::Index i = 0; i < 3; ++i) {
            EXPECT_TRUE(i == along || in[i] < near) << in.transpose();
        }
        const Eigen::Index a = (along + 1) % 3, b = (along + 2) % 3;
        ++of_edge[static_cast<std::size_t>(4 * along + 2 * (p[a] > 0) + (p[b] > 0))];
    }
    for (std::size_t e = 0; e < 12; ++e) {
        const double length = 2 * half[static_cast<Eigen::Index>(e / 4)];
        EXPECT_GE(static_cast<double>(of_edge[e]), length / 0.02) << "edge " << e;
    }
}

}  // namespace
}  // namespace physics
