#include "geometry/embed/cut_caps.hpp"

#include "geometry/base/random.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/embed/torn_blocks.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

using namespace geometry;
using namespace torn_blocks;

namespace {

// Of the faces that close what is cut.
double inside_area(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    double sum = 0;
    for (std::size_t f = 0; f < t.group.size(); ++f) {
        if (t.groups[t.group[f]] == "inside") sum += area(mesh, f);
    }
    return sum;
}

TriMesh reversed(TriMesh mesh)
{
    MeshTopology topology = *mesh.topology;
    for (auto* faces : {&topology.triangles, &topology.normal_triangles}) {
        for (Triangle& t : *faces) std::swap(t[1], t[2]);
    }
    mesh.topology = std::make_shared<const MeshTopology>(std::move(topology));
    for (Vec3f& n : mesh.normals) n = -n;
    return mesh;
}

TriMesh together(const TriMesh& one, const TriMesh& other)
{
    const std::array both{&one, &other};
    return merge(both);
}

// Blocks of corners that are each of one of three pieces, at random.
std::vector<std::size_t> random_pieces(const Cubes& cubes, std::uint64_t seed)
{
    const Random random(seed);
    std::map<std::array<int, 3>, std::size_t> piece;
    std::vector<std::size_t> of;
    for (const Vec3i& at : cubes.corner) {
        const auto [found, fresh] = piece.try_emplace({at.x() / 3, at.y() / 2, at.z() / 3}, 0);
        if (fresh) found->second = std::size_t(3 * random.unit(piece.size()));
        of.push_back(found->second);
    }
    return of;
}

std::vector<std::uint32_t> links_between_pieces(const Cubes& cubes,
                                                const std::vector<std::size_t>& piece)
{
    std::map<std::array<int, 3>, std::size_t> piece_at;
    const auto key = [](const Vec3i& p) { return std::array{p.x(), p.y(), p.z()}; };
    for (std::size_t k = 0; k < piece.size(); ++k) piece_at[key(cubes.corner[k])] = piece[k];
    return links_between(cubes, [&](const Vec3i& a, const Vec3i& b) {
        return piece_at[key(a)] != piece_at[key(b)];
    });
}

TEST(CutCaps, HalvesOfASolidAreClosed)
{
    const Cubes cubes = block({7, 4, 4}, 0.25, Vec3(-1, -0.5, -0.5));
    const TriMesh rest = box({1.4, 0.7, 0.6}, {3, 2, 2});  // -0.7 .. 0.7, ...
    const auto broken = links_across(cubes, 0, 3);
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (cubes.corner[k].x() > 3) x[k] = turned * x[k];
    }
    const TriMesh out = closed(rest, cubes, x, broken);
    EXPECT_NEAR(inside_area(out), 2 * 0.7 * 0.6, 1e-6);
    EXPECT_NEAR(surface_area(out), surface_area(rest) + 2 * 0.7 * 0.6, 1e-5);
    EXPECT_NEAR(enclosed_volume(out), enclosed_volume(rest), 1e-5);
    ASSERT_TRUE(all_finite(out));
    // What closes faces away from what it closes, and every vertex is on one side.
    const double middle = -1 + 0.25 * 3.5;
    const MeshTopology& t = *out.topology;
    for (std::size_t f = 0; f < t.triangles.size(); ++f) {
        if (t.groups[t.group[f]] != "inside") continue;
        const Vec3f& normal = out.normals[t.normal_triangles[f][0]];
        const Vec3 p = out.positions[t.triangles[f][0]].cast<double>();
        const bool is_left = std::abs(p.x() - middle) < 1e-6;
        const Vec3 expected = is_left ? Vec3(1, 0, 0) : Vec3(turned.linear() * Vec3(-1, 0, 0));
        EXPECT_NEAR((normal.cast<double>() - expected).norm(), 0, 1e-5) << f;
        EXPECT_NEAR(is_left ? p.x() : (turned.inverse() * p).x(), middle, 1e-6) << f;
    }
    // Without the tree it stays open.
    EXPECT_EQ(inside_area(torn(rest, cubes, x, broken)), 0);
}

// The volume of what is cut is that of the whole, by pieces of any shape: so what closes it fits
// the rims, on solids with curves, holes and pieces within each other.
TEST(CutCaps, KeepTheVolumeOfAnySolid)
{
    const Cubes cubes = block({12, 12, 12}, 0.1, Vec3(-0.6, -0.6, -0.6));
    const TriMesh hollow =
        together(icosphere(0.5, 3), reversed(meshes::moved(icosphere(0.25, 2), Vec3(0.05, 0, 0))));
    const std::vector<std::pair<const char*, TriMesh>> solids{
        {"ball", icosphere(0.53, 3)},
        {"torus", torus(0.38, 0.13, 40, 20)},
        {"hollow", hollow},
        {"box", box({1.03, 0.4, 0.77}, {2, 3, 1})},
        {"inside out", reversed(icosphere(0.45, 2))},
    };
    for (const auto& [name, rest] : solids) {
        const double volume = enclosed_volume(rest);
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
            const auto piece = random_pieces(cubes, seed);
            const auto broken = links_between_pieces(cubes, piece);
            auto x = corner_positions(cubes);
            const TriMesh still = closed(rest, cubes, x, broken);
            EXPECT_GT(inside_area(still), 0.1) << name << seed;
            EXPECT_NEAR(enclosed_volume(still), volume, 1e-5) << name << seed;
            // The volume of what is closed does not depend on where it is.
            for (std::size_t k = 0; k < x.size(); ++k) x[k] += double(piece[k]) * Vec3(3, 1, 2);
            const TriMesh apart = closed(rest, cubes, x, broken);
            EXPECT_NEAR(enclosed_volume(apart), volume, 1e-5) << name << seed;
            EXPECT_NEAR(surface_area(apart), surface_area(rest) + inside_area(still), 1e-4)
                << name << seed;
        }
    }
}

// Hundreds of edges in the plane of one cube, on a curve that bends both ways.
TEST(CutCaps, KeepTheVolumeOfAFineMeshInLargeCubes)
{
    const Cubes cubes = block({2, 2, 2}, 0.6, Vec3(-0.6, -0.6, -0.6));
    TriMesh rest = icosphere(0.5, 6);
    for (Vec3f& p : rest.positions) p *= 1 + 0.15f * std::sin(40 * p.x()) * std::sin(40 * p.y());
    for (int axis = 0; axis < 3; ++axis) {
        const auto broken = links_across(cubes, axis, 0);
        auto x = corner_positions(cubes);
        for (std::size_t k = 0; k < x.size(); ++k) {
            if (cubes.corner[k][axis] > 0) x[k] += Vec3(1, 2, 3);
        }
        const TriMesh out = closed(rest, cubes, x, broken);
        // Slivers at the rim, where the mesh is all but in the plane, may be taken for outside.
        EXPECT_NEAR(enclosed_volume(out), enclosed_volume(rest), 5e-5) << axis;
        EXPECT_GT(inside_area(out), 0.5) << axis;
    }
}

// Tears through some of the links, which end within the block, branch and leave debris.
TEST(CutCaps, CloseRaggedTears)
{
    const Cubes cubes = block({4, 3, 3}, 0.25, Vec3(-0.5, -0.375, -0.375));
    const std::vector<std::pair<const char*, TriMesh>> solids{
        {"ball", icosphere(0.36, 2)},
        {"torus", torus(0.25, 0.09, 20, 10)},
        {"coarse box", box({0.93, 0.7, 0.66}, {1, 1, 1})},
        {"fine box", box({0.93, 0.7, 0.66}, {4, 3, 5})},
        {"box of the cubes' faces", box({1, 0.75, 0.75}, {4, 3, 3})},
        {"large box of the cubes' faces", box({1, 0.75, 0.75}, {1, 1, 1})},
        {"faces between parts", box({0.75, 0.5, 0.5}, {3, 2, 2})},
        {"vertices all but between parts", meshes::moved(icosphere(0.36, 2), Vec3(1e-7, 2e-7, 0))},
        {"within one cube", meshes::moved(icosphere(0.1, 1), Vec3(0.125, 0, 0))},
    };
    for (const auto& [name, rest] : solids) {
        for (std::uint64_t seed = 0; seed < 12; ++seed) {
            const Random random(seed);
            std::uint64_t count = 0;
            const double share = std::array{0.1, 0.4, 0.8}[seed % 3];
            const auto broken = links_between(
                cubes, [&](const Vec3i&, const Vec3i&) { return random.unit(count++) < share; });
            auto x = corner_positions(cubes);
            const TriMesh still = closed(rest, cubes, x, broken);
            EXPECT_TRUE(is_closed(still.triangles(), still.positions.size())) << name << seed;
            EXPECT_NEAR(enclosed_volume(still), enclosed_volume(rest), 1e-6) << name << seed;
            for (Vec3& p : x) {
                for (int d = 0; d < 3; ++d) p[d] += 0.1 * (random.unit(count++) - 0.5);
            }
            const TriMesh apart = closed(rest, cubes, x, broken);
            EXPECT_TRUE(is_closed(apart.triangles(), apart.positions.size())) << name << seed;
            for (Vec3& p : x) p += Vec3(0, -300, 100);
            const TriMesh fallen = closed(rest, cubes, x, broken);
            EXPECT_TRUE(is_closed(fallen.triangles(), fallen.positions.size())) << name << seed;
        }
    }
}

TEST(CutCaps, OfPiecesThatOverlapAreThoseOfAll)
{
    // Two boxes that share 0.2 x 0.5 x 0.5 of the plane: what closes them does so once.
    const Cubes cubes = block({8, 8, 8}, 0.15, Vec3(-0.6, -0.6, -0.6));
    const TriMesh rest = together(meshes::moved(box({0.5, 0.5, 0.5}, {1, 1, 1}), Vec3(0, 0, 0.1)),
                                  meshes::moved(box({0.5, 0.5, 0.5}, {1, 1, 1}), Vec3(0, 0, -0.2)));
    const auto broken = links_across(cubes, 0, 3);
    const TriMesh out = closed(rest, cubes, corner_positions(cubes), broken);
    EXPECT_NEAR(inside_area(out), 2 * 0.5 * 0.8, 1e-5);
}

TEST(CutCaps, AreNoneWhereNothingIsEnclosed)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    const auto broken = links_across(cubes, 1, 2);
    TriMesh sheet = grid(1, 1, 5, 5);
    move(sheet, placement({0, 0, 0}, {70, 10, 0}, {1, 1, 1}, {0, 0, 0}));
    const TriMesh out = closed(sheet, cubes, corner_positions(cubes), broken);
    EXPECT_GT(out.triangles().size(), sheet.triangles().size());
    EXPECT_EQ(inside_area(out), 0);
    // Nor where a face of the mesh lies in the plane.
    for (const double y : {0.1, -0.3}) {  // above it, and below
        const TriMesh beside = meshes::moved(box({0.8, 0.4, 0.8}, {1, 1, 1}), Vec3(0, y, 0));
        EXPECT_EQ(inside_area(closed(beside, cubes, corner_positions(cubes), broken)), 0) << y;
    }
}

TEST(CutCaps, OfASoupAreFinite)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    for (std::uint64_t seed = 2; seed < 5; ++seed) {  // 3: with a face that is a line
        const Random random(seed);
        std::vector<Vec3f> points;
        std::vector<Triangle> faces;
        for (std::uint32_t k = 0; k < 900; ++k) {
            // Many on the planes themselves, so that edges lie on each other.
            const auto number = [&](std::uint64_t d) {
                return 0.1f * float(std::round(12 * random.unit(3 * k + d))) - 0.6f;
            };
            points.emplace_back(number(0), number(1), number(2));
            if (k % 3 == 2) faces.push_back({k - 2, k - 1, k});
        }
        const TriMesh rest = meshes::soup(points, faces);
        const auto broken = links_between_pieces(cubes, random_pieces(cubes, seed));
        const TriMesh out = closed(rest, cubes, corner_positions(cubes), broken);
        EXPECT_TRUE(all_finite(out));
        // No more than both sides of all planes.
        EXPECT_LT(inside_area(out), 2 * 3 * 6 * 1.44);
    }
}

TEST(CutCaps, LookLikeWhatIsNear)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    TriMesh rest = meshes::with_material(box({0.5, 0.5, 0.5}, {1, 1, 1}), {"red"}, "a");
    rest.attributes.push_back({"heat", "K", std::vector<float>(rest.positions.size(), 7.0f)});
    rest.colours.assign(rest.positions.size(), Vec3f(0.1f, 0.2f, 0.3f));
    const TriMesh out = closed(rest, cubes, corner_positions(cubes), links_across(cubes, 2, 2));
    const MeshTopology& t = *out.topology;
    EXPECT_EQ(t.groups, (std::vector<std::string>{"a", "inside"}));
    ASSERT_EQ(t.group.size(), t.triangles.size());
    ASSERT_EQ(t.material.size(), t.triangles.size());
    for (const auto m : t.material) EXPECT_EQ(t.materials[m].name, "red");
    ASSERT_EQ(out.attributes[0].values.size(), out.positions.size());
    for (const float v : out.attributes[0].values) EXPECT_NEAR(v, 7, 1e-5);
    for (const Vec3f& c : out.colours) EXPECT_NEAR((c - Vec3f(0.1f, 0.2f, 0.3f)).norm(), 0, 1e-6);
    EXPECT_NEAR(inside_area(out), 2 * 0.25, 1e-6);
}

TEST(CutCaps, HaveAMaterialOfTheirOwnAndLieInItAsTheyDoInTheirPlane)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    for (const bool has_materials : {false, true}) {
        TriMesh rest = box({0.5, 0.5, 0.5}, {1, 1, 1});
        MeshTopology with_uvs = *rest.topology;
        with_uvs.materials.clear();
        with_uvs.material.clear();
        if (has_materials) {
            with_uvs.materials = {{"blue"}, {"red"}};
            with_uvs.material.assign(with_uvs.triangles.size(), 1);
        }
        with_uvs.uvs = {{0, 0}, {1, 0}, {0, 1}};
        with_uvs.uv_triangles.assign(with_uvs.triangles.size(), {0, 1, 2});
        rest.topology = std::make_shared<const MeshTopology>(with_uvs);
        const Material crumb{"crumb", {0.9f, 0.8f, 0.6f}};
        std::vector<Vec3> x = corner_positions(cubes);
        for (Vec3& p : x) p += Vec3(3, 0, 0);
        const TriMesh out = closed(rest, cubes, x, links_across(cubes, 2, 2), crumb);
        const MeshTopology& t = *out.topology;
        const std::uint16_t before = has_materials ? 1 : 0;
        ASSERT_EQ(t.materials.size(), before + 2u);
        EXPECT_EQ(t.materials[before].name, has_materials ? "red" : "");
        EXPECT_EQ(t.materials[before + 1u], crumb);
        ASSERT_EQ(t.material.size(), t.triangles.size());
        ASSERT_EQ(t.uv_triangles.size(), t.triangles.size());
        double uv_area = 0;
        for (std::size_t f = 0; f < t.triangles.size(); ++f) {
            const bool inside = t.groups[t.group[f]] == "inside";
            EXPECT_EQ(t.material[f], inside ? before + 1 : before);
            if (!inside) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3f& p = out.positions[t.triangles[f][k]];
                const Vec2f& uv = t.uvs[t.uv_triangles[f][k]];
                EXPECT_NEAR((uv - Vec2f(p[0] - 3, p[1])).norm(), 0, 1e-5);
            }
            uv_area += area(out, f);
        }
        EXPECT_NEAR(uv_area, 2 * 0.25, 1e-6);
    }
}

}  // namespace
