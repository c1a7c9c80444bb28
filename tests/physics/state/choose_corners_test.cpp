#include "physics/state/choose_corners.hpp"

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace choose_corners {
namespace {

using namespace physics;
using geometry::Cubes;
using geometry::TriMesh;
using geometry::Vec3i;

// A plate up to y = 0.25 m and a block from y = 0.75 m on, in cubes of 1 m: both have a cube in the
// lowest cells.
TriMesh plate_and_block()
{
    TriMesh plate = meshes::moved(geometry::box({4, 0.25, 4}, {1, 1, 1}), {2, 0.125, 2});
    TriMesh block = meshes::moved(geometry::box({4, 3.25, 4}, {1, 1, 1}), {2, 0.75 + 1.625, 2});
    const auto called = [](TriMesh& mesh, const char* name) {
        auto topology = *mesh.topology;
        topology.groups = {name};
        topology.group.assign(topology.triangles.size(), 0);
        mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    };
    called(plate, "plate");
    called(block, "block");
    const TriMesh* const all[] = {&plate, &block};
    return geometry::merge(all);
}

Cubes cubes_of(const TriMesh& mesh)
{
    return voxelize_solid(mesh, {{}, {{}}, {}}, geometry::Inside::winding, 0,
                          {1, Vec3::Zero(), Vec3i::Zero()},
                          {.pieces = geometry::NearPieces::apart});
}

// Bodies that have one of the corners, by their height: 0 the plate, 1 the block.
std::set<int> bodies_of(const Cubes& cubes, const std::vector<std::uint32_t>& corners)
{
    const auto found = find_components(cubes, geometry::Connectivity::face);
    const std::uint32_t block = nearest_cube(cubes, {2, 3, 2}).cube;
    std::set<int> out;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (const auto k : cubes.corners[c]) {
            if (!std::binary_search(corners.begin(), corners.end(), k)) continue;
            out.insert(found.label[c] == found.label[block] ? 1 : 0);
        }
    }
    return out;
}

TEST(ChooseCorners, OfPiecesInOneCellOnlyThoseInTheRegion)
{
    const TriMesh mesh = plate_and_block();
    const Cubes cubes = cubes_of(mesh);
    ASSERT_EQ(find_components(cubes, geometry::Connectivity::corner).count(), 2u);
    const std::set<int> plate{0}, block{1}, both{0, 1};
    EXPECT_EQ(bodies_of(cubes, corners_below(cubes, 0.3)), plate);
    EXPECT_EQ(bodies_of(cubes, corners_below(cubes, 0.8)), both);
    EXPECT_EQ(bodies_of(cubes, corners_at_end(cubes, 1, End::low, 0)), plate);
    EXPECT_EQ(bodies_of(cubes, corners_at_end(cubes, 1, End::high, 0)), block);
    EXPECT_EQ(bodies_of(cubes, corners_at_end(cubes, 1, End::both, 0)), both);
    EXPECT_EQ(bodies_of(cubes, corners_at_end(cubes, 0, End::low, 0)), both);
    EXPECT_EQ(bodies_of(cubes, corners_at_end(cubes, 1, End::low, 1)), both);
    EXPECT_EQ(bodies_of(cubes, corners_near_material(cubes, mesh, "plate", 0.3)), plate);
    EXPECT_EQ(bodies_of(cubes, corners_near_material(cubes, mesh, "plate", 1)), both);
}

TEST(ChooseCorners, AtBothEndsAreThoseAtEither)
{
    const Cubes cubes = geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, 1);
    const auto at = [&](End end) { return corners_at_end(cubes, 0, end, 1).size(); };
    EXPECT_EQ(at(End::low), 8u);
    EXPECT_EQ(at(End::high), 8u);
    EXPECT_EQ(at(End::both), 16u);
    EXPECT_EQ(corners_at_end(cubes, 0, End::both, 3).size(), cubes.corner_count());
}

}  // namespace
}  // namespace choose_corners
