#include "geometry/cubes/sheet.hpp"

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/cubes_mesh.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace {

using namespace geometry;
using test_meshes::mesh_of;

// Cloth of 200 kg/m^3.
Matter cloth()
{
    Matter matter;
    matter.name = "cloth";
    matter.density = 200;
    matter.young = 3e5;
    matter.poisson = 0.3;
    return matter;
}

// A square of 2 m in two triangles, whose diagonal runs from corner 0 to corner 2.
TriMesh square()
{
    return mesh_of({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, {{0, 1, 2}, {0, 2, 3}});
}

std::string refusal_of_sheet(const TriMesh& mesh, double thickness)
{
    try {
        make_sheet(mesh, thickness);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "nothing was refused";
}

TEST(Sheet, HasACellForEachTriangleAndACornerForEachVertex)
{
    const TriMesh mesh = icosphere(1, 2);
    const SheetOfMesh made = make_sheet(mesh, 0.01, cloth());
    const Cubes& sheet = made.cubes;
    EXPECT_TRUE(sheet.is_sheet());
    EXPECT_EQ(made.left_out, 0u);
    EXPECT_EQ(made.joints, 0u);
    ASSERT_EQ(sheet.count(), mesh.triangles().size());
    ASSERT_EQ(sheet.corner_count(), mesh.positions.size());
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        EXPECT_EQ(sheet_triangle(sheet, c), mesh.triangles()[c]);
        EXPECT_EQ(sheet.young[c], 3e5);
        EXPECT_EQ(sheet.poisson[c], 0.3);
        EXPECT_NEAR(sheet.fill[c] * sheet.size, 0.01, 1e-15);
    }
    for (std::size_t k = 0; k < sheet.corner_count(); ++k) {
        EXPECT_EQ(sheet.corner_position(k), mesh.positions[k].cast<double>());
    }
    EXPECT_EQ(sheet_mesh(sheet).triangles(), mesh.triangles());
    EXPECT_EQ(sheet_mesh(sheet).positions, mesh.positions);
}

// Every list of a sheet's cells and corners has its length, as it has of other cubes.
TEST(Sheet, IsWholeAsOtherCubesAre)
{
    const Cubes sheet = make_sheet(square(), 0.01).cubes;
    const std::size_t n = sheet.count();
    for (const std::size_t size :
         {sheet.corners.size(), sheet.mass.size(), sheet.fill.size(), sheet.young.size(),
          sheet.poisson.size(), sheet.mass_damping.size(), sheet.stiffness_damping.size(),
          sheet.matter.size()}) {
        EXPECT_EQ(size, n);
    }
    EXPECT_EQ(sheet.corner.size(), sheet.place.size());
    EXPECT_NO_THROW(check_elements(sheet));
    EXPECT_EQ(flat_axis(sheet), 2);
    // Sides of 2, 2 and sqrt(8) m.
    EXPECT_NEAR(sheet.size, (4 + std::sqrt(8.0)) / 3, 1e-15);
}

TEST(Sheet, WeighsDensityTimesThicknessTimesArea)
{
    const TriMesh mesh = torus(1, 0.3, 24, 12);
    const Cubes sheet = make_sheet(mesh, 0.02, cloth()).cubes;
    double area = 0;
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        area += cell_area(sheet, c);
        EXPECT_NEAR(sheet.mass[c], 200 * 0.02 * cell_area(sheet, c), 1e-12);
    }
    constexpr double pi_sq = std::numbers::pi * std::numbers::pi;
    // Of a regular polygon of 12 sides turned about an axis, in 24 steps: less than the torus.
    EXPECT_LT(area, 4 * pi_sq * 0.3);
    EXPECT_GT(area, 0.95 * 4 * pi_sq * 0.3);
    EXPECT_NEAR(total_mass(sheet), 200 * 0.02 * area, 1e-9);
    EXPECT_NEAR(cell_area(make_sheet(square(), 1).cubes, 0), 2, 1e-15);
}

TEST(Sheet, GivesEachCornerOfATriangleAThirdOfItsMass)
{
    const Cubes sheet = make_sheet(square(), 0.01, cloth()).cubes;
    // 200 kg/m^3 * 0.01 m * 2 m^2 = 4 kg a triangle; corners 0 and 2 are of both.
    const std::vector<double> expected{8.0 / 3, 4.0 / 3, 8.0 / 3, 4.0 / 3};
    const std::vector<double> masses = corner_masses(sheet);
    ASSERT_EQ(masses.size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(masses[k], expected[k], 1e-14);
    const std::array<double, 8> shares = corner_shares(sheet, 1);
    double sum = 0;
    for (const double s : shares) sum += s;
    EXPECT_NEAR(sum, 1, 1e-15);
}

TEST(Sheet, WeldsVerticesAtOnePlace)
{
    // The square's triangles with vertices of their own, as at a seam of texture coordinates, and
    // -0 for 0.
    const TriMesh apart =
        mesh_of({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {-0.0f, 0, -0.0f}, {2, 2, 0}, {0, 2, 0}},
                {{0, 1, 2}, {3, 4, 5}});
    const Cubes sheet = make_sheet(apart, 0.01).cubes;
    EXPECT_EQ(sheet.corner_count(), 4u);
    EXPECT_EQ(sheet_triangle(sheet, 1), (Triangle{0, 2, 3}));
    EXPECT_EQ(sheet.place[3], Vec3(0, 2, 0));
}

TEST(Sheet, LeavesOutWhatHasNoAreaOrIsThereAlready)
{
    TriMesh mesh = square();
    mesh.positions.insert(mesh.positions.end(), {Vec3f(1, 1, 0), Vec3f(NAN, 0, 0), Vec3f(5, 5, 5)});
    mesh = mesh_of(mesh.positions, {{0, 1, 2},
                                    {0, 0, 1},   // a vertex twice
                                    {0, 4, 2},   // on one line
                                    {1, 2, 0},   // the first again
                                    {2, 1, 0},   // and from its other side
                                    {0, 1, 5},   // not finite
                                    {0, 1, 77},  // not there
                                    {0, 2, 3}});
    const SheetOfMesh made = make_sheet(mesh, 0.01);
    EXPECT_EQ(made.left_out, 4u);
    EXPECT_EQ(made.doubled, 2u);
    ASSERT_EQ(made.cubes.count(), 2u);
    EXPECT_EQ(made.cubes.corner_count(),
              4u);  // vertices 4, 5 and 6 are of no triangle that is left
    EXPECT_EQ(sheet_triangle(made.cubes, 1), (Triangle{0, 2, 3}));
    for (const Vec3& p : made.cubes.place) EXPECT_TRUE(p.allFinite());
}

TEST(Sheet, CountsTheEdgesWhereMoreThanTwoTrianglesMeet)
{
    // Three leaves of a book, then a fourth, at one spine; then a leaf at another edge.
    std::vector<Vec3f> p{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}};
    EXPECT_EQ(make_sheet(mesh_of(p, {{0, 1, 2}, {0, 1, 3}}), 0.01).joints, 0u);
    EXPECT_EQ(make_sheet(mesh_of(p, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}), 0.01).joints, 1u);
    EXPECT_EQ(make_sheet(mesh_of(p, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}}), 0.01).joints,
              1u);
    p.insert(p.end(), {Vec3f(2, 2, 2), Vec3f(2, 2, -2)});
    const TriMesh two =
        mesh_of(p, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {1, 2, 6}, {1, 2, 7}, {0, 2, 5}});
    EXPECT_EQ(make_sheet(two, 0.01).joints, 2u);
}

TEST(Sheet, OfNothingIsRefused)
{
    EXPECT_EQ(refusal_of_sheet(square(), 0),
              "expected a thickness of the sheet above 0 m, found 0");
    EXPECT_NE(refusal_of_sheet(square(), NAN).find("above 0 m, found nan"), std::string::npos);
    EXPECT_NE(refusal_of_sheet(square(), INFINITY).find("above 0 m, found inf"), std::string::npos);
    EXPECT_NE(refusal_of_sheet(mesh_of({{0, 0, 0}}, {}), 1).find("needs a mesh with faces"),
              std::string::npos);
    EXPECT_NE(refusal_of_sheet(mesh_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}), 1)
                  .find("faces that have an area"),
              std::string::npos);
    EXPECT_NE(refusal_of_sheet(TriMesh{}, 1).find("needs a mesh with faces"), std::string::npos);
}

// What interpolates between the corners of a cube does so between those of the triangle.
TEST(Sheet, APlaceInACellIsThatOfTheTriangle)
{
    const Cubes sheet = make_sheet(icosphere(1, 1), 0.01).cubes;
    const Random random(3);
    for (std::uint64_t i = 0; i < 200; ++i) {
        // Inside, and by the modulus on sides and at corners too.
        Vec3 share(i % 5 == 0 ? 0 : random.unit(3 * i), i % 7 == 0 ? 0 : random.unit(3 * i + 1),
                   i % 3 == 0 ? 0 : random.unit(3 * i + 2));
        if (i % 105 == 0) share = Vec3::UnitZ();
        share /= share.sum();
        const std::size_t cell = i % sheet.count();
        const Vec3 place = place_in_cell(share);
        EXPECT_EQ(place.z(), 0);
        EXPECT_TRUE((place.array() >= 0).all() && (place.array() <= 1).all());
        const std::array<double, 8> w = trilinear_weights(place);
        Vec3 by_cube = Vec3::Zero(), by_triangle = Vec3::Zero();
        for (std::size_t a = 0; a < 8; ++a) {
            by_cube += w[a] * sheet.place[sheet.corners[cell][a]];
        }
        for (std::size_t a = 0; a < 3; ++a) {
            by_triangle +=
                share[static_cast<Eigen::Index>(a)] * sheet.place[sheet_triangle(sheet, cell)[a]];
        }
        EXPECT_NEAR((by_cube - by_triangle).norm(), 0, 1e-15);  // sums of numbers below 1
    }
}

TEST(Sheet, KeptTrianglesKeepTheirPlaces)
{
    const Cubes sheet = make_sheet(icosphere(1, 2), 0.01).cubes;
    std::vector<std::uint8_t> keep(sheet.count(), 0);
    for (std::size_t c = 0; c < keep.size(); c += 3) keep[c] = 1;
    const Cubes some = kept(sheet, keep);
    ASSERT_TRUE(some.is_sheet());
    ASSERT_EQ(some.place.size(), some.corner_count());
    std::size_t at = 0;
    for (std::size_t c = 0; c < sheet.count(); c += 3, ++at) {
        EXPECT_EQ(cell_middle(some, at), cell_middle(sheet, c));
        EXPECT_EQ(cell_area(some, at), cell_area(sheet, c));
        EXPECT_EQ(some.mass[at], sheet.mass[c]);
    }
    EXPECT_EQ(at, some.count());
}

// At a corner of a box three sides meet at right angles.
TEST(Sheet, NormalsAreTheMeanByAngles)
{
    const TriMesh mesh = test_meshes::box({0, 0, 0}, {1, 1, 1});
    const Cubes sheet = make_sheet(mesh, 0.01).cubes;
    const std::vector<Vec3> normals = sheet_normals(sheet, sheet.place);
    for (std::size_t k = 0; k < normals.size(); ++k) {
        // However many triangles a side has there, they make a right angle together.
        const Vec3 outward = (sheet.place[k] - Vec3::Constant(0.5)).normalized();
        EXPECT_NEAR((normals[k] - outward).norm(), 0, 1e-14);
    }
    // What has collapsed has none.
    const std::vector<Vec3> point(sheet.corner_count(), Vec3(1, 2, 3));
    for (const Vec3& n : sheet_normals(sheet, point)) EXPECT_EQ(n, Vec3(Vec3::Zero()));
}

TEST(Sheet, ShowsAsItsMeshWhereAPlaneIsAskedFor)
{
    const TriMesh mesh = icosphere(1, 2);
    const Cubes sheet = make_sheet(mesh, 0.01, cloth()).cubes;
    EXPECT_EQ(plane_mesh(sheet).triangles(), mesh.triangles());
    EXPECT_EQ(plane_mesh(sheet).positions, mesh.positions);
    EXPECT_EQ(plane_normals(sheet, sheet.place), sheet_normals(sheet, sheet.place));
    const TriMesh drawn = cubes_mesh(sheet, sheet.place);
    EXPECT_EQ(drawn.triangles(), mesh.triangles());
    for (const float density : drawn.attributes.at(0).values) EXPECT_NEAR(density, 200, 1e-4);
    // Each triangle counts alike at its three corners.
    Cubes two = make_sheet(square(), 0.01).cubes;
    two.young = {8, 4};
    EXPECT_EQ(cubes_mesh(two, two.place).attributes.at(1).values, (std::vector<float>{6, 8, 6, 4}));
    try {
        need_thickness(sheet, "bricks");
        ADD_FAILURE() << "nothing was refused";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("bricks needs cubes with a thickness"),
                  std::string::npos);
        EXPECT_NE(std::string(error.what()).find("sheet of a mesh"), std::string::npos);
    }
}

// Two squares that touch at one vertex, and a third beside them.
TEST(Sheet, HangsTogetherBySidesOrByCorners)
{
    TriMesh mesh = test_meshes::both(square(), square());
    for (std::size_t v = 4; v < 8; ++v) mesh.positions[v] += Vec3f(2, 2, 0);
    TriMesh far = square();
    for (Vec3f& p : far.positions) p += Vec3f(9, 0, 0);
    const Cubes sheet = make_sheet(test_meshes::both(mesh, far), 0.01).cubes;
    const auto counts = [&](Connectivity c) { return find_components(sheet, c).cubes; };
    EXPECT_EQ(counts(Connectivity::face), (std::vector<std::size_t>{2, 2, 2}));
    EXPECT_EQ(counts(Connectivity::edge), (std::vector<std::size_t>{2, 2, 2}));
    EXPECT_EQ(counts(Connectivity::corner), (std::vector<std::size_t>{4, 2}));
    // Two triangles beside each other that have no corner in common, whatever cells they are in.
    const TriMesh one = mesh_of({{0, 0, 0}, {1, 0, 0}, {0.5f, 0.8f, 0}}, {{0, 1, 2}});
    TriMesh beside = one;
    for (Vec3f& p : beside.positions) p += Vec3f(1.1f, 0, 0);
    const Cubes apart = make_sheet(test_meshes::both(one, beside), 0.01).cubes;
    EXPECT_EQ(find_components(apart, Connectivity::corner).count(), 2u);
    // The nearest triangle: 0.5 m above the middle of the last.
    const NearestCube nearest = nearest_cube(sheet, cell_middle(sheet, 5) + Vec3(0, 0, 0.5));
    EXPECT_EQ(nearest.cube, 5u);
    EXPECT_NEAR(nearest.distance, 0.5, 1e-6);  // in single precision
}

}  // namespace

TEST(Sheet, TurnsNeighboursToFaceTheSameWay)
{
    TriMesh mesh = geometry::icosphere(1, 2);
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    for (std::size_t t = 1; t < topology->triangles.size(); t += 3) {
        std::swap(topology->triangles[t][1], topology->triangles[t][2]);
    }
    mesh.topology = std::move(topology);
    const Cubes sheet = geometry::make_sheet(mesh, 0.01).cubes;
    std::size_t out = 0;
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        const auto k = geometry::sheet_triangle(sheet, c);
        const Vec3 a = sheet.place[k[0]], b = sheet.place[k[1]], d = sheet.place[k[2]];
        if ((b - a).cross(d - a).dot(a + b + d) > 0) ++out;
    }
    EXPECT_EQ(out, sheet.count());
}

TEST(Sheet, CutsFacesUntilNoSideIsLongerThanAsked)
{
    const TriMesh mesh = geometry::box({1, 0.5, 0.3}, {1, 1, 1});
    const Cubes whole = geometry::make_sheet(mesh, 0.01, cloth()).cubes;
    const geometry::SheetOfMesh cut = geometry::make_sheet(mesh, 0.01, cloth(), 0.11);
    EXPECT_EQ(cut.joints, 0u);
    EXPECT_NEAR(geometry::total_mass(cut.cubes), geometry::total_mass(whole), 1e-6);
    const TriMesh drawn = geometry::sheet_mesh(cut.cubes);
    EXPECT_TRUE(geometry::is_closed(drawn.triangles(), drawn.positions.size()));
    for (std::size_t c = 0; c < cut.cubes.count(); ++c) {
        const auto k = geometry::sheet_triangle(cut.cubes, c);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_LE((cut.cubes.place[k[i]] - cut.cubes.place[k[(i + 1) % 3]]).norm(), 0.11);
        }
    }
    EXPECT_THROW(geometry::make_sheet(mesh, 0.01, cloth(), 1e-5), std::invalid_argument);
}
