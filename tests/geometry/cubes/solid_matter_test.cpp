// What cubes are made of where a model has several matters: by where they lie.

#include "geometry/cubes/closed_parts.hpp"
#include "geometry/cubes/sample_volume.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

namespace solid_matter {
namespace {

using namespace geometry;
using test_meshes::both;
using test_meshes::box;

// The first `first` faces are of group 0 and matter 0, the others of 1.
FaceMatter two_matters(const TriMesh& mesh, std::size_t first, const Matter& a, const Matter& b)
{
    FaceMatter out;
    out.face.assign(mesh.triangles().size(), 1);
    std::fill(out.face.begin(), out.face.begin() + std::ptrdiff_t(first), std::uint16_t{0});
    out.matters = {a, b};
    return out;
}

VoxelGrid grid_of(const TriMesh& mesh, double size)
{
    return fit_grid(triangle_bounds(mesh), size);
}

// Three vertices of its own for each triangle, as in STL files.
TriMesh split(const TriMesh& mesh)
{
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
    for (const Triangle& t : mesh.triangles()) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const auto v : t) positions.push_back(mesh.positions[v]);
        triangles.push_back({first, first + 1, first + 2});
    }
    return test_meshes::mesh_of(positions, triangles);
}

TriMesh scaled(TriMesh mesh, float factor, const Vec3f& offset)
{
    for (Vec3f& p : mesh.positions) p = factor * p + offset;
    return mesh;
}

// Lower, on the same bottom.
TriMesh scaled_y(TriMesh mesh, float factor)
{
    const auto low = static_cast<float>(bounds(mesh).lo.y());
    for (Vec3f& p : mesh.positions) p.y() = low + factor * (p.y() - low);
    return mesh;
}

double volume_of(const TriMesh& mesh)
{
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles()) {
        const Vec3 p = mesh.positions[a].cast<double>(), q = mesh.positions[b].cast<double>();
        sum += p.dot(q.cross(mesh.positions[c].cast<double>())) / 6;
    }
    return sum;
}

TEST(SolidMatter, ABoneInFleshWeighsWhatItShould)
{
    // 1000 (1 - 0.4^3) + 3000 0.4^3 = 1128 kg, on grids that fit the bone and that do not.
    const TriMesh mesh = both(box({0, 0, 0}, {1, 1, 1}), box({0.3, 0.3, 0.3}, {0.7, 0.7, 0.7}));
    const FaceMatter matter = two_matters(mesh, 12, {.density = 1000}, {.density = 3000});
    for (const TriMesh& m : {mesh, split(mesh)}) {
        for (const double size : {0.1, 0.09, 0.07, 0.13}) {
            const Cubes cubes =
                voxelize_solid(m, matter, Inside::winding, 0, grid_of(mesh, size), {});
            EXPECT_NEAR(total_mass(cubes), 1128, size == 0.1 ? 1e-6 : 0.02 * 1128) << size;
        }
    }
}

TEST(SolidMatter, BoxesThatTouchWeighWhatTheyShould)
{
    // Half a cubic metre each, 1000 and 3000 kg / m^3.
    const TriMesh mesh = both(box({0, 0, 0}, {0.5, 1, 1}), box({0.5, 0, 0}, {1, 1, 1}));
    const FaceMatter matter =
        two_matters(mesh, 12, {.density = 1000, .young = 1}, {.density = 3000, .young = 1e6});
    for (const TriMesh& m : {mesh, split(mesh)}) {
        for (const double size : {0.1, 0.11, 0.07, 0.05}) {
            const Cubes cubes =
                voxelize_solid(m, matter, Inside::winding, 0, grid_of(mesh, size), {});
            EXPECT_NEAR(total_mass(cubes), 2000, 0.01 * 2000) << size;
            for (std::size_t c = 0; c < cubes.count() && size == 0.1; ++c) {
                EXPECT_NEAR(cubes.young[c], cubes.cell[c].x() < 5 ? 1 : 1e6, 1e-6);
            }
        }
    }
}

TEST(SolidMatter, StiffnessIsSharedByVolumeWithinACube)
{
    // The cubes of 0.2 m in the middle are half of either.
    const TriMesh mesh = both(box({0, 0, 0}, {0.5, 1, 1}), box({0.5, 0, 0}, {1, 1, 1}));
    const FaceMatter matter =
        two_matters(mesh, 12, {.density = 1000, .young = 1e5, .stiffness_damping = 0.1},
                    {.density = 3000, .young = 3e5});
    const Cubes cubes = voxelize_solid(mesh, matter, Inside::winding, 0, grid_of(mesh, 0.2), {});
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (cubes.cell[c].x() != 2) continue;
        EXPECT_NEAR(cubes.young[c], 2e5, 1e-6);
        EXPECT_NEAR(cubes.mass[c], 2000 * 0.008, 1e-9);
        EXPECT_NEAR(cubes.stiffness_damping[c], 0.1 * 1e5 / 4e5, 1e-12);
    }
}

TEST(SolidMatter, OfNestedPartsTheInnermostCounts)
{
    // Spheres off each other's centres, named in any order, against the volumes of their facets.
    const TriMesh sphere = test_meshes::icosphere(3);
    const double one = volume_of(sphere);
    const TriMesh outer = scaled(sphere, 1, {0, 0, 0}), middle = scaled(sphere, 0.6f, {0.2f, 0, 0}),
                  inner = scaled(sphere, 0.3f, {0.3f, 0.1f, 0});
    const std::size_t n = sphere.triangles().size();
    const double expected = one * (1000 * (1 - 0.216) + 2000 * (0.216 - 0.027) + 5000 * 0.027);
    for (const bool reversed : {false, true}) {
        const TriMesh mesh =
            reversed ? both(both(inner, middle), outer) : both(both(outer, middle), inner);
        FaceMatter matter;
        matter.matters = {{.density = 1000}, {.density = 2000}, {.density = 5000}};
        for (std::size_t f = 0; f < 3 * n; ++f) {
            matter.face.push_back(static_cast<std::uint16_t>(reversed ? 2 - f / n : f / n));
        }
        const Cubes cubes =
            voxelize_solid(mesh, matter, Inside::winding, 0, grid_of(mesh, 0.08), {});
        EXPECT_NEAR(total_mass(cubes), expected, 0.005 * expected);
    }
}

TEST(SolidMatter, AHollowIsNotFilled)
{
    // A bone that is inside out takes its volume away, and so does any by parity.
    const TriMesh flesh = box({0, 0, 0}, {1, 1, 1}), bone = box({0.3, 0.3, 0.3}, {0.7, 0.7, 0.7});
    const TriMesh hollow = both(flesh, test_meshes::inside_out(bone));
    const FaceMatter matter = two_matters(hollow, 12, {.density = 1000}, {.density = 3000});
    const Cubes cubes =
        voxelize_solid(hollow, matter, Inside::winding, 0, grid_of(hollow, 0.05), {});
    EXPECT_NEAR(total_mass(cubes), 936, 1e-6 * 936);
    for (const std::uint16_t m : cubes.matter) EXPECT_EQ(m, 0);
    const Cubes by_parity =
        voxelize_solid(both(flesh, bone), matter, Inside::parity, 0, grid_of(hollow, 0.05), {});
    EXPECT_NEAR(total_mass(by_parity), 936, 1e-6 * 936);
}

// Water cut into the wall of its glass, as artists make it: larger than the hollow, so that the
// wall's inner faces are the smallest part around most of it.
TEST(SolidMatter, AHollowClaimsNothingOfWhatLiesInIt)
{
    const TriMesh glass = both(box({0, 0, 0}, {1, 1, 1}),
                               test_meshes::inside_out(box({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8})));
    const TriMesh water = box({0.15, 0.15, 0.15}, {0.85, 0.85, 0.85});
    const double volume = 0.7 * 0.7 * 0.7, expected = 2500 * (1 - volume) + 1000 * volume;
    for (const bool water_first : {false, true}) {
        const TriMesh mesh = water_first ? both(water, glass) : both(glass, water);
        const Matter of_glass{.density = 2500}, of_water{.density = 1000};
        const FaceMatter matter = water_first ? two_matters(mesh, 12, of_water, of_glass)
                                              : two_matters(mesh, 24, of_glass, of_water);
        const Cubes cubes =
            voxelize_solid(mesh, matter, Inside::winding, 0, grid_of(mesh, 0.05), {});
        EXPECT_NEAR(total_mass(cubes), expected, 1e-6 * expected) << water_first;
        const Samples samples = sample_volume(mesh, matter, Inside::winding, 4000, 1, SampleMass{});
        const auto waters = std::count(samples.matter.begin(), samples.matter.end(),
                                       std::uint16_t(water_first ? 0 : 1));
        EXPECT_NEAR(double(waters) / 4000, volume, 0.03) << water_first;  // 4 sigma
    }
}

TEST(SolidMatter, APartOfSeveralMattersFollowsItsFaces)
{
    // A closed box, the face at x = 1 of another matter, and a bone inside that is all of its own.
    const TriMesh mesh = both(box({0, 0, 0}, {1, 1, 1}), box({0.4, 0.4, 0.4}, {0.6, 0.6, 0.6}));
    FaceMatter matter;
    matter.matters = {{.young = 1e5}, {.young = 2e5}, {.young = 4e5}};
    for (std::size_t f = 0; f < 24; ++f) {
        bool right = f < 12;
        for (const auto v : mesh.triangles()[f]) right = right && mesh.positions[v].x() == 1;
        matter.face.push_back(static_cast<std::uint16_t>(f >= 12 ? 2 : right ? 1 : 0));
    }
    const Cubes cubes = voxelize_solid(mesh, matter, Inside::winding, 0, grid_of(mesh, 0.1), {});
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const Vec3i& at = cubes.cell[c];
        const bool in_bone = (at.array() >= 4).all() && (at.array() <= 5).all();
        if (in_bone) {
            EXPECT_NEAR(cubes.young[c], 4e5, 1e-6) << at.transpose();
        } else if (at.x() == 8 && (at.array() >= 2).all() && at.y() <= 7 && at.z() <= 7) {
            EXPECT_NEAR(cubes.young[c], 2e5, 1e-6);  // nearest to the face at x = 1
        } else if (at.x() <= 2) {
            EXPECT_NEAR(cubes.young[c], 1e5, 1e-6);
        }
    }
}

TEST(SolidMatter, PartsAreFoundByWhatClosesThem)
{
    const TriMesh one = box({0, 0, 0}, {1, 1, 1}), two = box({1, 0, 0}, {3, 1, 1});
    TriMesh mesh = both(one, two);
    const VoxelGrid grid{1, Vec3::Zero(), Vec3i::Zero()};
    const auto parts_of = [&](const TriMesh& m, const FaceMatter& matter) {
        return find_closed_parts(to_lattice(m, grid), matter);
    };
    const FaceMatter matter = two_matters(mesh, 12, {}, {.density = 2});
    const auto parts = parts_of(mesh, matter);
    ASSERT_EQ(parts.size(), 2u);
    EXPECT_NEAR(parts[0].volume, 2, 1e-12);  // the largest first
    EXPECT_NEAR(parts[1].volume, 1, 1e-12);
    EXPECT_TRUE(parts[0].one_matter && parts[1].one_matter);
    // With one face of the other matter they are closed only together.
    FaceMatter mixed = matter;
    mixed.face[3] = 1;
    const auto joined = parts_of(mesh, mixed);
    ASSERT_EQ(joined.size(), 1u);
    EXPECT_FALSE(joined[0].one_matter);
    EXPECT_NEAR(joined[0].volume, 3, 1e-12);
    // A hole opens the one that has it.
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    topology->triangles.erase(topology->triangles.begin() + 15);
    mesh.topology = topology;
    FaceMatter cut = matter;
    cut.face.pop_back();
    EXPECT_EQ(parts_of(mesh, cut).size(), 1u);
    EXPECT_TRUE(parts_of({}, {{}, {{}}, {}}).empty());
}

TEST(SolidMatter, AnOpenMeshHasTheMattersOfItsFacesByTheirAreas)
{
    // One cube around a box without its last triangle: 6 of the 11 that are left are of 1000.
    TriMesh mesh = box({0, 0, 0}, {1, 1, 1});
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    topology->triangles.pop_back();
    mesh.topology = topology;
    const auto mass = [&](double second) {
        const FaceMatter matter = two_matters(mesh, 6, {.density = 1000}, {.density = second});
        return total_mass(voxelize_solid(mesh, matter, Inside::winding, 0, grid_of(mesh, 1.0), {}));
    };
    EXPECT_NEAR(mass(3000) / mass(1000), (6 + 5 * 3) / 11.0, 1e-6);
}

TEST(SolidMatter, ASheetInASolidKeepsItsOwn)
{
    // An open sheet of 10 mm in the lower half of a layer of cubes.
    const TriMesh sheet = test_meshes::mesh_of(
        {{0.2f, 0.53f, 0.2f}, {0.2f, 0.53f, 0.8f}, {0.8f, 0.53f, 0.8f}, {0.8f, 0.53f, 0.2f}},
        {{0, 1, 2}, {0, 2, 3}});
    const TriMesh mesh = both(box({0, 0, 0}, {1, 1, 1}), sheet);
    const FaceMatter matter = two_matters(mesh, 12, {.density = 1000}, {.density = 5000});
    const Cubes cubes = voxelize_solid(mesh, matter, Inside::winding, 0.01, grid_of(mesh, 0.1), {});
    const double expected = 1000 + 4000 * 0.36 * 0.01;
    EXPECT_NEAR(total_mass(cubes), expected, 1e-6 * expected);
}

// A core that stands on the bottom of its casing: their bottoms are the same triangles.
TEST(SolidMatter, ACoreThatSharesTrianglesWithItsCasingIsOneOfItsOwn)
{
    const TriMesh casing = box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}), core = scaled_y(casing, 0.5f);
    for (const bool core_first : {false, true}) {
        const TriMesh mesh = core_first ? both(core, casing) : both(casing, core);
        const Matter light{.density = 1000}, heavy{.density = 8000};
        const FaceMatter matter =
            two_matters(mesh, 12, core_first ? heavy : light, core_first ? light : heavy);
        const Cubes cubes =
            voxelize_solid(mesh, matter, Inside::winding, 0, grid_of(mesh, 0.1), {});
        EXPECT_NEAR(total_mass(cubes), 4500, 200) << core_first;
        const Samples samples = sample_volume(mesh, matter, Inside::winding, 4000, 1, SampleMass{});
        const auto in_core = std::count(samples.matter.begin(), samples.matter.end(),
                                        std::uint16_t(core_first ? 0 : 1));
        EXPECT_NEAR(double(in_core) / 4000, 0.5, 0.03) << core_first;
    }
}

// Half of the casing's faces look in. What is near the core but outside it is the casing's.
TEST(SolidMatter, SamplesKnowACasingSomeOfWhoseFacesLookIn)
{
    const TriMesh flesh = box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}),
                  bone = scaled(flesh, 0.5f, {0, 0, 0});
    TriMesh mesh = both(flesh, bone);
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    for (std::size_t t = 0; t < 6; ++t)
        std::swap(topology->triangles[t][0], topology->triangles[t][1]);
    mesh.topology = topology;
    const FaceMatter matter = two_matters(mesh, 12, {.density = 1000}, {.density = 3000});
    const Samples samples = sample_volume(mesh, matter, Inside::winding, 4000, 1, SampleMass{});
    const auto bones = std::count(samples.matter.begin(), samples.matter.end(), std::uint16_t{1});
    EXPECT_NEAR(double(bones) / 4000, 0.125, 0.02);
}

}  // namespace
}  // namespace solid_matter
