#include "geometry/cubes/voxelize.hpp"

#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/cubes/fill_cubes.hpp"
#include "geometry/cubes/sample_surface.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <numeric>

namespace {

using geometry::Cubes;
using geometry::FaceMatter;
using geometry::Inside;
using geometry::Matter;
using geometry::MatterRule;
using geometry::Samples;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;
using geometry::Vec3i;
using geometry::VoxelGrid;
using geometry::VoxelOptions;

double sum_of(const std::vector<double>& v)
{
    return std::accumulate(v.begin(), v.end(), 0.0);
}

FaceMatter one(const Matter& matter = {})
{
    return {{}, {matter}, {}};
}

VoxelGrid grid_of(const TriMesh& mesh, double size)
{
    return fit_grid(triangle_bounds(mesh), size);
}

double area_of(const TriMesh& mesh)
{
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles()) {
        sum += 0.5 * (mesh.positions[b] - mesh.positions[a])
                         .cast<double>()
                         .cross((mesh.positions[c] - mesh.positions[a]).cast<double>())
                         .norm();
    }
    return sum;
}

TEST(ClipToCells, PiecesLieInTheirCellsAndAddUp)
{
    const geometry::Random random(6);
    for (std::uint64_t i = 0; i < 300; ++i) {
        std::array<Vec3, 3> p;
        for (std::uint64_t k = 0; k < 9; ++k) {
            double x = 8 * random.unit(9 * i + k) - 4;
            if (i % 2) x = std::round(2 * x) / 2;
            p[k / 3][static_cast<int>(k % 3)] = x;
        }
        geometry::LatticeMesh mesh;
        mesh.positions = {p[0], p[1], p[2]};
        mesh.triangles = {{0, 1, 2}};
        const auto cells = surface_cells(mesh, geometry::CellShape::half_open);
        double sum = 0;
        geometry::clip_to_cells(p[0], p[1], p[2], [&](const Vec3i& cell, double area) {
            if (area > 1e-12) {
                EXPECT_TRUE(cells.contains(cell)) << cell.transpose();
            }
            sum += area;
        });
        EXPECT_NEAR(sum, 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm(), 1e-12 * 100);
    }
}

TEST(Voxelize, TheSurfaceWeighsItsAreaTimesThicknessTimesDensity)
{
    const TriMesh mesh = test_meshes::bumpy_sphere(3);
    VoxelOptions options;
    options.min_fill = 0;
    const Cubes cubes =
        voxelize_surface(mesh, one({.density = 700}), 0.003, grid_of(mesh, 0.1), options);
    EXPECT_NEAR(sum_of(cubes.mass), area_of(mesh) * 0.003 * 700, 1e-6);  // float corners
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        // Thin enough that no cube is full, so fill and mass say the same.
        EXPECT_NEAR(cubes.mass[c], cubes.fill[c] * 700 * 1e-3, 1e-9 + 1e-6 * cubes.mass[c]);
        EXPECT_GT(cubes.mass[c], 0);
    }
    options.min_fill = 0.02;
    const Cubes floored =
        voxelize_surface(mesh, one({.density = 700}), 0.003, grid_of(mesh, 0.1), options);
    EXPECT_NEAR(sum_of(floored.mass), sum_of(cubes.mass), 1e-9);
    EXPECT_GE(*std::min_element(floored.fill.begin(), floored.fill.end()), 0.02 * (1 - 1e-12));
    const Cubes full = voxelize_surface(mesh, one(), 0, grid_of(mesh, 0.1), options);
    EXPECT_EQ(full.fill, std::vector<double>(full.count(), 1.0));
    EXPECT_NEAR(full.mass[0], 1, 1e-9);  // 1000 kg/m^3 in a litre
}

TEST(Voxelize, ASolidWeighsItsVolumeTimesDensity)
{
    const TriMesh mesh = test_meshes::box({0, 0, 0}, {1, 0.3, 0.2});
    const Cubes cubes =
        voxelize_solid(mesh, one({.density = 2000}), Inside::winding, 0, grid_of(mesh, 0.1), {});
    EXPECT_EQ(cubes.count(), 60u);
    EXPECT_NEAR(sum_of(cubes.mass), 120, 1e-9);
    EXPECT_EQ(cubes.fill, std::vector<double>(60, 1.0));
    // However large the cubes are against it, and however thin it is against them.
    for (const double size : {0.013, 0.07, 0.31, 0.7, 4.0}) {
        for (const double thick : {0.004, 0.024, 0.2}) {
            const TriMesh board = test_meshes::box({0, 0, 0}, {1, 0.3, thick});
            EXPECT_NEAR(sum_of(voxelize_solid(board, one({.density = 2000}), Inside::winding, 0,
                                              grid_of(board, size), {})
                                   .mass),
                        600 * thick, 1e-5 * 600 * thick)
                << thick << " m in cubes of " << size;
        }
    }
}

// However little it is, beside what densities give (60 kg), or what min_fill gives a set of
// samples.
TEST(Voxelize, AStatedMassIsKept)
{
    const TriMesh mesh = test_meshes::box({0, 0, 0}, {1, 0.3, 0.2});
    Samples samples;
    samples.matters = {{.density = 1000}};
    samples.positions = {{0.5f, 0.5f, 0.5f}};
    samples.mass = {20};
    samples.matter = {0};
    for (const double total : {5.0, 1e-5, 1e-9}) {
        VoxelOptions options;
        options.total_mass = total;
        EXPECT_NEAR(
            sum_of(
                voxelize_solid(mesh, one(), Inside::winding, 0, grid_of(mesh, 0.07), options).mass),
            total, 1e-12 * total);
        samples.total_mass = total;
        EXPECT_NEAR(voxelize_samples(samples, VoxelGrid{}, {}).mass[0], total, 1e-12 * total);
    }
}

TEST(Voxelize, SamplesGiveTheirMassAndMatterToTheirCube)
{
    Samples samples;
    samples.matters = {{.name = "wood", .density = 500, .young = 1e9, .poisson = 0.2},
                       {.name = "iron", .density = 8000, .young = 2e11, .poisson = 0.3}};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    samples.positions = {{0.1f, 0, 0}, {0.2f, 0, 0}, {0.9f, 0, 0}, {2.5f, 0, 0}, {nan, 0, 0}};
    samples.mass = {1, 2, 1, 5, 9};
    samples.matter = {0, 0, 1, 1, 0};
    VoxelGrid grid;
    VoxelOptions options;
    options.min_fill = 0;
    const Cubes cubes = voxelize_samples(samples, grid, options);
    ASSERT_EQ(cubes.count(), 2u);
    EXPECT_EQ(cubes.cell[1], Vec3i(2, 0, 0));
    EXPECT_NEAR(cubes.mass[0], 4, 1e-9);
    EXPECT_NEAR(cubes.fill[0], 3.0 / 500 + 1.0 / 8000, 1e-9);
    const double wood = 3.0 / 500, iron = 1.0 / 8000;  // m^3
    EXPECT_NEAR(cubes.young[0], (wood * 1e9 + iron * 2e11) / (wood + iron), 1e3);
    EXPECT_NEAR(cubes.poisson[0], (wood * 0.2 + iron * 0.3) / (wood + iron), 1e-9);
    EXPECT_EQ(cubes.matter[0], 0);
    EXPECT_EQ(cubes.matter[1], 1);
    EXPECT_EQ(cubes.matters[1].name, "iron");
}

TEST(Voxelize, SamplesThatDoNotSayHowThickTheyAreFillTheirCubes)
{
    // A sheet of half wood, half iron through 4 x 4 cubes of 1 m: eight full cubes of either.
    const TriMesh sheet = test_meshes::mesh_of(
        {{0, 0, 0.5f}, {2, 0, 0.5f}, {4, 0, 0.5f}, {0, 4, 0.5f}, {2, 4, 0.5f}, {4, 4, 0.5f}},
        {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}});
    const FaceMatter matter{{0, 0, 1, 1}, {{.density = 500}, {.density = 8000}}, {}};
    VoxelGrid grid;
    for (const auto by : {geometry::SampleMass::By::density, geometry::SampleMass::By::total}) {
        const Samples samples = geometry::sample_surface(sheet, matter, 2000, 1,
                                                         {.by = by, .total = 5, .thickness = 0});
        const Cubes cubes = voxelize_samples(samples, grid, {});
        ASSERT_EQ(cubes.count(), 16u);
        // The stiffness is that of full cubes either way; a given mass is shared by density.
        const double whole = 8 * 500 + 8 * 8000,
                     asked = by == geometry::SampleMass::By::total ? 5 : whole;
        EXPECT_NEAR(total_mass(cubes), asked, 1e-9 * asked);
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            EXPECT_NEAR(cubes.fill[c], 1, 1e-12);
            const double density = cubes.matter[c] == 0 ? 500 : 8000;
            EXPECT_NEAR(cubes.mass[c], density * asked / whole, 1e-9 * asked);
        }
    }
    // A given mass of a sheet of given thickness: filled by the thickness, heavy as asked.
    const Cubes thin = voxelize_samples(
        geometry::sample_surface(
            sheet, matter, 2000, 1,
            {.by = geometry::SampleMass::By::total, .total = 5, .thickness = 0.25}),
        grid, {});
    double filled = 0;
    for (const double f : thin.fill) filled += f;
    EXPECT_NEAR(filled, 0.25 * 16, 1e-5);
    EXPECT_NEAR(total_mass(thin), 5, 1e-9);
}

// A sheet to x = 4 and y = 4 touches the cubes beyond, which its upper sides belong to.
TEST(Voxelize, WithoutAThicknessCubesThatFacesTouchAreFullWhateverTheMatters)
{
    const TriMesh sheet = test_meshes::mesh_of(
        {{0, 0, 0.5f}, {2, 0, 0.5f}, {4, 0, 0.5f}, {0, 4, 0.5f}, {2, 4, 0.5f}, {4, 4, 0.5f}},
        {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}});
    const FaceMatter two{{0, 0, 1, 1}, {{.density = 500}, {.density = 8000}}, {}};
    const std::size_t count = voxelize_surface(sheet, one(), 0, VoxelGrid{}, {}).count();
    EXPECT_EQ(count, 25u);
    const Cubes cubes = voxelize_surface(sheet, two, 0, VoxelGrid{}, {});
    ASSERT_EQ(cubes.count(), count);
    EXPECT_EQ(cubes.fill, std::vector<double>(count, 1.0));
    for (std::size_t c = 0; c < count; ++c) {
        EXPECT_NEAR(cubes.mass[c], cubes.cell[c].x() < 2 ? 500 : 8000, 1e-6) << c;
    }
}

TEST(Voxelize, ASheetInASolidIsAsThickAsItIsSaidToBe)
{
    // Across the middle of 4 x 4 cubes, with nothing inside it.
    const TriMesh sheet = test_meshes::mesh_of(
        {{0, 0, 0.5f}, {4, 0, 0.5f}, {4, 4, 0.5f}, {0, 4, 0.5f}}, {{0, 1, 2}, {0, 2, 3}});
    const Cubes cubes =
        voxelize_solid(sheet, one({.density = 100}), Inside::winding, 0.25, VoxelGrid{}, {});
    ASSERT_EQ(cubes.count(), 16u);
    for (const double fill : cubes.fill) EXPECT_NEAR(fill, 0.25, 1e-12);
    EXPECT_NEAR(total_mass(cubes), 16 * 0.25 * 100, 1e-9);
}

TEST(Voxelize, SamplesOfTwoMattersShareAFullCubeByVolume)
{
    // 3 kg of either: 3 litres of wood beside one of iron, so three quarters and one of the cube.
    Samples samples;
    samples.matters = {{.density = 1000}, {.density = 3000}};
    samples.positions = {{0.2f, 0.5f, 0.5f}, {0.8f, 0.5f, 0.5f}};
    samples.mass = {3, 3};
    samples.matter = {0, 1};
    samples.bulk = 0;
    EXPECT_NEAR(voxelize_samples(samples, VoxelGrid{}, {}).mass[0], 0.75 * 1000 + 0.25 * 3000,
                1e-9);
}

// A core that fills its cubes, two of 1 m, and a coat of 0.25 m^3 in the second: the core has what
// the coat leaves. The coat states 5 kg, the core goes by its density.
TEST(Voxelize, SetsOfSamplesKeepTheirMattersAndMasses)
{
    Samples core, coat;
    core.matters = {{.name = "core", .density = 100, .young = 1e5}};
    core.positions = {{0.5f, 0.5f, 0.5f}, {1.2f, 0.5f, 0.5f}, {1.4f, 0.5f, 0.5f}};
    core.mass = {1, 1, 1};
    core.matter = {0, 0, 0};
    core.bulk = 0;
    coat.matters = {{.name = "coat", .density = 800, .young = 9e5}};
    coat.positions = {{1.9f, 0.5f, 0.5f}};
    coat.mass = {200};
    coat.matter = {0};
    coat.total_mass = 5;
    const Samples* const sets[] = {&core, &coat};
    const Cubes cubes = voxelize_samples(sets, VoxelGrid{}, {});
    ASSERT_EQ(cubes.count(), 2u);
    EXPECT_NEAR(cubes.mass[0], 100, 1e-9);
    EXPECT_NEAR(cubes.mass[1], 0.75 * 100 + 5, 1e-9);
    EXPECT_NEAR(cubes.young[1], 0.75 * 1e5 + 0.25 * 9e5, 1e-4);
    EXPECT_EQ(cubes.matter[1], 0u) << "the core is the heavier";
    EXPECT_EQ(cubes.matters.at(1).name, "coat");
    // One set is what it was alone.
    const Cubes alone = voxelize_samples(coat, VoxelGrid{}, {});
    EXPECT_NEAR(alone.mass[0], 5, 1e-12);
    EXPECT_NEAR(alone.matters[0].density, 800, 0);
}

// A block fills its cube, and a coat that would have the rest of it states 5 kg.
TEST(Voxelize, TheMassOfASetOfSamplesWithoutRoomIsAdded)
{
    Samples block, coat;
    block.matters = {{.density = 100, .young = 1e5}};
    block.positions = {{0.5f, 0.5f, 0.5f}};
    block.mass = {100};
    block.matter = {0};
    coat.matters = {{.density = 800, .young = 9e5}};
    coat.positions = {{0.2f, 0.5f, 0.5f}, {0.9f, 0.5f, 0.5f}};
    coat.mass = {2.5, 2.5};
    coat.matter = {0, 0};
    coat.bulk = 0;
    coat.total_mass = 5;
    const Samples* const sets[] = {&block, &coat};
    const Cubes cubes = voxelize_samples(sets, VoxelGrid{}, {});
    ASSERT_EQ(cubes.count(), 1u);
    EXPECT_NEAR(cubes.mass[0], 105, 1e-9);
    EXPECT_NEAR(cubes.fill[0], 1, 1e-12);
    EXPECT_NEAR(cubes.young[0], 1e5, 1e-3);
}

TEST(Voxelize, ACubeThatIsMerelyTouchedTakesAfterANeighbour)
{
    Cubes cubes = geometry::solid_cubes({{0, 0, 0}, {1, 1, 1}, {5, 0, 0}}, 1);
    const std::vector<Matter> matters{{.young = 1}, {.young = 2}};
    const std::vector<geometry::Deposit> deposits{{0, 1, 0.5}};
    fill_cubes(cubes, matters, deposits, {});
    // In order (0, 0, 0), (5, 0, 0), which has no neighbour and takes the first matter, (1, 1, 1).
    EXPECT_EQ(cubes.young, (std::vector<double>{2, 1, 2}));
    EXPECT_EQ(cubes.matter, (std::vector<std::uint16_t>{1, 0, 1}));
}

TEST(Voxelize, MaterialsFollowTheFacesAndTheNearestFaceInside)
{
    // Two boxes with a gap of two cubes between them, of two groups.
    TriMesh mesh = test_meshes::both(test_meshes::box({0, 0, 0}, {1, 1, 1}),
                                     test_meshes::box({1.2, 0, 0}, {2.2, 1, 1}));
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    topology->groups = {"soft_part", "hard_part"};
    topology->group.assign(24, 0);
    std::fill(topology->group.begin() + 12, topology->group.end(), std::uint16_t{1});
    mesh.topology = topology;
    MatterRule rule;
    rule.match = MatterRule::Match::group;
    rule.name = "hard*";
    rule.matter.young = 1e9;
    const FaceMatter matter = assign_matter(mesh, std::vector{rule}, {});
    ASSERT_EQ(matter.matters.size(), 2u);
    for (const bool solid : {false, true}) {
        const Cubes cubes =
            solid ? voxelize_solid(mesh, matter, Inside::winding, 0, grid_of(mesh, 0.1), {})
                  : voxelize_surface(mesh, matter, 0.01, grid_of(mesh, 0.1), {});
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            if (cubes.cell[c].x() < 11) {
                EXPECT_NEAR(cubes.young[c], 1e6, 1);
            }
            if (cubes.cell[c].x() >= 11) {
                EXPECT_NEAR(cubes.young[c], 1e9, 1e3);
            }
        }
    }
}

TEST(Voxelize, StopsBeforeTheMemoryAndNamesASizeThatFits)
{
    const TriMesh mesh = test_meshes::bumpy_sphere(3);
    VoxelOptions options;
    options.max_cubes = 5000;
    for (const bool solid : {false, true}) {
        const auto count = [&](double size) {
            const VoxelGrid grid = grid_of(mesh, size);
            return (solid ? voxelize_solid(mesh, one(), Inside::winding, 0, grid, options)
                          : voxelize_surface(mesh, one(), 0, grid, options))
                .count();
        };
        try {
            count(0.001);
            FAIL();
        } catch (const std::invalid_argument& e) {
            const std::string text = e.what();
            const auto at = text.find("; cubes of ");
            ASSERT_NE(at, std::string::npos) << text;
            const double suggestion = std::stod(text.substr(at + 11));
            EXPECT_GT(count(suggestion), 1000u);  // throws when it does not fit
        }
    }
}

TEST(Voxelize, FourThousandCubesAlongAnAxisCostWhatTheyHold)
{
    const TriMesh cable =
        test_meshes::mesh_of({{0, 0, 0}, {4.096f, 4.0f, 4.05f}, {0, 0.0004f, 0}}, {{0, 1, 2}});
    const Cubes cubes = voxelize_surface(cable, one(), 1e-4, grid_of(cable, 0.001), {});
    EXPECT_EQ((cubes.cell.back() - cubes.cell.front()).maxCoeff(), 4095);
    EXPECT_LT(cubes.count(), 20000u);
}

TEST(Voxelize, SaysWhenThereIsNothing)
{
    const VoxelGrid grid;
    EXPECT_THROW(voxelize_surface({}, one(), 0, grid, {}), std::invalid_argument);
    EXPECT_THROW(voxelize_solid({}, one(), Inside::winding, 0, grid, {}), std::invalid_argument);
    Samples none;
    none.matters = {{}};
    EXPECT_THROW(voxelize_samples(none, grid, {}), std::invalid_argument);
}

TEST(Voxelize, ASingleTriangleAndAPointAndHugeCoordinatesAreFine)
{
    const TriMesh triangle = test_meshes::mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    const TriMesh point = test_meshes::mesh_of({{3, 3, 3}}, {{0, 0, 0}});
    for (const bool solid : {false, true}) {
        const auto voxelize = [&](const TriMesh& mesh, double size) {
            const VoxelGrid grid = grid_of(mesh, size);
            return solid ? voxelize_solid(mesh, one(), Inside::winding, 0.001, grid, {})
                         : voxelize_surface(mesh, one(), 0.001, grid, {});
        };
        const Cubes flat = voxelize(triangle, 0.1);
        EXPECT_GE(flat.count(), 50u);
        EXPECT_LE(flat.count(), 65u);
        const Cubes dot = voxelize(point, 0.1);
        EXPECT_EQ(dot.count(), 1u);
        EXPECT_GT(dot.mass[0], 0);
        TriMesh huge = test_meshes::bumpy_sphere(2);
        for (Vec3f& p : huge.positions) p *= 1e9f;
        const Cubes big = voxelize(huge, 1e8);
        EXPECT_GT(big.count(), 500u);
        EXPECT_TRUE(std::isfinite(sum_of(big.mass)));
    }
}

TEST(Voxelize, GivesTheSameBytesOnAnyNumberOfThreads)
{
    const TriMesh mesh = test_meshes::bumpy_sphere(5);
    const VoxelGrid grid = grid_of(mesh, 0.05);
    std::vector<double> masses;
    for (const unsigned threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        auto now = voxelize_surface(mesh, one(), 0.003, grid, {}).mass;
        const auto solid = voxelize_solid(mesh, one(), Inside::winding, 0, grid, {}).mass;
        now.insert(now.end(), solid.begin(), solid.end());
        if (masses.empty()) masses = now;
        EXPECT_EQ(now, masses);
    }
}

}  // namespace
