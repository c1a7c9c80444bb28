#include "geometry/cubes/mean_attributes.hpp"

#include "geometry/cubes/local_matter.hpp"
#include "geometry/cubes/sample_points.hpp"
#include "geometry/cubes/sample_surface.hpp"
#include "geometry/cubes/sample_volume.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using namespace geometry;

// An attribute of a mesh: a + b . p, which single precision holds for these meshes.
Attribute linear(const TriMesh& mesh, const std::string& name, float a, const Vec3f& b)
{
    Attribute out{name, "K", {}};
    for (const Vec3f& p : mesh.positions) out.values.push_back(a + b.dot(p));
    return out;
}

std::vector<const Attribute*> all_of(const TriMesh& mesh)
{
    return chosen_attributes("*", mesh.attributes);
}

Vec3 middle(const Cubes& cubes, std::size_t c)
{
    return cubes.origin + cubes.size * (cubes.cell[c].cast<double>() + Vec3::Constant(0.5));
}

std::string refusal(const auto& f)
{
    try {
        f();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "nothing was refused";
}

// A square of 2 by 2 m across y, in cubes of 0.25 m that it passes the middle of: the mean over the
// square in a cube is the value at its middle.
TEST(MeanAttributes, OfALinearOneOnASurfaceIsTheValueInTheMiddleOfEachCube)
{
    TriMesh mesh = grid(2, 2, 3, 5);
    mesh.attributes = {linear(mesh, "heat", 3, {0.5f, 0, 0.25f}), linear(mesh, "x", 0, {1, 0, 0})};
    const VoxelGrid cells{0.25, Vec3(-1, -0.125, -1), Vec3i(8, 1, 8)};
    const Cubes cubes = with_means_of_surface(
        voxelize_surface(mesh, {{}, {Matter{}}, {}}, 0, cells, {}), mesh, all_of(mesh));
    ASSERT_EQ(cubes.count(), 64u);
    ASSERT_EQ(cubes.attributes.size(), 2u);
    EXPECT_EQ(cubes.attributes[0].unit, "K");
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const Vec3 p = middle(cubes, c);
        // Positions at thirds and fifths are rounded to single precision.
        EXPECT_NEAR(cubes.attributes[0].values[c], 3 + 0.5 * p.x() + 0.25 * p.z(), 2e-7);
    }
    // Corners at whole quarters: nothing is rounded.
    TriMesh exact = grid(2, 2, 4, 2);
    exact.attributes = {linear(exact, "heat", 3, {0.5f, 0, 0.25f})};
    const Cubes same = with_means_of_surface(cubes, exact, all_of(exact));
    ASSERT_EQ(same.attributes.size(), 2u);
    for (std::size_t c = 0; c < same.count(); ++c) {
        const Vec3 p = middle(same, c);
        EXPECT_NEAR(same.attributes[0].values[c], 3 + 0.5 * p.x() + 0.25 * p.z(), 1e-9);
    }
}

// A box of 1 m, its attribute 0 at x = -0.5 m and 1 at x = 0.5 m. Each place has the value of the
// side that is nearest. By symmetry the mean over all is 1/2, but for Gauss points as near to two
// sides as to another, which go to either: they change the mean by less than 1e-4.
TEST(MeanAttributes, OfASolidAreThoseOfTheNearestSurface)
{
    TriMesh mesh = box(Vec3(1, 1, 1), Vec3i(2, 2, 2));
    mesh.attributes = {linear(mesh, "wear", 0.5f, {1, 0, 0})};
    const VoxelGrid cells{0.125, Vec3::Constant(-0.5), Vec3i(8, 8, 8)};
    const Cubes cubes = with_means_of_solid(
        voxelize_solid(mesh, {{}, {Matter{}}, {}}, Inside::winding, 0, cells, {}), mesh,
        all_of(mesh));
    ASSERT_EQ(cubes.count(), 512u);
    const Spread spread = value_spread(cubes, "wear");
    EXPECT_NEAR(spread.mean, 0.5, 1e-4);
    EXPECT_GE(spread.least, 0);
    EXPECT_NEAR(spread.least, 0, 1e-12);
    EXPECT_NEAR(spread.most, 1, 1e-12);
    // At the side y = 0.5 all places of a cube are nearest to it, but for those at its rim.
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const Vec3i& cell = cubes.cell[c];
        if (cell.y() != 7 || cell.x() < 1 || cell.x() > 6 || cell.z() < 1 || cell.z() > 6) continue;
        EXPECT_NEAR(cubes.attributes[0].values[c], 0.5 + middle(cubes, c).x(), 1e-9);
    }
}

// A sheet and the mesh that it is of: each triangle has the mean of its corners' values.
TEST(MeanAttributes, OnASheetAreThoseOfItsTriangles)
{
    TriMesh mesh = icosphere(1, 2);
    mesh.attributes = {{"heat", "K", {}}};
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        mesh.attributes[0].values.push_back(float(v * v % 17));
    }
    const Cubes sheet = make_sheet(mesh, 0.01).cubes;
    ASSERT_EQ(sheet.count(), mesh.triangles().size());
    for (const bool solid : {false, true}) {
        const Cubes with = solid ? with_means_of_solid(sheet, mesh, all_of(mesh))
                                 : with_means_of_surface(sheet, mesh, all_of(mesh));
        for (std::size_t c = 0; c < sheet.count(); ++c) {
            double mean = 0;
            for (const auto v : mesh.triangles()[c]) {
                mean += double(mesh.attributes[0].values[v]) / 3;
            }
            EXPECT_NEAR(with.attributes.at(0).values[c], mean, 1e-5);  // places as floats
        }
    }
    // Of another mesh it is the nearest place's: on one larger, of a linear attribute.
    TriMesh around = icosphere(1.1, 5);
    around.attributes = {linear(around, "heat", 1, {2, 0, 0})};
    const Cubes with = with_means_of_surface(sheet, around, all_of(around));
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        // The nearest place lies along the radius, but for the facets, 0.04 m wide: 1e-2 m.
        const Vec3 p = cell_middle(sheet, c).normalized() * 1.1;
        EXPECT_NEAR(with.attributes.at(0).values[c], 1 + 2 * p.x(), 4e-2);
    }
}

// Of two samples in a cube, of 1 and 3 parts of its volume: (1 * 8 + 3 * 4) / 4 = 5. A set without
// the attribute does not count, and a cube of that set alone has 0.
TEST(MeanAttributes, OfSamplesAreByVolume)
{
    Samples heavy;
    heavy.positions = {Vec3f(0.2f, 0.5f, 0.5f), Vec3f(0.7f, 0.5f, 0.5f)};
    heavy.mass = {100, 300};
    heavy.matter = {0, 0};
    heavy.matters = {Matter{}};
    heavy.attributes = {{"heat", "K", {8, 4}}};
    Samples plain = heavy;
    plain.positions = {Vec3f(0.5f, 0.5f, 0.5f), Vec3f(1.5f, 0.5f, 0.5f)};
    plain.attributes.clear();
    const std::array<const Samples*, 2> sets{&plain, &heavy};
    const Cubes cubes = voxelize_samples(sets, {1, Vec3::Zero(), Vec3i(2, 1, 1)}, {});
    ASSERT_EQ(cubes.count(), 2u);
    EXPECT_NEAR(cubes.attributes.at(0).values[0], 5, 1e-12);
    EXPECT_EQ(cubes.attributes[0].values[1], 0);
}

// Samples without a volume count alike, also where weight times value is far below 1e-300.
TEST(MeanAttributes, OfSamplesWithoutVolumeArePlain)
{
    Samples set;
    set.positions = {Vec3f(0.2f, 0.5f, 0.5f), Vec3f(0.7f, 0.5f, 0.5f), Vec3f(1.5f, 0.5f, 0.5f),
                     Vec3f(1.6f, 0.5f, 0.5f)};
    set.attributes = {{"heat", "K", {1e-30f, 3e-30f, 5, 7}}};
    const std::array<const Samples*, 1> sets{&set};
    const std::vector<Deposit> deposits{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 1e-9}};
    Cubes cubes = solid_cubes({{0, 0, 0}, {1, 0, 0}}, 1);
    add_means_of_samples(cubes, deposits, sets, std::vector<std::uint8_t>(4, 1));
    const std::vector<double>& means = cubes.attributes.at(0).values;
    EXPECT_NEAR(means[0], 2e-30, 1e-36);  // the values are rounded to single precision
    EXPECT_NEAR(means[1], 7, 1e-12);      // beside one that has a volume they are nothing
}

// A needle 1 m long and 1e-12 m wide: rounded to single precision, a place on it lies up to 3e-8 m
// beside it, which is 3e4 times its width.
TEST(MeanAttributes, OnANeedleAreWithinThoseOfItsCorners)
{
    TriMesh mesh;
    mesh.positions = {Vec3f(0, 0, 0), Vec3f(1, 1, 0), Vec3f(0.5f, 0.5f, 1e-12f)};
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 1, 2}};
    mesh.topology = topology;
    mesh.attributes = {{"heat", "K", {1, 2, 3}}};
    Samples on;
    for (int i = 1; i < 100; ++i) {
        const float x = float(i) / 100;
        on.positions.emplace_back(x, x, (i % 2 ? 3e-8f : -3e-8f));
        on.triangle.push_back(0);
    }
    add_attributes(on, mesh, all_of(mesh));
    for (const float value : on.attributes.at(0).values) {
        EXPECT_GE(value, 1 - 1e-6f);
        EXPECT_LE(value, 3 + 1e-6f);
    }
}

TEST(MeanAttributes, SamplesHaveTheValueOfTheirPlace)
{
    TriMesh mesh = box(Vec3(1, 1, 1), Vec3i(1, 1, 1));
    mesh.attributes = {linear(mesh, "heat", 2, {1, -0.5f, 0.25f})};
    const FaceMatter matter{{}, {Matter{}}, {}};
    Samples on = sample_surface(mesh, matter, 500, 1);
    add_attributes(on, mesh, all_of(mesh));
    for (std::size_t i = 0; i < 500; ++i) {
        const float expected = 2 + Vec3f(1, -0.5f, 0.25f).dot(on.positions[i]);
        EXPECT_NEAR(on.attributes.at(0).values.at(i), expected, 1e-6);
    }
    TriMesh cloud;
    cloud.positions = {Vec3f(0, 0, 0), Vec3f(NAN, 0, 0), Vec3f(1, 0, 0)};
    cloud.attributes = {{"heat", "", {1, 2, 3}}};
    Samples points = sample_points(cloud, {}, {});
    add_attributes(points, cloud, all_of(cloud));
    EXPECT_EQ(points.attributes.at(0).values, (std::vector<float>{1, 3}));
}

TEST(MeanAttributes, AreChosenByNamesAndPatterns)
{
    const std::vector<Attribute> all{{"heat", "", {}}, {"wear_low", "", {}}, {"wear_high", "", {}}};
    const auto names = [&](const std::string& wanted) {
        std::string out;
        for (const Attribute* a : chosen_attributes(wanted, all)) out += a->name + " ";
        return out;
    };
    EXPECT_EQ(names(""), "");
    EXPECT_EQ(names("*"), "heat wear_low wear_high ");
    EXPECT_EQ(names("wear_*, heat"), "heat wear_low wear_high ");
    EXPECT_EQ(names("wear_high"), "wear_high ");
    EXPECT_EQ(names("cold*"), "");
    EXPECT_EQ(refusal([&] { names("heat, cold"); }),
              "the mesh has no attribute 'cold'; it has heat, wear_low, wear_high");
    // Names of what all cubes have: patterns pass them over.
    const std::vector<Attribute> scan{{"density", "", {}}, {"speed", "", {}}, {"heat", "", {}}};
    EXPECT_EQ(chosen_attributes("*", scan), std::vector<const Attribute*>{&scan[2]});
    EXPECT_EQ(refusal([&] { chosen_attributes("density", scan); }),
              "all cubes have 'density': set it as that property with LocalMatter, or give it "
              "another name with Attributes, such as \"my_density\" with the value \"density\"");
}

TEST(LocalMatter, NamesOfOtherQuantitiesAndValuesThatAreNotFiniteAreRefused)
{
    const Cubes cubes = solid_cubes({{0, 0, 0}, {1, 0, 0}}, 1);
    EXPECT_NE(refusal([&] {
                  with_attribute(cubes, {"young", "", {1, 2}});
              }).find("all cubes have 'young'"),
              std::string::npos);
    EXPECT_NE(refusal([&] {
                  with_attribute(cubes, {"stress", "", {1, 2}});
              }).find("choose another name"),
              std::string::npos);
    EXPECT_EQ(refusal([&] {
                  with_attribute(cubes, {"heat", "", {1, NAN}});
              }),
              "expected a finite number, found nan in the cube at (1.5, 0.5, 0.5)");
    EXPECT_NE(refusal([&] {
                  cube_values(with_attribute(cubes, {"heat", "", {1, 2}}), "cold");
              })
                  .find("no attribute 'cold'; they have young, density, poisson, mass_damping, "
                        "stiffness_damping, fill, heat"),
              std::string::npos);
    EXPECT_NE(refusal([&] {
                  with_local_values(cubes, LocalProperty::thickness, {1, 1});
              }).find("only a Plane or a Sheet has a thickness"),
              std::string::npos);
}

// The mean of a quadratic polynomial over a triangle is that over the middles of its sides.
TEST(LocalMatter, MeansOverASheetAreExactForQuadratics)
{
    const Cubes sheet = make_sheet(icosphere(1, 1), 0.01).cubes;
    const auto f = [](const Vec3& p) {
        return 2 + p.x() - 3 * p.x() * p.y() + p.z() * p.z() + 0.5 * p.y() * p.y();
    };
    const std::vector<double> means =
        cube_means(sheet, [&](const Vec3& p, std::size_t) { return f(p); });
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        const auto [a, b, d] = sheet_triangle(sheet, c);
        const Vec3 &A = sheet.place[a], &B = sheet.place[b], &D = sheet.place[d];
        EXPECT_NEAR(means[c], (f((A + B) / 2) + f((B + D) / 2) + f((D + A) / 2)) / 3, 1e-14);
        for (const Vec3& p : sheet_points(sheet, c)) {
            const Vec3 n = (B - A).cross(D - A);
            EXPECT_NEAR((p - A).dot(n), 0, 1e-15);
            // Off each side, by a sixth of the triangle.
            EXPECT_GT((B - A).cross(p - A).dot(n), 0.16 * n.squaredNorm());
            EXPECT_GT((D - B).cross(p - B).dot(n), 0.16 * n.squaredNorm());
            EXPECT_GT((A - D).cross(p - D).dot(n), 0.16 * n.squaredNorm());
        }
    }
    const std::vector<double> own =
        cube_means(sheet, [](const Vec3&, std::size_t c) { return double(c); });
    for (std::size_t c = 0; c < own.size(); ++c) EXPECT_NEAR(own[c], double(c), 1e-13);
}

TEST(LocalMatter, OfASheetTakesItsThicknessAndArea)
{
    TriMesh mesh;  // triangles of 1.5 and 0.5 m^2
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, -3, 0}, {0, 1, 0}};
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 2, 1}, {0, 1, 3}};
    mesh.topology = topology;
    const Cubes sheet = make_sheet(mesh, 0.02).cubes;
    ASSERT_EQ(sheet.count(), 2u);
    const Cubes heavy = with_local_values(sheet, LocalProperty::density, {500, 2000});
    EXPECT_NEAR(heavy.mass[0], 500 * 0.02 * cell_area(sheet, 0), 1e-12);
    EXPECT_NEAR(heavy.mass[1], 2000 * 0.02 * cell_area(sheet, 1), 1e-12);
    EXPECT_NEAR(material_densities(heavy)[1], 2000, 1e-9);
    const Cubes thick = with_local_values(heavy, LocalProperty::thickness, {0.01, 0.08});
    EXPECT_NEAR(thick.mass[1], 2000 * 0.08 * cell_area(sheet, 1), 1e-12);
    EXPECT_NEAR(thick.fill[1] * thick.size, 0.08, 1e-15);
    EXPECT_NEAR(material_densities(thick)[0], 500, 1e-9);
    // The mean by the volume that fills them.
    const double first = 0.01 * 1.5, second = 0.08 * 0.5;  // m^3
    EXPECT_NEAR(value_spread(thick, "density").mean,
                (500 * first + 2000 * second) / (first + second), 1e-9);
    const Vec3 middle = cell_middle(sheet, 1);
    EXPECT_EQ(refusal([&] {
                  with_local_values(sheet, LocalProperty::young, {1, -1});
              }),
              fmt::format("expected a value above 0, found -1 in the triangle at ({:.3g}, {:.3g}, "
                          "{:.3g})",
                          middle.x(), middle.y(), middle.z()));
}

TEST(LocalMatter, AttributesStayWithTheirCubes)
{
    const Cubes cubes =
        with_attribute(solid_cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, 1), {"heat", "K", {1, 2, 3}});
    const Cubes ends = kept(cubes, {1, 0, 1});
    ASSERT_EQ(ends.attributes.size(), 1u);
    EXPECT_EQ(ends.attributes[0].values, (std::vector<double>{1, 3}));
    EXPECT_EQ(ends.attributes[0].unit, "K");
}

}  // namespace
