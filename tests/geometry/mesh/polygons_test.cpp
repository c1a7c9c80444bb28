#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/triangulate.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace {

using namespace geometry;

using Polygon = std::vector<std::uint32_t>;

MeshTopology cut_up(const std::vector<Polygon>& polygons, const std::vector<Vec3f>& positions)
{
    MeshTopology t;
    for (const Polygon& p : polygons) {
        const std::size_t before = t.triangles.size();
        triangulate(p, positions, t.triangles);
        add_polygon(t.polygon, t.triangles.size() - before);
    }
    return t;
}

std::vector<Polygon> polygons_of(const MeshTopology& t)
{
    const Outlines faces = outlines(t);
    std::vector<Polygon> out;
    for (std::size_t p = 0; p < faces.count(); ++p) {
        Polygon& polygon = out.emplace_back();
        for (const std::uint32_t c : faces[p]) polygon.push_back(t.triangles[c / 3][c % 3]);
        EXPECT_EQ(faces[p][0] / 3, faces.first_triangle(p));
    }
    return out;
}

// The same loop from its least vertex on.
std::vector<Polygon> turned(std::vector<Polygon> polygons)
{
    for (Polygon& p : polygons)
        std::rotate(p.begin(), std::min_element(p.begin(), p.end()), p.end());
    return polygons;
}

// A square, a notched pentagon and a triangle side by side.
const std::vector<Vec3f> places{{0, 0, 0}, {1, 0, 0}, {1, 1, 0},   {0, 1, 0},
                                {2, 0, 0}, {2, 1, 0}, {3, 0.5, 0}, {1.5f, 0.4f, 0}};
const std::vector<Polygon> mixed{{0, 1, 2, 3}, {1, 4, 5, 7, 2}, {4, 6, 5}};

TEST(Polygons, QuadsConcavePentagonsAndTrianglesAreFoundAgain)
{
    const MeshTopology t = cut_up(mixed, places);
    EXPECT_EQ(t.polygon, (std::vector<std::uint32_t>{0, 0, 1, 1, 1, 2}));
    EXPECT_EQ(turned(polygons_of(t)), mixed);
    EXPECT_EQ(outlines(t).most_corners(), 5u);
}

// Stars of random radii have corners of both kinds. Written and read again, the triangles are the
// same ones.
TEST(Polygons, WhatIsFoundIsCutTheSameWayAgain)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> radius(0.3, 1);
    for (std::uint32_t n = 4; n < 40; ++n) {
        SCOPED_TRACE(n);
        std::vector<Vec3f> at;
        Polygon star;
        for (std::uint32_t i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * i / n, r = radius(random);
            at.push_back(Vec3(r * std::cos(angle), 0.3 * r, r * std::sin(angle)).cast<float>());
            star.push_back(i);
        }
        const MeshTopology t = cut_up({star}, at);
        const std::vector<Polygon> found = polygons_of(t);
        ASSERT_EQ(turned(found), std::vector<Polygon>{star});
        const auto sorted = [](std::vector<Triangle> triangles) {
            for (Triangle& c : triangles)
                std::rotate(c.begin(), std::ranges::min_element(c), c.end());
            return triangles;
        };
        EXPECT_EQ(sorted(cut_up(found, at).triangles), sorted(t.triangles));
    }
}

TEST(Polygons, OneThatLosesATriangleFallsApart)
{
    const MeshTopology t = cut_up(mixed, places);
    using Numbers = std::vector<std::uint32_t>;
    EXPECT_EQ(polygons_left(t.polygon, std::array<std::uint8_t, 6>{}), t.polygon);
    EXPECT_EQ(polygons_left(t.polygon, std::array<std::uint8_t, 6>{0, 1}),
              (Numbers{0, 1, 1, 1, 2}));
    EXPECT_EQ(polygons_left(t.polygon, std::array<std::uint8_t, 6>{0, 0, 0, 1}),
              (Numbers{0, 0, 1, 2, 3}));
    EXPECT_EQ(polygons_left(t.polygon, std::array<std::uint8_t, 6>{1, 1, 0, 0, 0, 1}),
              (Numbers{0, 0, 0}));
    EXPECT_EQ(polygons_left(t.polygon, std::array<std::uint8_t, 6>{1, 0, 1}), Numbers{})
        << "triangles alone need no numbers";
}

TEST(Polygons, WhatIsNoSimpleLoopIsWrittenAsTriangles)
{
    // A corner that is passed twice, an edge that two triangles share in one direction, triangles
    // that do not meet.
    for (const std::vector<Triangle>& triangles : {std::vector<Triangle>{{0, 1, 2}, {0, 3, 4}},
                                                   {{0, 1, 2}, {0, 1, 3}},
                                                   {{0, 1, 2}, {3, 4, 5}},
                                                   {{0, 1, 2}, {0, 2, 1}},
                                                   {{0, 1, 2}, {2, 1, 3}, {3, 1, 0}}}) {
        MeshTopology t;
        t.triangles = triangles;
        add_polygon(t.polygon, triangles.size());
        const Outlines faces = outlines(t);
        EXPECT_EQ(faces.count(), triangles.size());
        EXPECT_EQ(faces.most_corners(), 3u);
    }
}

TEST(Polygons, TrianglesThatDifferInLookStayApart)
{
    const MeshTopology quad = cut_up({{0, 1, 2, 3}}, places);
    const auto faces = [](const MeshTopology& t) { return outlines(t).count(); };
    MeshTopology t = quad;
    t.material = {0, 1};
    EXPECT_EQ(faces(t), 2u);
    t.material = {1, 1};
    EXPECT_EQ(faces(t), 1u);
    t.group = {1, 0};
    EXPECT_EQ(faces(t), 2u);
    t.group.clear();
    t.uv_triangles = t.triangles;
    EXPECT_EQ(faces(t), 1u);
    t.uv_triangles[1] = {4, 5, 6};
    EXPECT_EQ(faces(t), 2u);
    // Of normals, one a corner counts.
    t = quad;
    t.normal_triangles = {{0, 1, 2}, {3, 4, 5}};
    EXPECT_EQ(faces(t), 1u);
}

TEST(Polygons, MergedMeshesKeepTheirs)
{
    TriMesh quads = meshes::soup(places, {});
    quads.topology = std::make_shared<const MeshTopology>(cut_up(mixed, places));
    const TriMesh plain = meshes::soup(places, {{0, 1, 2}, {1, 4, 5}});
    const std::array<const TriMesh*, 3> all{&plain, &quads, &quads};
    const TriMesh out = merge(all);
    meshes::expect_consistent(out);
    const std::vector<Polygon> found = turned(polygons_of(*out.topology));
    ASSERT_EQ(found.size(), 8u);
    EXPECT_EQ(found[2], (Polygon{8, 9, 10, 11}));
    EXPECT_EQ(found[6], (Polygon{17, 20, 21, 23, 18}));
    const std::array<const TriMesh*, 1> one{&plain};
    EXPECT_TRUE(merge(one).topology->polygon.empty());
}

}  // namespace
