#include "geometry/cubes/bodies.hpp"

#include "geometry/cubes/body_finder.hpp"
#include "geometry/cubes/components.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/mesh/split.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace {

using geometry::bodies_of_groups;
using geometry::bodies_of_pieces;
using geometry::Connectivity;
using geometry::Cubes;
using geometry::FaceBodies;
using geometry::Inside;
using geometry::no_index;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3i;
using geometry::VoxelGrid;

TriMesh box_at(const Vec3& lo, const Vec3& hi)
{
    return meshes::moved(geometry::box(hi - lo, {1, 1, 1}), 0.5 * (lo + hi));
}

TriMesh merged(const std::vector<TriMesh>& meshes)
{
    std::vector<const TriMesh*> all;
    for (const TriMesh& mesh : meshes) all.push_back(&mesh);
    return geometry::merge(all);
}

TriMesh turned_inside_out(TriMesh mesh)
{
    geometry::MeshTopology topology = *mesh.topology;
    for (auto& t : topology.triangles) std::swap(t[1], t[2]);
    topology.normal_triangles.clear();
    mesh.normals.clear();
    mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return mesh;
}

const VoxelGrid unit{1, Vec3::Zero(), Vec3i::Zero()};

Cubes solid(const TriMesh& mesh)
{
    return voxelize_solid(mesh, {{}, {{}}, {}}, Inside::winding, 0, unit, {});
}

Cubes cubes_of(const TriMesh& mesh, const FaceBodies& bodies)
{
    std::vector<Cubes> all;
    for (const auto& part : geometry::split(mesh, bodies.of, bodies.count)) {
        all.push_back(solid(part.mesh));
    }
    return geometry::side_by_side(all);
}

// The cubes of each vertex's piece of the mesh move up by as much as the piece's number, counted
// from 1; whether all vertices do.
void expect_each_piece_follows_its_body(const std::vector<TriMesh>& pieces)
{
    const TriMesh mesh = merged(pieces);
    const Cubes cubes = cubes_of(mesh, bodies_of_pieces(mesh));
    const auto label = find_components(cubes, Connectivity::corner).label;
    ASSERT_EQ(find_components(cubes, Connectivity::corner).count(), pieces.size());
    const geometry::Binding binding = bind(mesh, cubes);
    std::vector<std::uint32_t> bodies;
    std::size_t v = 0;
    for (const TriMesh& piece : pieces) {
        const std::uint32_t first = label[binding.used[binding.cube[v]]];
        bodies.push_back(first);
        for (const std::size_t end = v + piece.positions.size(); v < end; ++v) {
            EXPECT_EQ(label[binding.used[binding.cube[v]]], first) << "vertex " << v;
            EXPECT_GE(binding.local[v].minCoeff(), -1e-3f);
            EXPECT_LE(binding.local[v].maxCoeff(), 1 + 1e-3f);
        }
    }
    std::sort(bodies.begin(), bodies.end());
    EXPECT_EQ(std::unique(bodies.begin(), bodies.end()), bodies.end()) << "two go with one body";
}

TEST(Bodies, PiecesThatTouchOrOverlapShareNoCorner)
{
    // In a face of the grid, within a cube, and overlapping.
    for (const double top : {2.0, 2.3, 2.7}) {
        const TriMesh mesh =
            merged({box_at({0.2, 0, 0.1}, {3.1, top, 2.9}), box_at({0, 2.3, 0}, {3, 4.6, 3})});
        const FaceBodies bodies = bodies_of_pieces(mesh);
        ASSERT_EQ(bodies.count, 2u);
        const Cubes cubes = cubes_of(mesh, bodies);
        const auto found = find_components(cubes, Connectivity::corner);
        EXPECT_EQ(found.count(), 2u) << top;
        EXPECT_NEAR(total_mass(cubes), 1000 * (2.9 * top * 2.8 + 3 * 2.3 * 3), 1);
        EXPECT_TRUE(std::is_sorted(
            cubes.cell.begin(), cubes.cell.end(), [](const Vec3i& a, const Vec3i& b) {
                return std::array{a.z(), a.y(), a.x()} < std::array{b.z(), b.y(), b.x()};
            }));
    }
}

TEST(Bodies, EachHasTheCubesThatItsMeshAloneGives)
{
    const std::vector<TriMesh> pieces{box_at({0.2, 0, 0.1}, {3.1, 2.3, 2.9}),
                                      meshes::moved(geometry::icosphere(1.3, 3), {1.7, 3.6, 1.4}),
                                      box_at({3.1, 0, 0}, {5, 4, 1.5})};
    const TriMesh mesh = merged(pieces);
    const Cubes all = cubes_of(mesh, bodies_of_pieces(mesh));
    const auto label = find_components(all, Connectivity::corner).label;
    for (const TriMesh& piece : pieces) {
        const Cubes one = solid(piece);
        // Its cubes are found one for one under one label.
        std::vector<std::uint32_t> of;
        for (std::size_t c = 0; c < one.count(); ++c) {
            for (std::uint32_t k = 0; k < all.count(); ++k) {
                if (all.cell[k] == one.cell[c] && all.mass[k] == one.mass[c] &&
                    all.fill[k] == one.fill[c]) {
                    of.push_back(label[k]);
                }
            }
        }
        std::sort(of.begin(), of.end());
        std::size_t most = 0;
        for (const auto l : of) {
            most = std::max(most, std::size_t(std::count(of.begin(), of.end(), l)));
        }
        EXPECT_EQ(most, one.count());
        EXPECT_EQ(std::size_t(std::count(label.begin(), label.end(), of[of.size() / 2])),
                  one.count());
    }
}

TEST(Bodies, CornersAreThoseOfTheirCubes)
{
    const TriMesh mesh = merged({box_at({0, 0, 0}, {2, 2, 2}), box_at({1.5, 2, 0}, {4, 3, 2})});
    const Cubes cubes = cubes_of(mesh, bodies_of_pieces(mesh));
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (int a = 0; a < 8; ++a) {
            const Vec3i at = cubes.cell[c] + Vec3i(a & 1, a >> 1 & 1, a >> 2);
            EXPECT_EQ(cubes.corner[cubes.corners[c][std::size_t(a)]], at);
        }
    }
}

TEST(Bodies, ACavityIsOfWhatIsAroundIt)
{
    const TriMesh hollow = merged({box_at({0, 0, 0}, {4, 4, 4}), box_at({5, 0, 0}, {9, 4, 4}),
                                   turned_inside_out(box_at({6, 1, 1}, {8, 3, 3}))});
    const FaceBodies bodies = bodies_of_pieces(hollow);
    EXPECT_EQ(bodies.count, 2u);
    EXPECT_EQ(bodies.of.back(), 1u);
    EXPECT_NEAR(total_mass(cubes_of(hollow, bodies)), 1000 * (64 + 64 - 8), 1e-6);
}

TEST(Bodies, AHollowOfAMirroredModelIsOfWhatIsAroundIt)
{
    const TriMesh stone = box_at({3, 3, 3}, {5, 5, 5});  // lies in the hollow
    const TriMesh hollow = merged(
        {box_at({0, 0, 0}, {8, 8, 8}), turned_inside_out(box_at({1, 1, 1}, {7, 7, 7})), stone});
    for (const TriMesh& mesh : {hollow, turned_inside_out(hollow)}) {
        const FaceBodies bodies = bodies_of_pieces(mesh);
        EXPECT_EQ(bodies.count, 2u);
        EXPECT_EQ(bodies.of[0], bodies.of[12]);
        EXPECT_NE(bodies.of[0], bodies.of[24]);
        EXPECT_NEAR(total_mass(cubes_of(mesh, bodies)), 1000 * (512 - 216 + 8), 1e-6);
    }
}

TEST(Bodies, WhatIsWoundAsTheSolidAroundItIsABodyOfItsOwn)
{
    const TriMesh nested = merged({box_at({0, 0, 0}, {8, 8, 8}), box_at({2, 2, 2}, {6, 6, 6}),
                                   turned_inside_out(box_at({3, 3, 3}, {5, 5, 5}))});
    const FaceBodies bodies = bodies_of_pieces(nested);
    EXPECT_EQ(bodies.count, 2u);
    EXPECT_EQ(bodies.of[12], bodies.of[24]) << "the hollow is of the smallest piece around it";
}

TEST(Bodies, WhatFacesInwardBesideASolidIsABodyOfItsOwn)
{
    // In the notch of an L, within its box.
    const TriMesh wall = box_at({0, 0, 0}, {1, 4, 4}), foot = box_at({0, 0, 0}, {4, 1, 4});
    TriMesh both = merged({wall, foot});
    geometry::MeshTopology joined = *both.topology;
    joined.triangles.push_back({0, std::uint32_t(wall.positions.size()), 0});  // one piece
    joined.normal_triangles.clear();
    both.normals.clear();
    both.topology = std::make_shared<const geometry::MeshTopology>(std::move(joined));
    const TriMesh mesh = merged({both, turned_inside_out(box_at({2, 2, 1}, {3, 3, 2}))});
    EXPECT_EQ(bodies_of_pieces(mesh).count, 2u);
}

TEST(Bodies, PiecesOfOneGroupAreOneBody)
{
    const TriMesh legs = merged({box_at({0, 0, 0}, {1, 3, 1}), box_at({3, 0, 0}, {4, 3, 1})});
    const TriMesh mesh = merged({meshes::with_material(legs, {}, "legs"),
                                 meshes::with_material(box_at({0, 3, 0}, {4, 4, 1}), {}, "seat")});
    const FaceBodies bodies = bodies_of_groups(mesh);
    EXPECT_EQ(bodies.count, 2u);
    EXPECT_EQ(bodies_of_pieces(mesh).count, 3u);
    EXPECT_EQ(bodies.of[0], bodies.of[legs.triangles().size() - 1]);
    EXPECT_NE(bodies.of[0], bodies.of.back());
    EXPECT_EQ(bodies_of_groups(legs).count, 1u);  // without groups all is of one
}

TEST(Bodies, FacesThatAreNotFiniteAreOfNone)
{
    TriMesh mesh = merged({box_at({0, 0, 0}, {1, 1, 1}), box_at({2, 0, 0}, {3, 1, 1})});
    mesh.positions[0].x() = std::numeric_limits<float>::quiet_NaN();
    const FaceBodies bodies = bodies_of_pieces(mesh);
    EXPECT_EQ(bodies.count, 2u);
    EXPECT_NE(std::count(bodies.of.begin(), bodies.of.end(), no_index), 0);
}

TEST(Bodies, EmbeddedPiecesFollowTheirOwn)
{
    // Stacked in a face of the grid, and in the middle of a cube.
    expect_each_piece_follows_its_body(
        {box_at({0, 0, 0}, {3, 2, 3}), box_at({0, 2, 0}, {3, 4, 3}), box_at({0, 4, 0}, {3, 5, 3})});
    expect_each_piece_follows_its_body(
        {box_at({0, 0, 0}, {3, 2.4, 3}), box_at({0, 2.4, 0}, {3, 4.8, 3})});
    // Cards in one layer of cubes, which hold each other's vertices.
    expect_each_piece_follows_its_body({box_at({0, 0.1, 0}, {3, 0.2, 3}),
                                        box_at({0, 0.2, 0}, {3, 0.3, 3}),
                                        box_at({0, 0.3, 0}, {3, 0.4, 3})});
    // A slab whose vertices all lie in cubes of the ring that it rests on.
    const TriMesh low = box_at({0, 0, 0}, {9, 1.2, 1.5}), high = box_at({0, 0, 7.5}, {9, 1.2, 9});
    const TriMesh left = box_at({0, 0, 0}, {1.5, 1.2, 9}), right = box_at({7.5, 0, 0}, {9, 1.2, 9});
    const TriMesh slab = box_at({0.2, 1.2, 0.2}, {8.8, 1.6, 8.8});
    const TriMesh ring_and_slab = merged({low, high, left, right, slab});
    const std::array bodies{solid(merged({low, high, left, right})), solid(slab)};
    const Cubes together = geometry::side_by_side(bodies);
    const auto label = find_components(together, Connectivity::corner).label;
    const geometry::Binding binding = bind(ring_and_slab, together);
    EXPECT_NE(label[binding.used[binding.cube.front()]], label[binding.used[binding.cube.back()]]);
    // A ball in a box that it overlaps everywhere.
    expect_each_piece_follows_its_body(
        {box_at({0, 0, 0}, {5, 5, 5}),
         meshes::moved(geometry::icosphere(1.2, 2), {2.5, 2.5, 2.5})});
}

// Boxes that meet at 2.4, and in finer detail a lower one that ends at `top`: in the cubes of the
// upper one, which begin at 2. Its own end at 3.
TEST(Bodies, AVertexJustOutsideOfItsBodyDoesNotGoWithTheNeighbour)
{
    const TriMesh lower = box_at({0, 0, 0}, {3, 2.4, 3}), upper = box_at({0, 2.4, 0}, {3, 6, 3});
    const Cubes cubes = cubes_of(merged({lower, upper}), bodies_of_pieces(merged({lower, upper})));
    const auto label = find_components(cubes, Connectivity::corner).label;
    auto x = corner_positions(cubes);
    const std::uint32_t high = label[label.size() - 1];
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (const std::uint32_t k : cubes.corners[c]) {
            if (label[c] == high)
                x[k] = cubes.origin + cubes.corner[k].cast<double>() + Vec3(0, 5, 0);
        }
    }
    for (const double top : {2.4, 2.7, 3.3, 3.9, 4.1}) {
        const TriMesh mesh = merged({box_at({0, 0, 0}, {3, top, 3}), upper});
        const geometry::Binding binding = bind(mesh, cubes);
        const TriMesh moved = embed(binding, mesh, cubes, x);
        std::size_t up = 0;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const float by = moved.positions[v].y() - mesh.positions[v].y();
            EXPECT_NEAR(by, std::round(by / 5) * 5, 1e-5);
            up += by > 2.5f ? 1 : 0;
        }
        // Farther than a cube out, it is a skin over both.
        const std::size_t own = upper.positions.size(), skin = top > 4 ? 4 : 0;
        EXPECT_EQ(up, own + skin) << top;
        const bool outside = top > 3 && top < 4;
        EXPECT_EQ(binding.strays.size(), outside ? 4u : 0u) << top;
        EXPECT_NEAR(binding.farthest, outside ? top - 3 : 0, 1e-6) << top;
    }
}

TEST(Bodies, SplitMeshesHaveTheirVerticesAndAttributes)
{
    TriMesh mesh = merged({box_at({0, 0, 0}, {1, 1, 1}), geometry::icosphere(1, 1)});
    mesh.attributes = {{"number", "", std::vector<float>(mesh.positions.size())}};
    auto& values = mesh.attributes[0].values;
    std::iota(values.begin(), values.end(), 0.0f);
    const FaceBodies bodies = bodies_of_pieces(mesh);
    std::size_t faces = 0;
    for (const auto& part : geometry::split(mesh, bodies.of, bodies.count)) {
        faces += part.faces.size();
        ASSERT_EQ(part.mesh.triangles().size(), part.faces.size());
        ASSERT_EQ(part.mesh.attributes.size(), 1u);
        for (std::size_t f = 0; f < part.faces.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto own = part.mesh.triangles()[f][k];
                const auto whole = mesh.triangles()[part.faces[f]][k];
                EXPECT_EQ(part.mesh.positions[own], mesh.positions[whole]);
                EXPECT_EQ(part.mesh.attributes[0].values[own], float(whole));
            }
        }
    }
    EXPECT_EQ(faces, mesh.triangles().size());
}

}  // namespace
