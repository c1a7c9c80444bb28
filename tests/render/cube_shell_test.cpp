#include "render/cube_shell.hpp"

#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/primitive.hpp"
#include "render/cube_quantity.hpp"

#include <gtest/gtest.h>
#include <map>

namespace {

using geometry::Cubes;
using geometry::Vec3;
using geometry::Vec3i;

// n x n x n cubes of 1 m in one block.
Cubes block(int n)
{
    Cubes cubes;
    cubes.size = 1;
    std::map<std::array<int, 3>, std::uint32_t> corners;
    for (int z = 0; z <= n; ++z) {
        for (int y = 0; y <= n; ++y) {
            for (int x = 0; x <= n; ++x) {
                corners[{x, y, z}] = static_cast<std::uint32_t>(cubes.corner.size());
                cubes.corner.emplace_back(x, y, z);
            }
        }
    }
    for (int z = 0; z < n; ++z) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                std::array<std::uint32_t, 8> c{};
                for (int a = 0; a < 8; ++a) {
                    c[std::size_t(a)] = corners[{x + (a & 1), y + (a >> 1 & 1), z + (a >> 2 & 1)}];
                }
                cubes.cell.emplace_back(x, y, z);
                cubes.corners.push_back(c);
                cubes.fill.push_back(0.5);
                cubes.component.push_back(std::uint32_t(x));
            }
        }
    }
    return cubes;
}

TEST(CubeShell, OneCubeIsAClosedBoxWoundOutwards)
{
    const Cubes cubes = block(1);
    const auto shell = render::cube_shell(cubes);
    const auto mesh = render::solid_cubes(shell, geometry::corner_positions(cubes), 1);
    ASSERT_EQ(mesh.triangles().size(), 12u);
    ASSERT_EQ(mesh.positions.size(), 8u);
    EXPECT_EQ(shell.edge.size(), 12u);
    double volume = 0;  // by the divergence theorem
    for (std::size_t f = 0; f < 12; ++f) {
        const auto& t = mesh.triangles()[f];
        const Vec3 a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                   c = mesh.positions[t[2]].cast<double>();
        volume += a.dot(b.cross(c)) / 6;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto& n = mesh.normals[mesh.topology->normal_triangles[f][k]];
            EXPECT_NEAR(n.cast<double>().dot((b - a).cross(c - a).normalized()), 1, 1e-6);
        }
    }
    EXPECT_NEAR(volume, 1, 1e-6);
}

// Half of each cube of 1 m^3 is filled by 500 kg: what fills it has 1000 kg/m^3, as Measure says.
TEST(CubeShell, TheDensityIsThatOfWhatFillsACube)
{
    Cubes cubes = block(2);
    cubes.mass.assign(8, 500);
    const auto shell = render::cube_shell(cubes);
    const auto density = render::cube_quantity("density", cubes, shell, nullptr);
    EXPECT_EQ(density.unit, "kg/m^3");
    ASSERT_EQ(density.values.size(), 64u);
    for (const float d : density.values) EXPECT_EQ(d, 1000);
    cubes.mass.pop_back();
    EXPECT_THROW(render::cube_quantity("density", cubes, shell, nullptr), std::invalid_argument);
}

// Of 27 cubes only the middle one has a neighbour on every side. Edges of a 3^3 block: along each
// axis 3 * 4 * 4.
TEST(CubeShell, LeavesOutWhatIsHidden)
{
    const auto shell = render::cube_shell(block(3));
    EXPECT_EQ(shell.cube.size(), 26u);
    EXPECT_EQ(shell.edge.size(), 3u * 3 * 4 * 4);
    EXPECT_EQ(std::count(shell.cube.begin(), shell.cube.end(), 13u), 0);
    EXPECT_EQ(shell.layout->triangles.size(), 26u * 12);
}

// Cubes that share a cell but no corners are not neighbours of each other's neighbours.
TEST(CubeShell, ShowsAllCellsOfPlanesAndSheets)
{
    for (int axis = 0; axis < 3; ++axis) {
        const Cubes plane =
            geometry::plane_cubes(geometry::rectangle_cells(5, 4), {axis, 0.1, {0, 0, 0}}, 0.01);
        EXPECT_EQ(render::cube_shell(plane).cube.size(), plane.count());
    }
    const Cubes sheet = geometry::make_sheet(geometry::icosphere(1, 2), 0.01).cubes;
    EXPECT_EQ(render::cube_shell(sheet).cube.size(), sheet.count());
}

TEST(CubeShell, CopiesInOneCellHideNothing)
{
    Cubes cubes = block(3);
    const Cubes lone = block(1);
    std::array<std::uint32_t, 8> corners{};
    for (std::size_t a = 0; a < 8; ++a) {
        corners[a] = static_cast<std::uint32_t>(cubes.corner.size());
        cubes.corner.push_back(lone.corner[a] + Vec3i(1, 1, 1));
    }
    cubes.cell.emplace_back(1, 1, 1);
    cubes.corners.push_back(corners);
    EXPECT_EQ(render::cube_shell(cubes).cube.size(), 27u);
}

TEST(CubeShell, ShrinksEachCubeAboutItsCentre)
{
    const Cubes cubes = block(2);
    auto x = geometry::corner_positions(cubes);
    for (Vec3& p : x) p = Vec3(2 * p.x() + p.y(), p.y(), p.z());
    const auto shell = render::cube_shell(cubes);
    const auto whole = render::solid_cubes(shell, x, 1), half = render::solid_cubes(shell, x, 0.5f);
    for (std::size_t c = 0; c < 8; ++c) {
        const auto a = whole.positions[8 * c], b = whole.positions[8 * c + 7];
        const auto p = half.positions[8 * c], q = half.positions[8 * c + 7];
        EXPECT_LT((p + q - a - b).norm(), 1e-6f);
        EXPECT_LT((q - p - 0.5f * (b - a)).norm(), 1e-6f);
    }
}

TEST(CubeShell, NothingIsNothing)
{
    const auto shell = render::cube_shell({});
    EXPECT_TRUE(render::solid_cubes(shell, {}, 1).positions.empty());
    EXPECT_TRUE(render::cube_lines(shell, {}).ends.empty());
}

TEST(CubeShell, AStateOfOtherCubesIsRefused)
{
    const auto shell = render::cube_shell(block(2));
    const std::vector<Vec3> few(5, Vec3(0, 0, 0));
    EXPECT_THROW(render::solid_cubes(shell, few, 1), std::invalid_argument);
    EXPECT_THROW(render::cube_lines(shell, few), std::invalid_argument);
}

TEST(CubeQuantity, ReadsCubesAndState)
{
    const Cubes cubes = block(2);
    const auto shell = render::cube_shell(cubes);
    physics::State state;
    state.x = geometry::corner_positions(cubes);
    for (Vec3& p : state.x) p.y() += 0.25;
    state.v.assign(state.x.size(), Vec3(3, 4, 0));
    state.stress.assign(8, 7.0f);
    const auto all = [&](const char* name, const physics::State* s, float expected) {
        const auto a = render::cube_quantity(name, cubes, shell, s);
        ASSERT_EQ(a.values.size(), 64u);
        for (const float v : a.values) EXPECT_FLOAT_EQ(v, expected);
    };
    all("displacement", &state, 0.25f);
    all("speed", &state, 5);
    all("stress", &state, 7);
    all("plastic_strain", &state, 0);  // nothing has flowed
    state.plastic_strain.assign(8, 0.125f);
    all("plastic_strain", &state, 0.125f);
    all("plastic_strain", nullptr, 0);
    all("fill", &state, 0.5f);
    all("displacement", nullptr, 0);
    const auto component = render::cube_quantity("component", cubes, shell, nullptr);
    for (std::size_t c = 0; c < 8; ++c) EXPECT_EQ(component.values[8 * c + 3], float(c % 2));
    EXPECT_THROW(render::cube_quantity("smell", cubes, shell, &state), std::invalid_argument);
    EXPECT_THROW(render::cube_quantity("young", cubes, shell, &state), std::invalid_argument);
    state.x.pop_back();
    EXPECT_THROW(render::cube_quantity("displacement", cubes, shell, &state),
                 std::invalid_argument);
}

}  // namespace
