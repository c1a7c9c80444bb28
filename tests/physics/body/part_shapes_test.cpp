// The shapes by which parts touch: of meshes that are open in parts, whose pieces lie in each
// other, and of parts that overlap at rest.

#include "geometry/cubes/bodies.hpp"
#include "geometry/cubes/components.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "physics/body/closed_shape.hpp"
#include "physics/body/make_part_shapes.hpp"
#include "physics/body/outer_faces.hpp"
#include "physics/body/overlaps.hpp"
#include "physics/body/surface_patches.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <numeric>

namespace physics {
namespace {

using geometry::Vec3i;

constexpr double edge = 0.1;

// A plate 0.2 by 0.06 by 0.2 in a layer of cubes that is twice as high, with a fence of one sheet
// on it that reaches into the next layer, and a loose triangle within the plate's cubes.
struct FencedPlate {
    geometry::Cubes cubes = fixtures::cubes_on(
        {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 0}, {1, 1, 0}}, edge);
    geometry::TriMesh surface = geometry::box({0.2, 0.06, 0.2}, {1, 1, 1});

    FencedPlate()
    {
        for (auto& p : surface.positions) p += geometry::Vec3f(0.1f, 0.03f, 0.1f);
        geometry::MeshTopology topology = *surface.topology;
        const auto add = [&](const std::array<geometry::Vec3f, 3>& corners) {
            const auto first = static_cast<std::uint32_t>(surface.positions.size());
            surface.positions.insert(surface.positions.end(), corners.begin(), corners.end());
            topology.triangles.push_back({first, first + 1, first + 2});
        };
        add({geometry::Vec3f(0, 0.05f, 0.05f), {0.2f, 0.05f, 0.05f}, {0.2f, 0.19f, 0.05f}});
        add({geometry::Vec3f(0, 0.05f, 0.05f), {0.2f, 0.19f, 0.05f}, {0, 0.19f, 0.05f}});
        add({geometry::Vec3f(0.01f, 0.08f, 0.15f), {0.03f, 0.08f, 0.15f}, {0.01f, 0.08f, 0.17f}});
        topology.normal_triangles.clear();
        surface.normals.clear();
        surface.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    }
};

TEST(ClosedShape, AnOpenMeshKeepsItsClosedPiecesAndHasCubesAroundTheOthers)
{
    const FencedPlate plate;
    std::vector<std::uint32_t> all(plate.cubes.count());
    std::iota(all.begin(), all.end(), 0);
    const geometry::TriMesh shape = closed_shape(plate.surface, plate.cubes, all);
    ASSERT_TRUE(geometry::is_closed(shape.triangles(), shape.positions.size()));
    const geometry::TriangleBvh tree(shape);
    EXPECT_TRUE(tree.inside(Vec3(0.15, 0.055, 0.15))) << "in the plate";
    EXPECT_FALSE(tree.inside(Vec3(0.15, 0.065, 0.15))) << "over it, in one of its cubes";
    EXPECT_FALSE(tree.inside(Vec3(0.02, 0.08, 0.155))) << "at the loose triangle";
    EXPECT_TRUE(tree.inside(Vec3(0.15, 0.15, 0.01))) << "in a cube of the fence alone";
    EXPECT_TRUE(tree.inside(Vec3(0.15, 0.15, 0.09)));
    EXPECT_FALSE(tree.inside(Vec3(0.15, 0.15, 0.11)));
}

TEST(ClosedShape, SmallHolesAreCappedAndDoubledSheetsHaveCubesAround)
{
    const auto cubes = fixtures::box(2, 2, 2, edge);
    std::vector<std::uint32_t> all(cubes.count());
    std::iota(all.begin(), all.end(), 0);
    const auto without = [](geometry::TriMesh mesh, std::size_t triangles) {
        for (auto& p : mesh.positions) p += geometry::Vec3f::Constant(0.1f);
        geometry::MeshTopology topology;
        topology.triangles.assign(mesh.triangles().begin() + std::ptrdiff_t(triangles),
                                  mesh.triangles().end());
        mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
        mesh.normals.clear();
        return mesh;
    };
    const Vec3 middle(0.1, 0.1, 0.1), in_a_corner(0.02, 0.02, 0.02);
    const geometry::TriMesh ball = geometry::icosphere(0.09, 3);  // 1,280 triangles
    for (const std::size_t hole : {std::size_t{0}, std::size_t{1}}) {
        const geometry::TriMesh shape = closed_shape(without(ball, hole), cubes, all);
        ASSERT_TRUE(geometry::is_closed(shape.triangles(), shape.positions.size()));
        EXPECT_TRUE(geometry::TriangleBvh(shape).inside(middle));
        EXPECT_FALSE(geometry::TriangleBvh(shape).inside(in_a_corner));
    }
    // A third of it is missing; a pipe has holes at both ends, whose areas add to nothing.
    const geometry::TriMesh pipe = without(geometry::cylinder(0.05, 0.15, 48, 1), 0);
    std::vector<geometry::Triangle> side;
    for (const geometry::Triangle& t : pipe.triangles()) {
        const auto up = [&](std::size_t i) { return pipe.positions[t[i]].y() > 0.1f; };
        if (up(0) != up(1) || up(1) != up(2)) side.push_back(t);
    }
    geometry::MeshTopology walls;
    walls.triangles = side;
    geometry::TriMesh tube = pipe;
    tube.topology = std::make_shared<const geometry::MeshTopology>(std::move(walls));
    for (const geometry::TriMesh& open : {without(ball, 400), tube}) {
        EXPECT_TRUE(geometry::TriangleBvh(closed_shape(open, cubes, all)).inside(in_a_corner));
    }
    geometry::TriMesh doubled = without(ball, 1279);
    geometry::MeshTopology topology = *doubled.topology;
    const geometry::Triangle t = topology.triangles[0];
    topology.triangles.push_back({t[0], t[2], t[1]});
    doubled.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    EXPECT_TRUE(geometry::TriangleBvh(closed_shape(doubled, cubes, all)).inside(in_a_corner));
}

// A road on a deck, one centimetre into it. Together they have the deck's area and the road's sides
// above it: 0.128 + 2 (0.16 + 0.1) 0.02 m^2.
TEST(OuterFaces, WhatLiesWithinOtherPiecesIsNoWayOut)
{
    const auto box_at = [](const Vec3& size, const Vec3& middle) {
        geometry::TriMesh box = geometry::box(size, {1, 1, 1});
        for (auto& p : box.positions) p += middle.cast<float>();
        box.normals.clear();
        return box;
    };
    const geometry::TriMesh deck = box_at({0.2, 0.06, 0.2}, {0.1, 0.03, 0.1});
    const geometry::TriMesh road = box_at({0.16, 0.03, 0.1}, {0.1, 0.065, 0.1});
    const geometry::TriMesh both = geometry::merge(std::array{&deck, &road});
    const geometry::TriangleBvh tree(both);
    const auto outer = outer_faces(both, tree, edge);
    ASSERT_TRUE(outer);
    double area = 0;
    for (const auto& t : outer->triangles()) {
        const auto at = [&](std::size_t a) { return Vec3(outer->positions[t[a]].cast<double>()); };
        area += (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
    }
    EXPECT_GT(area, 0.1384 - 1e-6);
    EXPECT_LT(area, 0.1384 + edge / 2 * 0.52) << "a rim of cut triangles is left";
    const Vec3 place(0.1, 0.061, 0.1);  // in the road, 1 mm over the deck's top
    EXPECT_NEAR(tree.closest(place).distance, 0.001, 1e-6);
    EXPECT_NEAR(geometry::TriangleBvh(*outer).closest(place).distance, 0.019, 1e-6);
    EXPECT_FALSE(outer_faces(deck, geometry::TriangleBvh(deck), edge));
    const geometry::TriMesh away = box_at({0.1, 0.1, 0.1}, {0.5, 0, 0});
    const geometry::TriMesh apart = geometry::merge(std::array{&deck, &away});
    EXPECT_FALSE(outer_faces(apart, geometry::TriangleBvh(apart), edge));
}

TEST(Overlaps, PartsThatOverlapAtRestAreTold)
{
    const auto two = [](int up) {
        const auto lower = std::make_shared<const geometry::Cubes>(fixtures::box(3, 3, 3, edge));
        geometry::Cubes upper = fixtures::box(2, 2, 2, edge);
        upper.origin += Vec3(0, 0.25 + 0.1 * up, 0);
        const std::array<std::shared_ptr<const geometry::Cubes>, 2> models{
            lower, std::make_shared<const geometry::Cubes>(upper)};
        const BricksBody body =
            make_bricks(BodyModels(std::vector<BodyModel>{{models[0].get()}, {models[1].get()}}),
                        {.contact = {.friction = 0.5}});
        return told_of_overlaps(models, body.base);
    };
    EXPECT_TRUE(two(1).empty());
    const auto told = two(0);
    ASSERT_EQ(told.size(), 1u);
    EXPECT_TRUE(told[0].find("Bodies 1 and 2 overlap at rest near (0.108, 0.3, 0.108)") == 0)
        << told[0];
}

// Two boxes that meet within a layer of cubes, which both have cubes in.
struct Stacked {
    geometry::TriMesh mesh;
    geometry::Cubes cubes;
    std::vector<std::uint32_t> label;  // C, of its box

    Stacked()
    {
        const geometry::TriMesh low = box_at({0, 0, 0}, {0.3, 0.24, 0.3}),
                                high = box_at({0, 0.24, 0}, {0.3, 0.48, 0.3});
        mesh = geometry::merge(std::array{&low, &high});
        const geometry::VoxelGrid grid{0.1, Vec3::Zero(), geometry::Vec3i::Zero()};
        const std::array bodies{
            voxelize_solid(low, {{}, {{}}, {}}, geometry::Inside::winding, 0, grid, {}),
            voxelize_solid(high, {{}, {{}}, {}}, geometry::Inside::winding, 0, grid, {})};
        cubes = geometry::side_by_side(bodies);
        label = find_components(cubes, geometry::Connectivity::corner).label;
    }

    static geometry::TriMesh box_at(const Vec3& lo, const Vec3& hi)
    {
        geometry::TriMesh out = geometry::box(hi - lo, {1, 1, 1});
        for (auto& p : out.positions) p += (0.5 * (lo + hi)).cast<float>();
        return out;
    }
};
constexpr double area_of_each = 2 * (0.3 * 0.3 + 2 * 0.3 * 0.24);  // m^2

TEST(PartShapes, BodiesThatTouchHaveTheWholeOfTheirSurfaces)
{
    const Stacked boxes;
    const CornerBody body = make_corner_body(boxes.cubes, {}, &boxes.mesh);
    const PartShapes shapes = make_part_shapes({boxes.cubes, &boxes.mesh}, body, {});
    ASSERT_EQ(shapes.parts(), 2u);
    std::array<double, 2> area{};
    for (std::size_t h = 0; h < shapes.holder.size(); ++h) {
        for (auto i = shapes.point_at[h]; i < shapes.point_at[h + 1]; ++i) {
            area[boxes.label[shapes.holder[h]]] += double(shapes.point[i].area);
        }
    }
    for (const double a : area) EXPECT_NEAR(a, area_of_each, 1e-5);
}

TEST(PartShapes, APartThatMayTouchItselfDoesNotOverlapItself)
{
    const geometry::Cubes cubes = fixtures::box(6, 2, 2, edge);
    const CornerBody body = make_corner_body({cubes, nullptr}, {});
    const PartShapes shapes = make_part_shapes({cubes, nullptr}, body, {.self = true});
    EXPECT_TRUE(shapes.touch_themselves());
    EXPECT_TRUE(shapes.overlapping.empty());
}

TEST(PartShapes, SurfacesThatTouchLieInTheCubesOfTheirOwn)
{
    const Stacked boxes;
    const auto patches = patches_of_surface(boxes.cubes, boxes.mesh);
    std::array<double, 2> area{}, points{};
    for (std::size_t c = 0; c < patches.size(); ++c) {
        for (const auto& a : patches[c].areas) area[boxes.label[c]] += double(a.norm());
        for (const auto& p : patches[c].points) points[boxes.label[c]] += double(p.area);
    }
    for (const double a : area) EXPECT_NEAR(a, area_of_each, 1e-5);
    for (const double a : points) EXPECT_NEAR(a, area_of_each, 1e-5);
}

}  // namespace
}  // namespace physics
