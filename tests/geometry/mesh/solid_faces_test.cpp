// Faces of solids that are named several times, or wound the wrong way.

#include "geometry/mesh/solid_faces.hpp"

#include "geometry/cubes/sample_volume.hpp"
#include "tests/geometry/meshes.hpp"

#include <algorithm>
#include <cmath>

namespace {

using namespace geometry;

// A mesh with more triangles, of vertices of their own in the same places.
TriMesh with_doubles(const TriMesh& mesh, const std::vector<std::uint32_t>& doubled, bool turned)
{
    auto positions = mesh.positions;
    auto triangles = mesh.triangles();
    for (const auto t : doubled) {
        Triangle copy = mesh.triangles()[t];
        for (auto& v : copy) {
            positions.push_back(mesh.positions[v]);
            v = static_cast<std::uint32_t>(positions.size() - 1);
        }
        if (turned) std::swap(copy[0], copy[1]);
        triangles.push_back(copy);
    }
    return meshes::soup(positions, triangles);
}

TriMesh turned_over(const TriMesh& mesh, std::size_t count)
{
    std::vector<Triangle> triangles = mesh.triangles();
    for (std::size_t t = 0; t < count; ++t) std::swap(triangles[t][0], triangles[t][1]);
    return meshes::soup(mesh.positions, triangles);
}

TriMesh both(const TriMesh& a, const TriMesh& b)
{
    const std::array<const TriMesh*, 2> all{&a, &b};
    return merge(all);
}

std::vector<std::uint32_t> first_triangles(std::uint32_t count)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t t = 0; t < count; ++t) out.push_back(t);
    return out;
}

// m^3, by each rule.
void expect_volume(const TriMesh& mesh, double volume, const char* what)
{
    for (const Inside rule : {Inside::winding, Inside::parity}) {
        EXPECT_NEAR(volume_inside(mesh, rule), volume, 0.01 * volume)
            << what << (rule == Inside::parity ? ", parity" : ", winding");
    }
}

TEST(SolidFaces, OfDoubledFacesTheFirstStays)
{
    const TriMesh one = box({1, 1, 1}, {2, 2, 2});
    for (const std::uint32_t count : {7u, 48u}) {
        const TriMesh mesh = with_doubles(one, first_triangles(count), false);
        const SolidFaces faces = solid_faces(mesh);
        EXPECT_EQ(faces.doubled, count);
        EXPECT_EQ(faces.turned, 0u);
        EXPECT_EQ(faces.triangles, one.triangles());
        EXPECT_EQ(faces.source, first_triangles(48));
        expect_volume(mesh, 1, "doubled");
    }
}

TEST(SolidFaces, AWallBetweenTwoBoxesStays)
{
    const TriMesh left = box({1, 1, 1}, {1, 1, 1}), right = meshes::moved(left, {1, 0, 0});
    EXPECT_EQ(solid_faces(both(left, right)).triangles.size(), 24u);
    expect_volume(both(left, right), 2, "two boxes side by side");
    expect_volume(both(both(left, left), right), 2, "one of them twice");
}

TEST(SolidFaces, ASurfaceWithTwoSidesIsOne)
{
    const TriMesh mesh = with_doubles(icosphere(1, 2), first_triangles(320), true);
    EXPECT_EQ(solid_faces(mesh).doubled, 320u);
    expect_volume(mesh, volume_inside(icosphere(1, 2), Inside::parity), "two sides");
}

// A box without its top, as a bowl of two-sided faces: filled, it would hold 1 m^3.
TEST(SolidFaces, AnOpenSurfaceWithTwoSidesEnclosesNothing)
{
    const TriMesh one = box({1, 1, 1}, {1, 1, 1});
    std::vector<Triangle> sides;
    for (const Triangle& t : one.triangles()) {
        const bool top = std::all_of(t.begin(), t.end(),
                                     [&](std::uint32_t v) { return one.positions[v].y() > 0.49f; });
        if (!top) sides.push_back(t);
    }
    ASSERT_EQ(sides.size(), 10u);
    const TriMesh bowl =
        with_doubles(meshes::soup(one.positions, sides), first_triangles(10), true);
    EXPECT_EQ(solid_faces(bowl).doubled, 0u);
    EXPECT_EQ(volume_inside(bowl, Inside::winding), 0);
    // Beside it, a closed one is one solid still.
    const TriMesh ball =
        meshes::moved(with_doubles(icosphere(1, 2), first_triangles(320), true), {5, 0, 0});
    EXPECT_EQ(solid_faces(both(bowl, ball)).doubled, 320u);
}

// Where a core of another matter begins in the same plane as its casing.
TEST(SolidFaces, OfTwoKindsBothStay)
{
    const TriMesh mesh = with_doubles(box({1, 1, 1}, {1, 1, 1}), first_triangles(3), false);
    std::vector<std::uint16_t> kind(15, 0);
    EXPECT_EQ(solid_faces(mesh, kind).doubled, 3u);
    kind[12] = kind[13] = 1;
    EXPECT_EQ(solid_faces(mesh, kind).doubled, 1u);
}

TEST(SolidFaces, MakeAMeshOfTheVerticesThatTheyUse)
{
    const TriMesh one = box({1, 1, 1}, {1, 1, 1});
    const TriMesh mesh = with_doubles(one, first_triangles(4), false);
    const TriMesh made = mesh_of(mesh, solid_faces(mesh));
    EXPECT_EQ(made.positions, one.positions);
    EXPECT_EQ(made.triangles(), one.triangles());
}

// Pieces inside out: those in a closed one stay hollows, whichever of many boxes it is.
TEST(SolidFaces, OfManyPiecesThoseInAnotherStay)
{
    TriMesh all = box({1, 1, 1}, {1, 1, 1});
    const TriMesh small = turned_over(box({0.1, 0.1, 0.1}, {1, 1, 1}), 12);
    for (int i = 0; i < 40; ++i) {
        const int row = i / 10, column = i % 10;
        all = both(all, meshes::moved(small, {column - 4.5, row - 1.5, 0}));
    }
    all = both(all, meshes::moved(small, {0.2, 0.2, 0.2}));
    EXPECT_EQ(solid_faces(all).turned, 40u * 12);
}

TEST(SolidFaces, FacesThatLookInAreTurned)
{
    const TriMesh one = box({1, 1, 1}, {2, 2, 2});
    EXPECT_EQ(solid_faces(turned_over(one, 5)).turned, 5u);
    expect_volume(turned_over(one, 5), 1, "five faces");
    // A leg inside out, half of it in the top: what both hold is inside.
    const TriMesh leg = turned_over(meshes::moved(one, {0.5, 0.25, 0}), 48);
    EXPECT_EQ(solid_faces(both(one, leg)).turned, 48u);
    EXPECT_NEAR(volume_inside(both(one, leg), Inside::winding), 2 - 0.5 * 0.75, 0.02);
}

TEST(SolidFaces, AHollowStays)
{
    const TriMesh shell =
        both(box({2, 2, 2}, {1, 1, 1}), turned_over(box({1, 1, 1}, {1, 1, 1}), 12));
    EXPECT_EQ(solid_faces(shell).turned, 0u);
    expect_volume(shell, 7, "hollow");
}

// About the z axis by an eighth of a turn.
TriMesh slanted(TriMesh mesh, double way)
{
    const auto c = static_cast<float>(std::sqrt(0.5)), s = static_cast<float>(way * c);
    for (Vec3f& p : mesh.positions) p = {c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z()};
    return mesh;
}

TriMesh mirrored(TriMesh mesh)
{
    for (Vec3f& p : mesh.positions) p.x() = -p.x();
    return mesh;
}

// Two bars that cross: the box around one lies in that around the other, but it reaches out of it.
TEST(SolidFaces, APartInTheBoxOfAnotherIsNoHollow)
{
    const TriMesh bar = slanted(box({2, 0.2, 0.2}, {1, 1, 1}), 1),
                  short_bar = slanted(box({1.2, 0.2, 0.1}, {1, 1, 1}), -1);
    const double volume = 0.08 + 0.024 - 0.004;  // less what both hold
    EXPECT_EQ(solid_faces(both(bar, turned_over(short_bar, 12))).turned, 12u);
    EXPECT_EQ(solid_faces(mirrored(both(bar, short_bar))).turned, 24u);
    EXPECT_NEAR(volume_inside(both(bar, turned_over(short_bar, 12)), Inside::winding), volume,
                0.01 * volume);
}

// What lies in another is turned along with it, so that a mirrored model is the mirror image.
TEST(SolidFaces, AMirroredHollowIsAHollow)
{
    const TriMesh wall = box({2, 2, 2}, {1, 1, 1}),
                  hollow = turned_over(box({1, 1, 1}, {1, 1, 1}), 12),
                  stone = box({0.5, 0.5, 0.5}, {1, 1, 1});
    EXPECT_EQ(solid_faces(mirrored(both(wall, hollow))).turned, 24u);
    expect_volume(mirrored(both(wall, hollow)), 7, "hollow");
    expect_volume(mirrored(both(both(stone, hollow), wall)), 7.125, "a stone in a hollow");
    // Beside it nothing is turned.
    const TriMesh beside = meshes::moved(both(wall, hollow), {5, 0, 0});
    EXPECT_EQ(solid_faces(both(mirrored(both(wall, hollow)), beside)).turned, 24u);
}

TEST(SolidFaces, UnsoundTrianglesAreLeftOut)
{
    TriMesh mesh = box({1, 1, 1}, {1, 1, 1});
    auto triangles = mesh.triangles();
    triangles.insert(triangles.begin(), Triangle{0, 1, 99});
    mesh.positions.emplace_back(NAN, 0.0f, 0.0f);
    triangles.push_back({0, 1, 8});
    const SolidFaces faces = solid_faces(meshes::soup(mesh.positions, triangles));
    EXPECT_EQ(faces.doubled, 0u);
    ASSERT_EQ(faces.source.size(), 12u);
    EXPECT_EQ(faces.source.front(), 1u);
    EXPECT_EQ(faces.source.back(), 12u);
}

}  // namespace
