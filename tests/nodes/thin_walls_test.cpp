// What Voxelize says of models that its cubes make too stiff, against the truth: Modes of the same
// cubes, and the theory of beams.

#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"
#include "nodes/large_cubes.hpp"
#include "tests/nodes/one_node.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <regex>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;
using geometry::Vec3;

constexpr double young = 1e9, density = 1000;

TriMesh turned(TriMesh mesh, const Vec3& degrees)
{
    geometry::move(mesh, geometry::placement({0, 0, 0}, degrees, {1, 1, 1}, {0, 0, 0}));
    return mesh;
}

struct Voxelized {
    graph::Value cubes;
    std::vector<std::string> warnings;

    // "about 9 times too stiff": 9; without a warning 1.
    double factor() const
    {
        std::smatch number;
        if (warnings.empty()) return 1;
        EXPECT_EQ(warnings.size(), 1u);
        if (!std::regex_search(warnings[0], number, std::regex("about ([0-9.e+]+) times")))
            return 0;
        return std::stod(number[1]);
    }
    // "use cubes of 0.006 m".
    double remedy() const
    {
        std::smatch number;
        if (!std::regex_search(warnings.at(0), number, std::regex("use cubes of ([0-9.e-]+) m")))
            return 0;
        return std::stod(number[1]);
    }
};

Voxelized voxelized(const TriMesh& mesh, double size, const std::string& method = "solid",
                    double thickness = 0)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("method").is = method;
    node.param("size").is = size;
    node.param("thickness").is = thickness;
    node.param("matter.young").is = young;
    node.param("matter.density").is = density;
    graph::Value cubes = node.run();
    return {std::move(cubes), node.warnings};
}

// The lowest frequency of the free model. Hz.
double lowest_frequency(const TriMesh& mesh, const graph::Value& cubes)
{
    NodeRun node("Modes");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.inputs["cubes"] = {cubes};
    node.param("count").is = std::int64_t{1};
    return *node.outputs().at(1).as<double>();
}

// Hz. Free ends: f = (beta L)^2 / (2 pi L^2) sqrt(E I / (rho A)), I / A = t^2 / 12.
double frequency_of_a_beam(double length, double thick)
{
    return std::pow(4.730041, 2) / (2 * std::numbers::pi * length * length) *
           std::sqrt(young * thick * thick / (12 * density));
}

TEST(ThinWalls, ThePredictedStiffnessIsWithinAFactorOfTheTrueOne)
{
    const double length = 1, thick = 0.02;
    // The length is 50 times the thickness, so shear takes less than 1 %.
    const double beam = frequency_of_a_beam(length, thick);
    struct Case {
        double width;
        Vec3 degrees;
        double cubes;  // in thicknesses
    };
    for (const Case& c :
         {Case{0.1, {0, 0, 0}, 1.5}, Case{0.1, {0, 0, 0}, 3}, Case{0.1, {0, 20, 0}, 1},
          Case{0.1, {20, 20, 20}, 2}, Case{0.1, {45, 0, 0}, 2}, Case{0.02, {30, 45, 10}, 1.5},
          Case{0.02, {20, 20, 20}, 4}}) {
        const TriMesh strip =
            turned(geometry::box({length, c.width, thick}, {20, 2, 1}), c.degrees);
        const Voxelized v = voxelized(strip, c.cubes * thick);
        const double truth = std::pow(lowest_frequency(strip, v.cubes) / beam, 2);
        EXPECT_GT(truth, 1.5);
        EXPECT_LT(v.factor() / truth, 1.5) << c.degrees.transpose() << ", " << c.cubes;
        EXPECT_GT(v.factor() / truth, 1 / 1.5) << c.degrees.transpose() << ", " << c.cubes;
    }
}

TEST(ThinWalls, TheSuggestedCubesAreSmallerThanThoseThatAreTooLarge)
{
    EXPECT_NEAR(nodes::better_size(0.02, 0.05), 0.005, 1e-12);
    // Three cubes thick, and too stiff as its cubes hold something else, too.
    EXPECT_NEAR(nodes::better_size(0.3, 0.1), 0.075, 1e-12);
}

TEST(ThinWalls, TheFactorHasTwoDigitsAndNoExponent)
{
    EXPECT_EQ(nodes::times_text(3.44), "3.4");
    EXPECT_EQ(nodes::times_text(99.7), "100");
    EXPECT_EQ(nodes::times_text(754), "750");
}

TEST(ThinWalls, WithCubesOfTheSuggestedSizeNothingIsSaid)
{
    for (const Vec3& degrees : {Vec3(0, 0, 0), Vec3(0, 5, 0), Vec3(30, 45, 10)}) {
        const TriMesh strip = turned(geometry::box({0.5, 0.1, 0.02}, {1, 1, 1}), degrees);
        const double size = voxelized(strip, 0.05).remedy();
        EXPECT_GT(size, 0.0049);
        EXPECT_EQ(voxelized(strip, size).warnings, std::vector<std::string>{}) << size;
    }
}

// What is promised of the cubes that are advised, and all that is passed over in silence.
TEST(ThinWalls, WithoutAWarningBendingIsWithinTwentyPerCent)
{
    const double length = 0.6, thick = 0.02;
    const double beam = frequency_of_a_beam(length, thick);
    struct Case {
        double width;
        Vec3 degrees;
    };
    for (const Case& c : {Case{0.06, {30, 0, 0}}, Case{0.02, {20, 0, 0}}, Case{0.04, {0, 20, 0}}}) {
        const TriMesh strip =
            turned(geometry::box({length, c.width, thick}, {20, 2, 1}), c.degrees);
        // Cubes of half the thickness are 1.3 to 1.6 times too stiff.
        EXPECT_GT(voxelized(strip, 0.5 * thick).factor(), 1.2) << c.degrees.transpose();
        for (const double size : {0.4 * thick, voxelized(strip, thick).remedy()}) {
            const Voxelized v = voxelized(strip, size);
            const double truth = std::pow(lowest_frequency(strip, v.cubes) / beam, 2);
            EXPECT_TRUE(truth < 1.2 || !v.warnings.empty())
                << c.degrees.transpose() << ", " << size;
            EXPECT_TRUE(size > 0.3 * thick || v.warnings.empty()) << v.warnings[0];
            EXPECT_LT(v.factor() / truth, 1.15) << c.degrees.transpose() << ", " << size;
        }
    }
}

TEST(ThinWalls, OneWayOutIsToldWhereFineCubesAreTooMany)
{
    const auto told = [](const Vec3& size) {
        NodeRun node("Voxelize");
        node.inputs["mesh"] = {
            graph::Value::of(turned(geometry::box(size, {20, 10, 1}), {20, 0, 0}))};
        node.param("method").is = std::string("solid");
        node.param("size").is = 0.02;
        node.param("max_cubes").is = std::int64_t{100'000};
        node.run();
        return node.warnings.at(0);
    };
    const std::string calibrated = told({1, 0.1, 0.004}), neither = told({1, 1, 0.004});
    EXPECT_NE(calibrated.find("; set stiffness = calibrated with cubes of 0.008 m, which is within "
                              "about 20 %, as cubes of 0.001 m would be about "),
              std::string::npos)
        << calibrated;
    EXPECT_NE(
        neither.find("more than max_cubes = 100000, and stiffness = calibrated takes too many"),
        std::string::npos)
        << neither;
}

TEST(ThinWalls, ThePlanForAGapIsThatForBending)
{
    geometry::GluedPieces glued;
    glued.gap = 0.006;
    glued.size = 0.0024;
    geometry::Cubes cubes;
    cubes.size = 0.03;
    cubes.fill = {1, 1};
    const auto plan = [&](double planned) {
        return nodes::plan_for_gap(glued, cubes, false, planned);
    };
    EXPECT_EQ(plan(0), "use cubes of 0.0024 m, or pieces = apart, to keep these two apart");
    EXPECT_EQ(plan(0.002), "cubes of 0.002 m, as bending takes, keep these two apart");
    EXPECT_EQ(plan(0.009),
              "pieces = apart and cubes of 0.009 m, as bending takes, keep these two apart");
    EXPECT_EQ(plan(0.016), "pieces = apart and cubes of 0.011 m, which bend no worse than those "
                           "above, keep these two apart");
    cubes.fill.assign(10'000, 0.3);
    EXPECT_EQ(plan(0), "pieces = apart and cubes of 0.011 m keep these two apart");
}

TEST(ThinWalls, NothingIsSaidOfModelsThatAreRight)
{
    const TriMesh slab = geometry::box({0.5, 0.1, 0.02}, {1, 1, 1});
    EXPECT_TRUE(voxelized(slab, 0.02).warnings.empty()) << "one whole layer of cubes is exact";
    EXPECT_TRUE(voxelized(slab, 0.01).warnings.empty());
    EXPECT_TRUE(voxelized(geometry::icosphere(1, 4), 0.2).warnings.empty());
    EXPECT_TRUE(
        voxelized(turned(geometry::box({1, 1, 1}, {1, 1, 1}), {20, 30, 40}), 0.2).warnings.empty());
    // Of a surface that states no thickness nothing is known.
    EXPECT_TRUE(voxelized(slab, 0.04, "surface").warnings.empty());
}

TEST(ThinWalls, ThePartIsNamed)
{
    const TriMesh block = geometry::box({0.4, 0.4, 0.4}, {1, 1, 1});
    TriMesh seat = geometry::box({0.5, 0.02, 0.5}, {1, 1, 1});
    for (auto& p : seat.positions) p.x() += 2;
    const std::array<const TriMesh*, 2> both{&block, &seat};
    TriMesh mesh = geometry::merge(both);
    EXPECT_EQ(voxelized(mesh, 0.05)
                  .warnings.at(0)
                  .rfind("bending: piece 2 is 0.4 cubes thick (0.02 m, at (2", 0),
              0u)
        << voxelized(mesh, 0.05).warnings.at(0);
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    topology->groups = {"base", "seat"};
    topology->group.assign(12, 0);
    topology->group.insert(topology->group.end(), 12, 1);
    mesh.topology = topology;
    EXPECT_EQ(voxelized(mesh, 0.05).warnings.at(0).rfind("bending: 'seat' is 0.4 cubes thick", 0),
              0u)
        << voxelized(mesh, 0.05).warnings.at(0);
    // The block is eight cubes high, so the seat lies across a plane of the grid, in two layers of
    // cubes: (2 / 0.4)^2.
    EXPECT_NEAR(voxelized(mesh, 0.05).factor(), 25, 0.5);
    // How many more there are, where there are any.
    const auto has = [](const TriMesh& m, const char* words) {
        return voxelized(m, 0.05).warnings.at(0).find(words) != std::string::npos;
    };
    EXPECT_FALSE(has(mesh, " more "));
    TriMesh shelf = geometry::box({0.5, 0.02, 0.5}, {1, 1, 1});
    for (auto& p : shelf.positions) p.x() -= 2;
    const std::array<const TriMesh*, 2> three{&mesh, &shelf};
    EXPECT_TRUE(has(geometry::merge(three), "(1 part more is too thin for these cubes)"));
}

TEST(ThinWalls, SeparatePiecesThatMoveAsOneAreTold)
{
    const TriMesh block = geometry::box({1, 1, 1}, {1, 1, 1});
    TriMesh other = block;
    for (auto& p : other.positions) p.x() += 1.07f;
    const std::array<const TriMesh*, 2> both{&block, &other};
    const auto warnings = voxelized(geometry::merge(both), 0.2).warnings;
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].rfind("2 separate pieces of the mesh share corners of cubes and move as "
                                "one: pieces 1 and 2 are 0.07 m apart at (0.535, ",
                                0),
              0u)
        << warnings[0];
    EXPECT_NE(warnings[0].find("use cubes of 0.033 m, or pieces = apart, to keep"),
              std::string::npos)
        << warnings[0];
}

// A sheet has the thickness that is stated: one layer of cubes, h^2 / t^2.
TEST(ThinWalls, SheetsHaveTheirStatedThickness)
{
    TriMesh sheet = geometry::grid(1, 1, 4, 4);
    for (auto& p : sheet.positions) p.y() += 0.005f;
    const Voxelized v = voxelized(sheet, 0.04, "surface", 0.02);
    EXPECT_NEAR(v.factor(), 4, 0.05);
    EXPECT_NEAR(v.remedy(), 0.005, 1e-9);
}

}  // namespace
