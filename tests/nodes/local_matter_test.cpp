// Material that varies from cube to cube, through a graph.

#include "geometry/base/picture_file.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <cmath>
#include <fmt/format.h>

namespace {

using fixtures::Scene;
using geometry::Cubes;

const std::string fine_beam = R"(
    "beam": { "type": "Primitive@1", "params": { "shape": "beam", "centre": [0.5, 0, 0], "beam":
              { "length": 1, "height": 0.1, "width": 0.1, "divisions": 10 } } },
    "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "beam.mesh" }, "params": {
               "method": "solid", "size": 0.05, "matter": { "poisson": 0 } } })";

std::string graded(const std::string& property, const std::string& value)
{
    return fmt::format(R"(,
    "graded": {{ "type": "LocalMatter@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params": {{
                "properties": [{{ "property": "{}", "value": "{}" }}] }} }})",
                       property, value);
}

// What bends a beam of `graded`: held at x = 0, a load at x = 1 m, the sag there as `tip`.
const std::string loaded = R"(,
    "held": { "type": "Pin@1", "inputs": { "cubes": "graded.cubes" },
              "params": { "where": "ends", "ends": { "end": "low", "layers": 0 } } },
    "load": { "type": "Force@1", "params": { "kind": "point", "point":
              { "force": [0, -0.3, 0], "position": [1, 0, 0], "radius": 0 } } },
    "sim": { "type": "Simulate@3", "inputs": { "cubes": "graded.cubes", "pins": ["held.pins"],
             "forces": ["load.force"] }, "params": { "gravity": [0, 0, 0],
             "initial_shape": "equilibrium" } },
    "shape": { "type": "Embed@3", "inputs": { "mesh": "beam.mesh", "cubes": "graded.cubes",
                                              "state": "sim.state" } },
    "tip": { "type": "Measure@1", "inputs": { "mesh": "shape.mesh", "rest": "beam.mesh" },
             "params": { "what": "displacement_at", "point": [1, 0, 0],
                         "direction": [0, -1, 0] } })";

// Cantilever of E = E0 (1 + x / L), held at x = 0, a load P at x = L: with I = h^4 / 12,
//   w = P / (E0 I) integral of (L - x)^2 / (1 + x / L) = P L^3 / (E0 I) (4 ln 2 - 5 / 2)
// and by shear 2 P L ln 2 / (5/6 h^2 E0): 9.81 mm and 0.05 mm. A beam of E0 everywhere: 12 mm.
TEST(LocalMatter, AGradedBeamBendsByTheClosedForm)
{
    Scene scene(fine_beam + graded("young", "1e6 * (1 + x)") + loaded);
    const double inertia = 1e-4 / 12, ln2 = std::log(2.0);
    const double expected = 0.3 / (1e6 * inertia) * (4 * ln2 - 2.5) + 0.3 * 2 * ln2 / (5e4 / 6);
    EXPECT_NEAR(*scene.at<double>("tip"), expected, 0.03 * expected);
}

// The same beam, its stiffness painted on its side: greys 0, 17, 34 .. 255 from x = 0 to 1 m, that
// a ramp makes 1 to 2 MPa of. Coordinates run from the middle of the first pixel to that of the
// last, between which a texture is linear: the stiffness is that of the expression.
TEST(LocalMatter, AGradedBeamMayBePaintedByATexture)
{
    const files::Folder folder;
    geometry::Picture greys{16, 1, {}};
    for (int i = 0; i < 16; ++i) {
        const auto grey = static_cast<std::uint8_t>(17 * i);
        greys.rgba.insert(greys.rgba.end(), {grey, 0, 0, 255});
    }
    folder.write("greys.png", geometry::encode_png(greys));
    folder.write("side.obj", "v 0 -1 0\nv 1 -1 0\nv 1 1 0\nv 0 1 0\nvt 0.03125 0\nvt 0.96875 0\n"
                             "f 1/1 2/2 3/2 4/1\n");
    Scene scene(fine_beam + R"(,
        "side": { "type": "ReadMesh@1", "params": { "path": "side.obj" } },
        "graded": { "type": "LocalMatter@1", "inputs": { "cubes": "cubes.cubes",
                    "mesh": "side.mesh" }, "params": { "texture": "greys.png", "properties": [
                    { "property": "young", "value": "texture_r", "ramp": { "points":
                      [ { "at": 0, "value": 1e6 }, { "at": 1, "value": 2e6 } ] } } ] } })" +
                    loaded,
                folder.path);
    const double inertia = 1e-4 / 12, ln2 = std::log(2.0);
    const double expected = 0.3 / (1e6 * inertia) * (4 * ln2 - 2.5) + 0.3 * 2 * ln2 / (5e4 / 6);
    EXPECT_NEAR(*scene.at<double>("tip"), expected, 0.01 * expected);
}

// The mean of a + b x over a cube is its value in the middle. A second expression knows the first,
// and what the cubes are made of.
TEST(LocalMatter, PropertiesOfTheUsersOwnAreMeansOverCubes)
{
    Scene scene(fine_beam + R"(,
        "graded": { "type": "LocalMatter@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                    "properties": [
                    { "property": "own", "name": "age", "unit": "s", "value": "3 + 7 * x - 2 * z" },
                    { "property": "own", "name": "worn", "value": "age * young / 1e6" },
                    { "property": "young", "value": "young + young * worn" } ] } },
        "again": { "type": "LocalMatter@1", "inputs": { "cubes": "graded.cubes" }, "params": {
                   "properties": [ { "property": "own", "name": "age", "value": "-age" } ] } })");
    const auto cubes = scene.at<Cubes>("graded"), again = scene.at<Cubes>("again");
    ASSERT_EQ(cubes->attributes.size(), 2u);
    ASSERT_EQ(again->attributes.size(), 2u);
    EXPECT_EQ(cubes->attributes[0].unit, "s");
    for (std::size_t c = 0; c < cubes->count(); ++c) {
        const geometry::Vec3 p = cubes->origin + cubes->size * (cubes->cell[c].cast<double>() +
                                                                geometry::Vec3::Constant(0.5));
        const double age = 3 + 7 * p.x() - 2 * p.z();
        EXPECT_NEAR(cubes->attributes[0].values[c], age, 1e-9);
        EXPECT_NEAR(cubes->attributes[1].values[c], age, 1e-9);
        EXPECT_NEAR(cubes->young[c], 1e6 * (1 + age), 1e-3);
        EXPECT_NEAR(again->attributes[0].values[c], -age, 1e-9);
    }
}

// Thicknesses of 0.01 m + 0.01 x over 1 m by 0.2 m: volume 0.003 m^3 of 1000 kg/m^3. Where y is not
// 0, expressions would be of places beside the sheet.
TEST(LocalMatter, APlaneHasThicknessAndPropertiesOfItsOwn)
{
    Scene scene(R"(
        "plane": { "type": "Plane@1", "params": { "sides": { "u": 1, "v": 0.2 }, "size": 0.1,
                   "centre": [0.5, 0, 0], "thickness": 0.02 } },
        "local": { "type": "LocalMatter@1", "inputs": { "cubes": "plane.cubes" }, "params": {
                   "properties": [ { "property": "thickness", "value": "0.01 + 0.01 * x + y" },
                                   { "property": "own", "name": "w", "value": "x + 5 * y" } ] } },
        "mass": { "type": "Measure@1", "inputs": { "cubes": "local.cubes" },
                  "params": { "what": "mass" } })");
    EXPECT_NEAR(*scene.at<double>("mass"), 3, 1e-9);
    const auto cubes = scene.at<Cubes>("local");
    for (std::size_t c = 0; c < cubes->count(); ++c) {
        const double x = cubes->origin.x() + cubes->size * (cubes->cell[c].x() + 0.5);
        EXPECT_NEAR(cubes->fill[c], 0.1 * (1 + x), 1e-12);
        EXPECT_NEAR(cubes->attributes.at(0).values[c], x, 1e-12);
    }
}

// A hem twice as thick as the rest, whatever that is: 0.02 m, and 0.04 m where x > 0.5 m.
TEST(LocalMatter, ReadsTheThicknessOfPlanesAndSheets)
{
    const std::string doubled = R"(,
        "local": { "type": "LocalMatter@1", "inputs": { "cubes": "cloth.cubes" }, "params": {
                   "properties": [ { "property": "thickness",
                                     "value": "x > 0.5 ? 2 * thickness : thickness" } ] } },
        "mass": { "type": "Measure@1", "inputs": { "cubes": "local.cubes" },
                  "params": { "what": "mass" } },
        "thickest": { "type": "Measure@1", "inputs": { "cubes": "local.cubes" },
                      "params": { "what": "attribute_max", "attribute": "thickness" } })";
    const std::string plane = R"(
        "cloth": { "type": "Plane@1", "params": { "sides": { "u": 1, "v": 0.2 }, "size": 0.1,
                   "centre": [0.5, 0, 0], "thickness": 0.02 } })";
    const std::string sheet = R"(
        "grid": { "type": "Primitive@1", "params": { "shape": "grid", "centre": [0.5, 0, 0],
                  "grid": { "size_x": 1, "size_z": 0.2, "divisions_x": 10, "divisions_z": 2 } } },
        "cloth": { "type": "Sheet@1", "inputs": { "mesh": "grid.mesh" },
                   "params": { "thickness": 0.02 } })";
    for (const std::string& cloth : {plane, sheet}) {
        Scene scene(cloth + doubled);
        EXPECT_NEAR(*scene.at<double>("mass"), 1000 * 0.2 * 0.5 * (0.02 + 0.04), 1e-6);
        EXPECT_NEAR(*scene.at<double>("thickest"), 0.04, 1e-12);
    }
}

// The left half of the square is of one material, the right half of another: cubes there keep
// theirs.
TEST(LocalMatter, AppliesToPartsOfTheMesh)
{
    const files::Folder folder;
    folder.write("m.mtl", "newmtl hem\nnewmtl cloth\n");
    folder.write("p.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 0 1\nv 1 0 1\nv 2 0 1\n"
                          "usemtl hem\nf 1 4 5 2\nusemtl cloth\nf 2 5 6 3\n");
    Scene scene(R"(
        "read": { "type": "ReadMesh@1", "params": { "path": "p.obj" } },
        "plane": { "type": "Plane@1", "inputs": { "mesh": "read.mesh" }, "params": {
                   "outline": "mesh", "size": 0.25, "matter": { "young": 5e5 } } },
        "local": { "type": "LocalMatter@1", "inputs": { "cubes": "plane.cubes", "mesh":
                   "read.mesh" }, "params": { "properties": [
                   { "property": "young", "value": "1e6 + 1e6 * x", "part": "he*" },
                   { "property": "own", "name": "hem", "value": "1", "part": "hem" } ] } },
        "lost": { "type": "LocalMatter@1", "inputs": { "cubes": "plane.cubes" }, "params": {
                  "properties": [ { "value": "1", "part": "hem" } ] } })",
                folder.path);
    const auto cubes = scene.at<Cubes>("local");
    ASSERT_EQ(cubes->count(), 32u);
    for (std::size_t c = 0; c < cubes->count(); ++c) {
        const double x = cubes->origin.x() + cubes->size * (cubes->cell[c].x() + 0.5);
        EXPECT_NEAR(cubes->young[c], x < 1 ? 1e6 * (1 + x) : 5e5, 1e-3);
        EXPECT_EQ(cubes->attributes.at(0).values[c], x < 1 ? 1 : 0);
    }
    EXPECT_NE(scene.failure_at<Cubes>("lost").find("link it to the input 'mesh'"),
              std::string::npos);
}

// Density 1000 + 6000 x^2 over 0 < x < 1 m: the mean is 3000 kg/m^3, exact by Gauss points.
TEST(LocalMatter, MassFollowsTheMeanDensityOfEachCube)
{
    Scene scene(fine_beam + graded("density", "1000 + 6000 * x^2") + R"(,
        "mass": { "type": "Measure@1", "inputs": { "cubes": "graded.cubes" },
                  "params": { "what": "mass" } },
        "cage": { "type": "CubeMesh@1", "inputs": { "cubes": "graded.cubes" } })");
    EXPECT_NEAR(*scene.at<double>("mass"), 30, 1e-5);
    // The corners at x = 0 have only cubes from 0 to 0.05 m: 1000 + 2000 * 0.05^2.
    const auto cage = scene.at<geometry::TriMesh>("cage");
    EXPECT_NEAR(cage->attributes.at(0).values.at(0), 1005.f, 0.01f);
}

TEST(LocalMatter, VertexColoursPaintTheMaterial)
{
    // Red grows from 0 at x = 0 to 1 at x = 1, as OBJ vertex colours, in linear light.
    const files::Folder folder;
    folder.write("p.obj", "v 0 0 0 0 0 0\nv 1 0 0 1 0 0\nv 1 0 1 1 0 0\nv 0 0 1 0 0 0\n"
                          "f 1 3 2\nf 1 4 3\n");
    Scene scene(R"(
        "read": { "type": "ReadMesh@1", "params": { "path": "p.obj", "colours": "linear" } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "read.mesh" },
                   "params": { "method": "surface", "size": 0.1 } },
        "painted": { "type": "LocalMatter@1", "inputs": { "cubes": "cubes.cubes",
                     "mesh": "read.mesh" }, "params": { "properties": [
                     { "property": "young", "value": "1000 + 9000 * r" }] } })",
                folder.path);
    const auto cubes = scene.at<Cubes>("painted");
    for (std::size_t c = 0; c < cubes->count(); ++c) {
        const double x = cubes->origin.x() + cubes->size * (cubes->cell[c].x() + 0.5);
        if (x < 0.06 || x > 0.94) continue;
        EXPECT_NEAR(cubes->young[c], 1000 + 9000 * x, 0.01) << c;
    }
}

// Attributes of a mesh: young of the cage at each corner is linear, 1000 + 9000 x, but at the ends.
TEST(LocalMatter, VertexAttributesPaintTheMaterial)
{
    Scene scene(fine_beam + graded("young", "1000 + 9000 * x") + R"(,
        "cage": { "type": "CubeMesh@1", "inputs": { "cubes": "graded.cubes" } },
        "coarse": { "type": "Voxelize@1", "inputs": { "mesh": "beam.mesh" },
                    "params": { "method": "solid", "size": 0.1 } },
        "painted": { "type": "LocalMatter@1", "inputs": { "cubes": "coarse.cubes",
                     "mesh": "cage.mesh" }, "params": { "properties": [
                     { "property": "density", "value": "2 * young" }] } })");
    const auto cubes = scene.at<Cubes>("painted");
    ASSERT_EQ(cubes->count(), 10u);
    for (std::size_t c = 1; c < 9; ++c) {
        const double x = cubes->origin.x() + cubes->size * (cubes->cell[c].x() + 0.5);
        EXPECT_NEAR(cubes->mass[c], 2 * (1000 + 9000 * x) * 1e-3, 1e-4) << c;
    }
}

TEST(LocalMatter, WrongExpressionsAreTold)
{
    const auto told = [](const std::string& property, const std::string& value) {
        return Scene(fine_beam + graded(property, value)).failure_at<Cubes>("graded");
    };
    EXPECT_NE(told("young", "1 + r").find("unknown name 'r'; available: x, y, z"),
              std::string::npos)
        << told("young", "1 + r");
    EXPECT_NE(told("density", "-x").find("expected a value above 0, found -0.025"),
              std::string::npos)
        << told("density", "-x");
    EXPECT_NE(told("poisson", "0.4 + x").find("to below 0.5"), std::string::npos);
    EXPECT_FALSE(told("young", "1 +").empty());
    EXPECT_NE(told("own", "1 / 0").find("expected a finite number, found inf in the cube at"),
              std::string::npos)
        << told("own", "1 / 0");
    EXPECT_NE(told("thickness", "1").find("only a Plane or a Sheet has a thickness"),
              std::string::npos);
    EXPECT_NE(told("young", "texture_r").find("a texture lies on a mesh"), std::string::npos);
    const auto named = [](const std::string& name) {
        return Scene(fine_beam + R"(, "own": { "type": "LocalMatter@1", "inputs": { "cubes":
                     "cubes.cubes" }, "params": { "properties": [ { "property": "own", "name": ")" +
                     name + R"(" } ] } })")
            .failure_at<Cubes>("own");
    };
    EXPECT_NE(named("young").find("all cubes have 'young'"), std::string::npos) << named("young");
    EXPECT_NE(named("stress").find("choose another name"), std::string::npos);
    EXPECT_NE(named("x").find("means nothing else in expressions"), std::string::npos);
}

}  // namespace
