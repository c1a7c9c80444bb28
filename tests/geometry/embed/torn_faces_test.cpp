#include "geometry/embed/torn_faces.hpp"

#include "geometry/cubes/plane.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <gtest/gtest.h>

using namespace geometry;

namespace {

std::uint32_t corner_at(const Cubes& cubes, const Vec3i& at)
{
    const auto found = std::find(cubes.corner.begin(), cubes.corner.end(), at);
    return std::uint32_t(found - cubes.corner.begin());
}

Vec3f middle(const TriMesh& mesh, std::size_t f)
{
    Vec3f sum = Vec3f::Zero();
    for (const auto v : mesh.triangles()[f]) sum += mesh.positions[std::size_t(v)] / 3;
    return sum;
}

}  // namespace

TEST(TornFaces, AreThoseInCubesAroundABrokenLink)
{
    // Six cubes of 0.5 m in a row along x, and a second row behind them along z; the link that
    // goes along x from the third cube's corner on the floor between both rows is gone.
    std::vector<Vec3i> cells;
    for (int z = 0; z < 2; ++z) {
        for (int x = 0; x < 6; ++x) cells.emplace_back(x, 0, z);
    }
    Cubes cubes = solid_cubes(cells, 0.5);
    cubes.origin = Vec3(-1, 2, 3);
    const std::vector<std::uint32_t> broken{3 * corner_at(cubes, {2, 0, 1})};
    // Small faces, so each lies in one cube: those of the third cubes of both rows.
    TriMesh mesh = grid(3, 1, 60, 20);
    for (Vec3f& p : mesh.positions) p += Vec3f(0.5f, 2.25f, 3.5f);
    const auto gone = torn_faces(bind(mesh, cubes), mesh, cubes, broken);
    std::size_t count = 0;
    for (std::size_t f = 0; f < gone.size(); ++f) {
        const float x = middle(mesh, f).x();
        ASSERT_EQ(gone[f] != 0, x > 0.0f && x < 0.5f) << x;
        count += gone[f];
    }
    EXPECT_EQ(count, gone.size() / 6);
    // The link one layer up is another one, but of the same cubes; one along z is of two pairs.
    EXPECT_EQ(
        torn_faces(bind(mesh, cubes), mesh, cubes, std::vector{3 * corner_at(cubes, {2, 1, 1})}),
        gone);
    const auto along_z = torn_faces(bind(mesh, cubes), mesh, cubes,
                                    std::vector{3 * corner_at(cubes, {2, 0, 0}) + 2});
    for (std::size_t f = 0; f < gone.size(); ++f) {
        const Vec3f at = middle(mesh, f);
        ASSERT_EQ(along_z[f] != 0, at.x() > -0.5f && at.x() < 0.5f && at.z() < 3.5f);
    }
    EXPECT_EQ(torn_faces(bind(mesh, cubes), mesh, cubes, {}),
              std::vector<std::uint8_t>(gone.size(), 0));
}

TEST(TornFaces, ALongFaceWithItsCornersOnBothSidesIsOne)
{
    std::vector<Vec3i> cells;
    for (int x = 0; x < 6; ++x) cells.emplace_back(x, 0, 0);
    const Cubes cubes = solid_cubes(cells, 1);
    const TriMesh mesh = [] {
        TriMesh two;
        two.positions = {{0.1f, 0.5f, 0.2f}, {5.9f, 0.5f, 0.2f}, {5.9f, 0.5f, 0.3f},
                         {0.1f, 0.5f, 0.6f}, {1.9f, 0.5f, 0.6f}, {1.9f, 0.5f, 0.8f}};
        auto topology = std::make_shared<MeshTopology>();
        topology->triangles = {{0, 1, 2}, {3, 4, 5}};
        topology->group = {7, 8};
        two.topology = topology;
        return two;
    }();
    const auto gone =
        torn_faces(bind(mesh, cubes), mesh, cubes, std::vector{3 * corner_at(cubes, {3, 1, 1})});
    EXPECT_EQ(gone, (std::vector<std::uint8_t>{1, 0}));
    const TriMesh rest = without_faces(mesh, gone);
    ASSERT_EQ(rest.triangles().size(), 1u);
    EXPECT_EQ(rest.triangles()[0], mesh.triangles()[1]);
    EXPECT_EQ(rest.topology->group, std::vector<std::uint16_t>{8});
    EXPECT_EQ(rest.positions, mesh.positions);
    EXPECT_EQ(mesh.triangles().size(), 2u);
}

TEST(TornFaces, OfAFaceThatIsHugeOrNotFiniteAreFoundSoon)
{
    const Cubes cubes = solid_cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, 1e-3);
    const float far = 1e5f, none = std::numeric_limits<float>::infinity();
    TriMesh mesh;
    mesh.positions = {{-far, 5e-4f, -far}, {far, 5e-4f, -far}, {0, 5e-4f, far},
                      {-far, 2, -far},     {far, 2, -far},     {0, 2, far},
                      {0, 0, 0},           {none, 0, 0},       {0, none, 1}};
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
    mesh.topology = topology;
    const auto gone =
        torn_faces(bind(mesh, cubes), mesh, cubes, std::vector{3 * corner_at(cubes, {1, 0, 0})});
    EXPECT_EQ(gone, (std::vector<std::uint8_t>{1, 0, 0}));
}

TEST(TornFaces, OfAPlaneAtAnyHeightAboveIt)
{
    const Cubes cubes = plane_cubes(rectangle_cells(4, 4), {1, 1, Vec3(0, 0.7, 0)}, 0.01);
    // Across y, u is z. A face above the middle of cell (z, x) = (1, 2), one above (3, 2).
    TriMesh mesh;
    for (const float z : {1.0f, 3.0f}) {
        mesh.positions.insert(
            mesh.positions.end(),
            {{2.2f, 0.75f, z + 0.2f}, {2.8f, 0.65f, z + 0.2f}, {2.5f, 0.7f, z + 0.8f}});
    }
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 1, 2}, {3, 4, 5}};
    mesh.topology = topology;
    const std::uint32_t corner = corner_at(cubes, {2, cubes.corner[0][1], 1});
    ASSERT_LT(corner, cubes.corner_count());
    EXPECT_EQ(torn_faces(bind(mesh, cubes), mesh, cubes, std::vector{3 * corner}),
              (std::vector<std::uint8_t>{1, 0}));
}
