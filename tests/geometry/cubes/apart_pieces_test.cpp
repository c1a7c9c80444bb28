// Pieces that share cells and have cubes of their own: each keeps what is its own.

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/glued_pieces.hpp"
#include "geometry/cubes/local_matter.hpp"
#include "geometry/cubes/mean_attributes.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "tests/geometry/meshes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace apart_pieces {
namespace {

using namespace geometry;

// A tenth of a metre, so that rounding takes faces off the planes between quarters of cubes.
constexpr double size = 0.1;
constexpr double depth = 1.5, side = 2;  // of a block, in cubes

TriMesh block_at(double x)
{
    return meshes::moved(geometry::box(size * Vec3(depth, side, side), {1, 1, 1}),
                         size * Vec3(x + depth / 2, side / 2, side / 2));
}

// The left one ends at x0, the right one begins `gap` further on, in cubes.
TriMesh two_blocks(double x0, double gap)
{
    const TriMesh left = block_at(x0 - depth), right = block_at(x0 + gap);
    const TriMesh* const all[] = {&left, &right};
    return geometry::merge(all);
}

// The left block light and soft, the right one heavy and stiff.
FaceMatter two_matters(const TriMesh& mesh)
{
    FaceMatter out;
    const std::size_t faces = mesh.triangles().size();
    for (std::size_t t = 0; t < faces; ++t) out.face.push_back(t < faces / 2 ? 0 : 1);
    out.matters = {{.density = 1000, .young = 1e6}, {.density = 8000, .young = 1e9}};
    return out;
}

const VoxelGrid lattice{size, Vec3::Zero(), Vec3i::Zero()};

// Of min_fill 0, so that each has its own mass exactly.
const VoxelOptions apart{.min_fill = 0, .pieces = NearPieces::apart};

std::vector<std::uint32_t> labels(const Cubes& cubes)
{
    return find_components(cubes, Connectivity::face).label;
}

std::uint32_t leftmost(const Cubes& cubes)
{
    std::uint32_t out = 0;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (cubes.cell[c].x() < cubes.cell[out].x()) out = c;
    }
    return out;
}

void expect_own_matter(const Cubes& cubes, double volume)
{
    const std::vector<std::uint32_t> label = labels(cubes);
    const std::uint32_t left = label[leftmost(cubes)];
    double mass[2] = {0, 0};
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const bool right = label[c] != left;
        mass[right ? 1 : 0] += cubes.mass[c];
        EXPECT_NEAR(cubes.young[c], right ? 1e9 : 1e6, 1e-3) << c;
    }
    EXPECT_NEAR(mass[0], 1000 * volume, 1e-4 * 1000 * volume);
    EXPECT_NEAR(mass[1], 8000 * volume, 1e-4 * 8000 * volume);
}

// Ends of the left block and gaps, in cubes: on planes between quarters and elsewhere, and as
// narrow as keeps them apart.
constexpr std::pair<double, double> places[] = {{2, 0.5},    {2.1, 0.5}, {2.25, 0.5}, {2.4, 0.5},
                                                {2.75, 0.5}, {2.9, 0.5}, {2.3, 0.2},  {2.35, 0.15},
                                                {2.6, 0.15}, {3.3, 0.2}, {7.1, 0.15}};

TEST(ApartPieces, OfTwoMaterialsKeepTheirOwn)
{
    constexpr double thickness = 0.001, area = 2 * size * size * (side * side + 2 * side * depth);
    constexpr double volume = size * size * size * depth * side * side;
    for (const auto& [x0, gap] : places) {
        SCOPED_TRACE(fmt::format("end {}, gap {}", x0, gap));
        const TriMesh mesh = two_blocks(x0, gap);
        const FaceMatter matter = two_matters(mesh);
        expect_own_matter(voxelize_solid(mesh, matter, Inside::winding, 0, lattice, apart), volume);
        expect_own_matter(voxelize_surface(mesh, matter, thickness, lattice, apart),
                          thickness * area);
    }
}

TEST(ApartPieces, AreNotToldToMoveAsOne)
{
    for (const auto& [x0, gap] : places) {
        const TriMesh mesh = two_blocks(x0, gap);
        const Cubes cubes =
            voxelize_solid(mesh, {{}, {{}}, {}}, Inside::winding, 0, lattice, apart);
        ASSERT_EQ(find_components(cubes, Connectivity::corner).count(), 2u);
        EXPECT_EQ(find_glued_pieces(mesh, find_pieces(mesh), cubes, 0).count, 0u)
            << x0 << " " << gap;
    }
}

TEST(ApartPieces, AreFoundByAPointInTheirQuarters)
{
    const TriMesh mesh = two_blocks(2.25, 0.5);
    const Cubes cubes = voxelize_solid(mesh, {{}, {{}}, {}}, Inside::winding, 0, lattice, apart);
    const std::vector<std::uint32_t> label = labels(cubes);
    const std::uint32_t left = label[leftmost(cubes)];
    const auto at = [&](double x) { return nearest_cube(cubes, size * Vec3(x, 0.5, 0.5)); };
    // Both blocks have a cube in the cell from 2 to 3. Between them the nearer one counts.
    for (const double x : {1.5, 2.1, 2.24, 2.4}) EXPECT_EQ(label[at(x).cube], left) << x;
    for (const double x : {2.6, 2.76, 2.9, 3.5}) EXPECT_NE(label[at(x).cube], left) << x;
    EXPECT_EQ(at(2.9).distance, 0);
    EXPECT_NEAR(at(2.4).distance, 0.15 * size, 1e-6 * size);
}

// The left block is cold, the right one hot. A cube has all of its value from its own block.
void expect_own_heat(const Cubes& cubes)
{
    const std::vector<std::uint32_t> label = labels(cubes);
    const std::uint32_t left = label[leftmost(cubes)];
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        EXPECT_NEAR(cubes.attributes[0].values[c], label[c] == left ? 0 : 1, 1e-12) << c;
    }
}

TEST(ApartPieces, HaveAttributesOfTheirOwn)
{
    for (const auto& [x0, gap] : places) {
        SCOPED_TRACE(fmt::format("end {}, gap {}", x0, gap));
        TriMesh mesh = two_blocks(x0, gap);
        const std::size_t vertices = mesh.positions.size();
        Attribute heat{"heat", "K", std::vector<float>(vertices, 0.f)};
        for (std::size_t v = vertices / 2; v < vertices; ++v) heat.values[v] = 1;
        mesh.attributes = {heat};
        const auto wanted = chosen_attributes("heat", mesh.attributes);
        const FaceMatter one{{}, {{}}, {}};
        expect_own_heat(with_means_of_solid(
            voxelize_solid(mesh, one, Inside::winding, 0, lattice, apart), mesh, wanted));
        expect_own_heat(with_means_of_surface(voxelize_surface(mesh, one, 0.001, lattice, apart),
                                              mesh, wanted));
    }
}

TEST(ApartPieces, HaveTheMeanOfAPlaceOverTheirOwnQuarters)
{
    const TriMesh mesh = two_blocks(2.25, 0.5);
    const Cubes cubes = voxelize_solid(mesh, {{}, {{}}, {}}, Inside::winding, 0, lattice, apart);
    const std::vector<double> x =
        cube_means(cubes, [](const Vec3& p, std::size_t) { return p.x() / size; });
    const std::vector<std::uint32_t> label = labels(cubes);
    const std::uint32_t left = label[leftmost(cubes)];
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (cubes.cell[c].x() != 2) continue;
        EXPECT_NEAR(x[c], label[c] == left ? 2.125 : 2.875, 1e-12);
    }
}

}  // namespace
}  // namespace apart_pieces
