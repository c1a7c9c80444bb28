// What `aspic card` says of a body, by numbers that are known beforehand.

#include "nodes/body_figures.hpp"

#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bending_error.hpp"
#include "runtime/commands/command_line.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <sstream>

namespace {

// A box of 1 x 0.4 x 0.2 m at (3, 2, 1), in cubes of 0.1 m: no cube is partly filled.
const char* const document = R"({ "aspic": 1, "nodes": {
    "box": { "type": "Primitive@1", "params": {
        "shape": "box", "box": { "size": [1, 0.4, 0.2] }, "centre": [3, 2, 1] } },
    "body": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" }, "params": {
        "method": "solid", "size": 0.1, "matter": { "density": 500 } } } } })";

int run(const std::vector<std::string>& args, std::string& out, std::string& err)
{
    std::ostringstream o, e;
    runtime::Console console{o, e, false, {}, {}, "test"};
    const int exit = runtime::run_command_line(args, nodes::registry(), console);
    out = o.str(), err = e.str();
    return exit;
}

TEST(BodyCard, SaysWhatIsExactAndWhatTheCubesMakeOfIt)
{
    const files::Folder folder;
    std::string out, err;
    ASSERT_EQ(
        run({"card", folder.write("box.json", document).string(), "--no-disk-cache", "--json"}, out,
            err),
        runtime::exit_ok)
        << err;
    const auto all = nlohmann::json::parse(out);
    EXPECT_EQ(all["body"], "body");
    const auto near = [&](const char* name, double mesh, double cubes) {
        const auto& line = all["card"].at(name);
        EXPECT_NEAR(line["mesh"].get<double>(), mesh, 1e-6) << name;
        EXPECT_NEAR(line["cubes"].get<double>(), cubes, 1e-6) << name;
    };
    EXPECT_EQ(all["card"]["cubes"]["cubes"], 80);
    EXPECT_TRUE(all["card"]["cubes"]["mesh"].is_null());
    EXPECT_NEAR(all["card"]["mass, kg"]["cubes"].get<double>(), 40, 1e-5);
    EXPECT_NEAR(all["card"]["mass, kg"]["mesh"].get<double>(), 40, 1e-4);
    near("volume, m^3", 0.08, 0.08);
    near("centre x, m", 3, 3);
    near("centre y, m", 2, 2);
    near("centre z, m", 1, 1);
    // (b^2 + c^2) / 12 of the box. A brick resists turning by w_1 = 0.3593 in place of 1/3 (see
    // physics/state/cube_mass.hpp): (3 w_1 - 1) h^2 more to the square of each side.
    const double more = (3 * 0.3593 - 1) * 0.01 / 12;
    near("inertia about x per mass, m^2", 0.2 / 12, 0.2 / 12 + 2 * more);
    near("inertia about y per mass, m^2", 1.04 / 12, 1.04 / 12 + 2 * more);
    near("inertia about z per mass, m^2", 1.16 / 12, 1.16 / 12 + 2 * more);
    near("stiffness in bending, of the true one", 1, 1);
}

// Not a number where the card does not know it.
double stiffness_in_bending(const std::string& box, double size)
{
    const files::Folder folder;
    std::string out, err;
    const std::string file = folder.write("box.json", document).string();
    EXPECT_EQ(run({"card", file, "--no-disk-cache", "--json", "--set", "box.box.size=" + box,
                   "--set", "body.size=" + std::to_string(size)},
                  out, err),
              runtime::exit_ok)
        << err;
    const auto card = nlohmann::json::parse(out).at("card");
    const auto& told = card.at("stiffness in bending, of the true one").at("cubes");
    return told.is_null() ? std::nan("") : told.get<double>();
}

// Of n full cubes and two that are filled to a share g, t = n + 2 g thick: these stand for matter
// that is nearer to the middle by (1 - g) / 2 and has g^2 / 12 of its own about its middle.
TEST(BodyCard, TheStiffnessInBendingCountsOuterCubesThatArePartlyFilled)
{
    const auto factor = [](double n, double g) {
        const double t = n + 2 * g, spread = std::pow((n + 1) / 2, 2) + 1.0 / 12;
        return (n * n * n / 12 + 2 * g * spread) / (t * t * t / 12);
    };
    EXPECT_NEAR(factor(4, 0.6), 1.104, 0.002);
    EXPECT_NEAR(stiffness_in_bending("[1, 0.1, 0.13]", 0.025), factor(4, 0.6), 0.01);
    EXPECT_NEAR(stiffness_in_bending("[1, 0.1, 0.13]", 0.0125), factor(9, 0.7), 0.003);
}

TEST(BodyCard, OfBodiesThatAreThickerThanIsLookedAtNoStiffnessIsTold)
{
    EXPECT_TRUE(std::isnan(stiffness_in_bending("[0.5, 0.26, 0.26]", 0.02)));
    EXPECT_NEAR(stiffness_in_bending("[1, 0.2, 0.2]", 0.02), 1, 1e-6);
}

// A ball with a hollow of 8 cubes.
TEST(BodyCard, AHollowIsNoWall)
{
    const geometry::TriMesh outer = geometry::icosphere(0.5, 3);
    geometry::TriMesh inner = geometry::icosphere(0.4, 3);
    geometry::MeshTopology in = *inner.topology;
    for (auto& t : in.triangles) std::swap(t[1], t[2]);
    inner.topology = std::make_shared<const geometry::MeshTopology>(std::move(in));
    const std::array<const geometry::TriMesh*, 2> both{&outer, &inner};
    const geometry::TriMesh mesh = geometry::merge(both);
    const geometry::Cubes cubes = geometry::voxelize_solid(
        mesh, geometry::FaceMatter{{}, {geometry::Matter{}}, {}}, geometry::Inside::winding, 0,
        {0.1, {-0.5, -0.5, -0.5}, geometry::Vec3i::Zero()}, {});
    for (const auto& part : physics::thin_parts(mesh, cubes, {})) {
        EXPECT_LT(part.thickness, 0.2) << part.name;
    }
}

TEST(BodyCard, TheTextNamesTheBodyAndItsErrors)
{
    const files::Folder folder;
    std::string out, err;
    const std::string file = folder.write("box.json", document).string();
    ASSERT_EQ(run({"card", file, "--no-disk-cache", "--set", "body.size=0.4"}, out, err),
              runtime::exit_ok)
        << err;
    EXPECT_EQ(out.rfind("body ", 0), 0u) << out;
    // One layer of cubes for half of one: (0.4 / 0.2)^2.
    EXPECT_NE(out.find("+300 %"), std::string::npos) << out;
    EXPECT_NE(err.find("2 m, at"), std::string::npos) << err;
    const std::string none = folder.write("none.json", R"({ "aspic": 1, "nodes": {} })").string();
    EXPECT_EQ(run({"card", none, "--no-disk-cache"}, out, err), runtime::exit_failed);
    EXPECT_NE(err.find("makes no cubes of a mesh"), std::string::npos) << err;
}

TEST(BodyCard, OfAnOpenMeshNothingIsKnown)
{
    fixtures::NodeRun node("Voxelize");
    const auto mesh = graph::Value::of(geometry::grid(1, 1, 2, 2));
    node.inputs["mesh"] = {mesh};
    node.param("method").is = std::string("surface");
    node.param("size").is = 0.1;
    node.run();
    ASSERT_FALSE(node.told.all.empty());
    for (const graph::Figure& figure : node.told.all) {
        EXPECT_TRUE(std::isnan(figure.of)) << figure.name;
    }
}

TEST(BodyCard, OfSeveralDensitiesTheMassOfTheMeshIsNotKnown)
{
    geometry::Cubes cubes;
    cubes.size = 0.1;
    cubes.cell.resize(3);
    cubes.fill = {1, 0.5, 0.25};
    cubes.mass = {0.5, 0.25, 0.125};
    EXPECT_NEAR(nodes::one_density(cubes), 500, 1e-9);
    cubes.mass[1] = 0.26;
    EXPECT_TRUE(std::isnan(nodes::one_density(cubes)));
}

// A plate of 1 mm in cubes of 0.1 m: of each a hundredth, which min_fill counts as two.
TEST(BodyCard, TheMassOfTheMeshIsThatOfItsMaterial)
{
    const geometry::TriMesh plate = geometry::box({1, 0.001, 1}, {1, 1, 1});
    const auto mass = [&](double total) {
        geometry::VoxelOptions options;
        options.total_mass = total;
        const geometry::Cubes cubes = geometry::voxelize_solid(
            plate,
            geometry::FaceMatter{{}, {{.density = 1000}, {.density = 1000, .young = 1e9}}, {}},
            geometry::Inside::winding, 0, {0.1, {-0.5, -0.05, -0.5}, geometry::Vec3i::Zero()},
            options);
        return nodes::body_figures(&plate, cubes, true, 1, false, total).all[3];
    };
    for (const double total : {0.0, 7.0}) {
        const double known = total > 0 ? total : 1;
        EXPECT_NEAR(mass(total).value, known, 1e-6);
        EXPECT_NEAR(mass(total).of, known, 1e-6);
    }
}

// A mesh of one density is no measure for where the mass of two lies.
TEST(BodyCard, OfSeveralDensitiesTheCentreAndTheInertiaOfTheMeshAreNotKnown)
{
    const geometry::TriMesh box = geometry::box({1, 0.4, 0.2}, {1, 1, 1});
    const geometry::Cubes cubes = geometry::voxelize_solid(
        box, geometry::FaceMatter{{}, {geometry::Matter{}}, {}}, geometry::Inside::winding, 0,
        {0.1, {-0.5, -0.2, -0.1}, geometry::Vec3i::Zero()}, {});
    const auto known = [&](const geometry::Cubes& of) {
        std::string names;
        for (const auto& f : nodes::body_figures(&box, of, true, 1).all) {
            if (!std::isnan(f.of)) names += f.name.substr(0, f.name.find_first_of(" ,")) + " ";
        }
        return names;
    };
    EXPECT_EQ(known(cubes), "volume mass centre centre centre inertia inertia inertia stiffness ");
    geometry::Cubes two = cubes;
    for (std::size_t c = 0; c < two.count(); ++c) {
        if (two.cell[c].x() < 3) two.mass[c] *= 7;
    }
    EXPECT_EQ(known(two), "volume stiffness ");
}

// Two boxes of 1/16 m^3 that share half of it: 3/32 m^3 in cubes, 1/8 by their faces.
TEST(BodyCard, TheVolumeOfPartsThatOverlapIsNoMeasureForCubesThatHoldThemOnce)
{
    const geometry::TriMesh box = geometry::box({0.5, 0.5, 0.25}, {1, 1, 1});
    const auto told = [&](float apart, bool once) {
        geometry::TriMesh other = box;
        for (auto& p : other.positions) p.x() += apart;
        const std::array<const geometry::TriMesh*, 2> both{&box, &other};
        const geometry::TriMesh mesh = geometry::merge(both);
        const geometry::Cubes cubes = geometry::voxelize_solid(
            mesh, geometry::FaceMatter{{}, {geometry::Matter{}}, {}}, geometry::Inside::winding, 0,
            {0.125, {-0.25, -0.25, -0.125}, geometry::Vec3i::Zero()}, {});
        return nodes::body_figures(&mesh, cubes, true, 1, once);
    };
    const graph::Figures overlap = told(0.25f, true), apart = told(0.625f, true);
    EXPECT_NEAR(overlap.all[2].value, 0.09375, 1e-6);
    EXPECT_TRUE(std::isnan(overlap.all[2].of));
    EXPECT_EQ(overlap.all.back().name, graph::overlapping_parts);
    EXPECT_NEAR(apart.all[2].value, 0.125, 1e-6);
    EXPECT_NEAR(apart.all[2].of, 0.125, 1e-6);
    EXPECT_NE(apart.all.back().name, graph::overlapping_parts);
    // Bodies of their own hold it each.
    EXPECT_NEAR(told(0.25f, false).all[2].of, 0.125, 1e-6);
}

// Twelve boxes in a row, each 0.02 m into the next, and one piece that passes through itself: no
// middle of a cube lies in what two of them hold.
TEST(BodyCard, PartsThatOverlapByLessThanACubeAreSeen)
{
    const geometry::TriMesh box = geometry::box({0.12, 0.1, 0.1}, {1, 1, 1});
    std::vector<geometry::TriMesh> row(12, box);
    std::vector<const geometry::TriMesh*> all;
    for (std::size_t i = 0; i < row.size(); ++i) {
        for (auto& p : row[i].positions) p.x() += 0.1f * static_cast<float>(i);
        all.push_back(&row[i]);
    }
    const geometry::TriMesh boxes = geometry::merge(all);
    const auto overlaps = [](const geometry::TriMesh& mesh) {
        const geometry::Cubes cubes = geometry::voxelize_solid(
            mesh, geometry::FaceMatter{{}, {geometry::Matter{}}, {}}, geometry::Inside::winding, 0,
            {0.025, {-0.05, -0.05, -0.05}, geometry::Vec3i::Zero()}, {});
        EXPECT_GT(cubes.count(), 512u);
        return nodes::body_figures(&mesh, cubes, true, 1, true).all.back().name ==
               graph::overlapping_parts;
    };
    EXPECT_TRUE(overlaps(boxes));
    // One piece: all hang on the first corner of the first box.
    geometry::TriMesh one = boxes;
    auto topology = std::make_shared<geometry::MeshTopology>(*boxes.topology);
    const auto corners = static_cast<std::uint32_t>(box.positions.size());
    for (std::uint32_t i = 0; i + 1 < row.size(); ++i) {
        const std::uint32_t a = i * corners, b = (i + 1) * corners, c = b + 1;
        topology->triangles.push_back({a, b, c});
        topology->triangles.push_back({a, c, b});
    }
    topology->material.clear(), topology->group.clear(), topology->polygon.clear();
    topology->normal_triangles.clear(), topology->uv_triangles.clear();
    one.normals.clear();
    one.topology = topology;
    EXPECT_TRUE(overlaps(one));
}

// A box of 1 m^3 with one of 1/8 m^3 within, both wound outwards: a hollow by parity alone.
TEST(BodyCard, APartWithinAnotherIsAHollowByParity)
{
    const geometry::TriMesh outer = geometry::box({1, 1, 1}, {1, 1, 1}),
                            inner = geometry::box({0.5, 0.5, 0.5}, {1, 1, 1});
    const std::array<const geometry::TriMesh*, 2> both{&outer, &inner};
    const geometry::TriMesh mesh = geometry::merge(both);
    const geometry::Cubes cubes = geometry::voxelize_solid(
        mesh, geometry::FaceMatter{{}, {geometry::Matter{}}, {}}, geometry::Inside::parity, 0,
        {0.125, {-0.5, -0.5, -0.5}, geometry::Vec3i::Zero()}, {});
    const graph::Figures told = nodes::body_figures(&mesh, cubes, true, 1, true, 0, true);
    EXPECT_NEAR(told.all[2].value, 0.875, 1e-6);
    EXPECT_NEAR(told.all[2].of, 0.875, 1e-6);
    EXPECT_NE(told.all.back().name, graph::overlapping_parts);
}

// A box with a face listed twice, and one with every face so: the cubes are those of the box, and
// so is what they are compared with. A box of two sides without a lid encloses nothing.
TEST(BodyCard, ComparesWithTheFacesThatTheCubesAreMadeOf)
{
    const geometry::TriMesh box = geometry::box({0.5, 0.5, 0.5}, {1, 1, 1});
    const auto told = [&](std::size_t skipped, std::size_t doubled, bool turned) {
        geometry::TriMesh mesh = box;
        auto topology = std::make_shared<geometry::MeshTopology>(*box.topology);
        auto& triangles = topology->triangles;
        triangles.resize(triangles.size() - skipped);
        for (std::size_t t = 0; t < doubled; ++t) {
            triangles.push_back(triangles[t]);
            if (turned) std::swap(triangles.back()[0], triangles.back()[1]);
        }
        topology->material.clear(), topology->group.clear(), topology->polygon.clear();
        topology->normal_triangles.clear(), topology->uv_triangles.clear();
        mesh.normals.clear();
        mesh.topology = topology;
        const geometry::Cubes cubes = geometry::voxelize_solid(
            mesh, geometry::FaceMatter{{}, {geometry::Matter{}}, {}}, geometry::Inside::winding, 0,
            {0.125, {-0.25, -0.25, -0.25}, geometry::Vec3i::Zero()}, {});
        return nodes::body_figures(&mesh, cubes, true, 1, true).all[2];
    };
    for (const std::size_t doubled : {2u, 12u}) {
        EXPECT_NEAR(told(0, doubled, false).value, 0.125, 1e-6);
        EXPECT_NEAR(told(0, doubled, false).of, 0.125, 1e-6) << doubled;
    }
    EXPECT_NEAR(told(0, 12, true).of, 0.125, 1e-6);
    EXPECT_TRUE(std::isnan(told(2, 10, true).of));
}

}  // namespace
