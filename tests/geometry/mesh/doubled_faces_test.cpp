// Faces that are there twice, whichever way their polygons are cut.

#include "geometry/mesh/doubled_faces.hpp"

#include "geometry/cubes/sample_volume.hpp"
#include "geometry/mesh/cut_alike.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/solid_faces.hpp"
#include "geometry/mesh/triangulate.hpp"
#include "tests/geometry/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace {

using namespace geometry;

using Faces = std::vector<std::vector<std::uint32_t>>;

TriMesh of_polygons(const std::vector<Vec3f>& positions, const Faces& faces)
{
    TriMesh mesh;
    mesh.positions = positions;
    MeshTopology topology;
    for (const auto& face : faces) {
        triangulate(face, positions, topology.triangles);
        add_polygon(topology.polygon, face.size() - 2);
    }
    mesh.topology = std::make_shared<const MeshTopology>(std::move(topology));
    return mesh;
}

// With a back of each face, listed in reverse.
Faces two_sided(Faces faces)
{
    const std::size_t count = faces.size();
    for (std::size_t f = 0; f < count; ++f) faces.emplace_back(faces[f].rbegin(), faces[f].rend());
    return faces;
}

// A box of quads, 1 m wide; `bend`: m, that a corner is off, so that three quads are not flat.
std::vector<Vec3f> box_corners(float bend = 0)
{
    std::vector<Vec3f> out;
    for (int i = 0; i < 8; ++i) out.emplace_back(float(i >> 2), float(i >> 1 & 1), float(i & 1));
    out[7] += Vec3f(bend, bend / 2, 0);
    return out;
}
const Faces box_quads{{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                      {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};

TriMesh without_polygons(const TriMesh& mesh)
{
    return meshes::soup(mesh.positions, mesh.triangles());
}

std::size_t count(const DoubledFaces& faces, Doubled what)
{
    return static_cast<std::size_t>(std::count(faces.is.begin(), faces.is.end(), what));
}

TEST(DoubledFaces, AQuadAndItsBackAreCutAlongTwoDiagonals)
{
    const TriMesh mesh = of_polygons(box_corners(), two_sided(box_quads));
    const auto triangle_of = [&](std::size_t t) {
        Triangle out = mesh.triangles()[t];
        std::sort(out.begin(), out.end());
        return out;
    };
    EXPECT_NE(triangle_of(0), triangle_of(12));
    EXPECT_NE(triangle_of(0), triangle_of(13));
}

TEST(DoubledFaces, ABoxOfTwoSidedQuadsIsSolid)
{
    for (const float bend : {0.0f, 0.2f}) {
        const TriMesh one = of_polygons(box_corners(bend), box_quads);
        const TriMesh mesh = of_polygons(box_corners(bend), two_sided(box_quads));
        EXPECT_EQ(count(doubled_faces(mesh), Doubled::solid_back), 12u);
        EXPECT_EQ(solid_faces(mesh).triangles, one.triangles());
        for (const Inside rule : {Inside::winding, Inside::parity}) {
            EXPECT_EQ(volume_inside(mesh, rule), volume_inside(one, rule));
        }
    }
}

// As of files without polygons.
TEST(DoubledFaces, TwoTrianglesThatMakeAFlatQuadAreOneFace)
{
    const TriMesh mesh = without_polygons(of_polygons(box_corners(), two_sided(box_quads)));
    EXPECT_EQ(count(doubled_faces(mesh), Doubled::solid_back), 12u);
    const TriMesh again = without_polygons(of_polygons(box_corners(), box_quads));
    EXPECT_EQ(solid_faces(mesh).triangles, again.triangles());
}

TEST(DoubledFaces, AFlatTetrahedronKeepsItsFaces)
{
    const TriMesh thin = meshes::soup({{0, 0, 0}, {1, 0, 0.01f}, {1, 1, 0}, {0, 1, 0.01f}},
                                      {{0, 1, 2}, {0, 2, 3}, {1, 3, 2}, {1, 0, 3}});
    const DoubledFaces faces = doubled_faces(thin);
    EXPECT_EQ(faces.triangles, thin.triangles());
    EXPECT_EQ(count(faces, Doubled::no), 4u);
}

// A drum whose ends are polygons of 24 corners, the lower one concave.
TEST(DoubledFaces, AQuadAndTheTwoTrianglesOfItsBackAreOneFace)
{
    TriMesh mesh = of_polygons(box_corners(), box_quads);
    const double volume = std::abs(enclosed_volume(mesh));
    MeshTopology topology = *mesh.topology;
    for (const auto& quad : box_quads) {
        const auto [a, b, c, d] = std::array{quad[3], quad[2], quad[1], quad[0]};
        for (const Triangle& t : {Triangle{a, b, c}, Triangle{a, c, d}}) {
            topology.triangles.push_back(t);
            add_polygon(topology.polygon, 1);
        }
    }
    mesh.topology = std::make_shared<const MeshTopology>(topology);
    std::vector<Triangle> cut = mesh.triangles();
    cut_alike(cut, topology.polygon, mesh.positions);
    std::set<std::set<std::uint32_t>> faces;
    for (const Triangle& t : cut) faces.insert({t[0], t[1], t[2]});
    EXPECT_EQ(faces.size(), 12u);
    EXPECT_NEAR(volume, 1, 1e-6);
}

// A cushion: both faces have the six corners of a rim that goes up and down.
TEST(DoubledFaces, TwoFacesThatEncloseASolidStay)
{
    std::vector<Vec3f> rim;
    std::vector<std::uint32_t> face;
    for (std::uint32_t i = 0; i < 6; ++i) {
        const double angle = i * std::numbers::pi / 3;
        rim.emplace_back(float(std::cos(angle)), i % 2 ? 0.2f : 0.f, float(std::sin(angle)));
        face.push_back(i);
    }
    const TriMesh cushion = of_polygons(rim, two_sided({face}));
    const double volume = std::abs(enclosed_volume(cushion));
    ASSERT_GT(volume, 0.1);
    std::vector<Triangle> cut = cushion.triangles();
    cut_alike(cut, cushion.topology->polygon, cushion.positions);
    EXPECT_EQ(cut, cushion.triangles());
}

TEST(DoubledFaces, LargerPolygonsAreCutAlike)
{
    constexpr std::uint32_t n = 24;
    std::vector<Vec3f> positions;
    Faces faces(2);
    for (std::uint32_t k = 0; k < n; ++k) {
        const double a = 2 * std::numbers::pi * k / n, r = k == 5 ? 0.3 : 0.5;
        for (const float y : {0.0f, 1.0f}) {
            positions.emplace_back(float(r * std::cos(a)), y, float(r * std::sin(a)));
        }
        faces[0].push_back(2 * k);
        faces[1].insert(faces[1].begin(), 2 * k + 1);
        faces.push_back({2 * k, 2 * k + 1, 2 * ((k + 1) % n) + 1, 2 * ((k + 1) % n)});
    }
    // Backs that begin at another corner.
    Faces backed = two_sided(faces);
    std::rotate(backed[faces.size()].begin(), backed[faces.size()].begin() + 7,
                backed[faces.size()].end());
    const TriMesh one = of_polygons(positions, faces), mesh = of_polygons(positions, backed);
    EXPECT_EQ(count(doubled_faces(mesh), Doubled::solid_back), one.triangles().size());
    EXPECT_EQ(solid_faces(mesh).triangles, solid_faces(one).triangles);
}

TEST(DoubledFaces, OfASheetOneSideStays)
{
    const TriMesh mesh = of_polygons(box_corners(), two_sided({box_quads[0], box_quads[2]}));
    EXPECT_EQ(count(doubled_faces(mesh), Doubled::sheet_back), 4u);
    const auto one = without_doubled(mesh);
    ASSERT_TRUE(one);
    EXPECT_EQ(one->doubled, 4u);
    EXPECT_EQ(one->faces, (std::vector<std::uint32_t>{0, 1, 2, 3}));
    EXPECT_EQ(one->mesh.topology->polygon, (std::vector<std::uint32_t>{0, 0, 1, 1}));
    EXPECT_FALSE(without_doubled(one->mesh));
    EXPECT_EQ(volume_inside(mesh, Inside::winding), 0);
}

// A flag of two sides, which touches a box of one at a corner.
TEST(DoubledFaces, AtOneVertexTwoSidesDoNotJoinOne)
{
    std::vector<Vec3f> positions = box_corners();
    for (const Vec3f& p : {Vec3f(2, 2, 1), Vec3f(2, 1, 1)}) positions.push_back(p);
    Faces faces = two_sided({{7, 8, 9}});
    faces.insert(faces.end(), box_quads.begin(), box_quads.end());
    const TriMesh mesh = of_polygons(positions, faces);
    EXPECT_EQ(count(doubled_faces(mesh), Doubled::sheet_back), 1u);
    EXPECT_EQ(count(doubled_faces(mesh), Doubled::no), 13u);
}

TEST(DoubledFaces, TwoRoomsOfTwoSidedWallsAreSolid)
{
    std::vector<Vec3f> positions = box_corners();
    for (const int i : {4, 5, 6, 7})
        positions.push_back(positions[std::size_t(i)] + Vec3f(1, 0, 0));
    Faces walls = box_quads;
    for (const auto& quad : box_quads) {
        if (quad == box_quads[0]) continue;  // the wall between them is there already
        std::vector<std::uint32_t> next;
        for (const auto v : quad) next.push_back(v + 4);
        walls.push_back(next);
    }
    for (const bool backs_first : {false, true}) {
        Faces faces = two_sided(walls);
        if (backs_first)
            std::rotate(faces.begin(), faces.begin() + long(walls.size()), faces.end());
        const TriMesh mesh = of_polygons(positions, faces);
        EXPECT_EQ(count(doubled_faces(mesh), Doubled::solid_back), 22u);
        EXPECT_NEAR(volume_inside(mesh, Inside::winding), 2, 1e-2);
    }
}

TEST(DoubledFaces, AWallBetweenTwoBoxesIsThereTwice)
{
    const TriMesh left = box({1, 1, 1}, {1, 1, 1}), right = meshes::moved(left, {1, 0, 0});
    const std::array<const TriMesh*, 3> all{&left, &right, &left};
    const TriMesh mesh = merge(all);
    const DoubledFaces faces = doubled_faces(mesh);
    EXPECT_EQ(count(faces, Doubled::against), 2u);
    EXPECT_EQ(count(faces, Doubled::again), 12u);
    const auto once = without_doubled(mesh);
    ASSERT_TRUE(once);
    EXPECT_EQ(once->doubled, 12u);
}

// Water in a glass: a wall of one kind that looks in, and what fills it. Neither is a back.
TEST(DoubledFaces, OfTwoKindsThatFaceEachOtherBothStay)
{
    const TriMesh mesh = of_polygons(box_corners(), two_sided(box_quads));
    std::vector<std::uint16_t> kind(24, 0);
    std::fill(kind.begin() + 12, kind.end(), std::uint16_t{1});
    EXPECT_EQ(count(doubled_faces(mesh, kind), Doubled::no), 24u);
    EXPECT_EQ(solid_faces(mesh, kind).triangles.size(), 24u);
}

TEST(DoubledFaces, UnsoundTrianglesAreNoDoubles)
{
    TriMesh mesh = of_polygons(box_corners(), box_quads);
    mesh.positions[7].x() = NAN;
    const DoubledFaces faces = doubled_faces(mesh);
    EXPECT_EQ(count(faces, Doubled::unsound) + count(faces, Doubled::no), 12u);
    EXPECT_FALSE(without_doubled(mesh));
    const TriMesh lost =
        meshes::soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 9}, {0, 2, 1}});
    const auto one = without_doubled(lost);
    ASSERT_TRUE(one);
    EXPECT_EQ(one->doubled, 1u);
    EXPECT_EQ(one->faces, (std::vector<std::uint32_t>{0}));
}

}  // namespace
