// Material that varies from cube to cube, through a graph.

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

// Cantilever of E = E0 (1 + x / L), held at x = 0, a load P at x = L: with I = h^4 / 12,
//   w = P / (E0 I) integral of (L - x)^2 / (1 + x / L) = P L^3 / (E0 I) (4 ln 2 - 5 / 2)
// and by shear 2 P L ln 2 / (5/6 h^2 E0): 9.81 mm and 0.05 mm. A beam of E0 everywhere: 12 mm.
TEST(LocalMatter, AGradedBeamBendsByTheClosedForm)
{
    Scene scene(fine_beam + graded("young", "1e6 * (1 + x)") + R"(,
        "held": { "type": "Pin@1", "inputs": { "cubes": "graded.cubes" },
                  "params": { "where": "ends", "ends": { "end": "low", "layers": 0 } } },
        "load": { "type": "Force@1", "params": { "kind": "point", "point":
                  { "force": [0, -0.3, 0], "position": [1, 0, 0], "radius": 0 } } },
        "sim": { "type": "Simulate@1", "inputs": { "cubes": "graded.cubes", "pins": ["held.pins"],
                 "forces": ["load.force"] }, "params": { "gravity": [0, 0, 0],
                 "initial_shape": "equilibrium" } },
        "shape": { "type": "Embed@3", "inputs": { "mesh": "beam.mesh", "cubes": "graded.cubes",
                                                  "state": "sim.state" } },
        "tip": { "type": "Measure@1", "inputs": { "mesh": "shape.mesh", "rest": "beam.mesh" },
                 "params": { "what": "displacement_at", "point": [1, 0, 0],
                             "direction": [0, -1, 0] } })");
    const double inertia = 1e-4 / 12, ln2 = std::log(2.0);
    const double expected = 0.3 / (1e6 * inertia) * (4 * ln2 - 2.5) + 0.3 * 2 * ln2 / (5e4 / 6);
    EXPECT_NEAR(*scene.at<double>("tip"), expected, 0.03 * expected);
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
}

}  // namespace
