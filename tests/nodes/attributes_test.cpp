// Numbers of the user's own, from meshes through cubes to pictures and files.

#include "geometry/base/picture_file.hpp"
#include "render/cube_quantity.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <cmath>
#include <fmt/format.h>

namespace {

using fixtures::Scene;
using geometry::Cubes;
using geometry::TriMesh;

// A square of 1 m across y whose corners lie at the middles of four pixels.
const std::string square = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nvt 0.25 0.25\n"
                           "vt 0.75 0.25\nvt 0.75 0.75\nvt 0.25 0.75\nusemtl wood\n"
                           "f 1/1 3/3 2/2\nf 1/1 4/4 3/3\n";

// Two by two pixels, from the top: black, grey 51; white, grey 102.
std::string checker()
{
    return geometry::encode_png(
        {2, 2, {0, 0, 0, 255, 51, 51, 51, 255, 255, 255, 255, 255, 102, 102, 102, 255}});
}

std::string read(const std::string& path)
{
    return fmt::format(R"("read": {{ "type": "ReadMesh@1", "params": {{ "path": "{}" }} }})", path);
}

std::string attributes(const std::string& items, const std::string& more = "")
{
    return fmt::format(R"(, "made": {{ "type": "Attributes@1", "inputs": {{ "mesh": "read.mesh" }},
        "params": {{ "attributes": [{}]{} }} }})",
                       items, more);
}

std::vector<float> values(const TriMesh& mesh, const std::string& name)
{
    for (const geometry::Attribute& a : mesh.attributes) {
        if (a.name == name) return a.values;
    }
    ADD_FAILURE() << "no attribute " << name;
    return {};
}

TEST(Attributes, AreExpressionsOfPlaceColourAndThoseBeforeThem)
{
    const files::Folder folder;
    folder.write("c.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty "
                          "float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
                          "property uchar blue\nproperty float my-heat\nend_header\n"
                          "1 2 3 255 0 0 10\n4 5 6 0 255 0 20\n");
    Scene scene(read("c.ply") + attributes(R"(
        { "name": "a", "value": "x + 10 * y + 100 * z", "unit": "kg" },
        { "name": "c", "value": "a + 1000 * g + my_heat / 10" },
        { "name": "a", "value": "2 * a" })"),
                folder.path);
    const auto mesh = scene.at<TriMesh>("made");
    EXPECT_EQ(values(*mesh, "c"), (std::vector<float>{322, 1656}));
    EXPECT_EQ(values(*mesh, "a"), (std::vector<float>{642, 1308}));
    ASSERT_EQ(mesh->attributes.size(), 3u);
    EXPECT_EQ(mesh->attributes[0].name, "my-heat");
}

TEST(Attributes, SampleATextureAtTheCoordinatesOfEachVertex)
{
    const files::Folder folder;
    folder.write("s.obj", square);
    folder.write("m.mtl", "newmtl wood\nmap_Kd checker.png\n");
    folder.write("checker.png", checker());
    folder.write("red.png", geometry::encode_png({1, 1, {255, 0, 0, 128}}));
    // v runs up: the lower row is white and 102 / 255.
    Scene own(read("s.obj") + attributes(R"({ "name": "w", "value": "texture_r" })"), folder.path);
    const auto mesh = own.at<TriMesh>("made");
    const std::vector<float> weights = values(*mesh, "w");
    ASSERT_EQ(weights.size(), 4u);
    for (std::size_t v = 0; v < 4; ++v) {
        const bool right = mesh->positions[v].x() > 0.5f, up = mesh->positions[v].z() > 0.5f;
        EXPECT_EQ(weights[v], up ? (right ? 0.2f : 0.f) : (right ? 0.4f : 1.f));
    }
    Scene other(read("s.obj") + attributes(R"({ "name": "w", "value":
                    "texture_r + 10 * texture_g + 100 * texture_a" })",
                                           R"(, "texture": "red.png")"),
                folder.path);
    for (const float w : values(*other.at<TriMesh>("made"), "w")) {
        EXPECT_NEAR(w, 1 + 100 * 128.0 / 255, 1e-5);
    }
}

// 0 becomes 5, 0.5 becomes 6 and 1 becomes 2. 0.125 is a quarter of the first piece: there a smooth
// one is 3 / 4^2 - 2 / 4^3 = 5/32 of the way.
TEST(Attributes, GoThroughARamp)
{
    const files::Folder folder;
    folder.write("p.xyz", "-1 0 0\n0.125 0 0\n0.25 0 0\n0.75 0 0\n9 0 0\n");
    const auto ramped = [&](const std::string& shape) {
        Scene scene(read("p.xyz") + attributes(fmt::format(R"({{ "name": "w", "value": "x",
                        "ramp": {{ "shape": "{}", "points": [ {{ "at": 0, "value": 5 }},
                        {{ "at": 0.5, "value": 6 }}, {{ "at": 1, "value": 2 }} ] }} }})",
                                                           shape)),
                    folder.path);
        return values(*scene.at<TriMesh>("made"), "w");
    };
    EXPECT_EQ(ramped("linear"), (std::vector<float>{5, 5.25f, 5.5f, 4, 2}));
    EXPECT_EQ(ramped("smooth"), (std::vector<float>{5, 5 + 5 / 32.f, 5.5f, 4, 2}));
}

TEST(Attributes, TellWhatIsWrong)
{
    const files::Folder folder;
    folder.write("s.obj", square);
    folder.write("m.mtl", "newmtl wood\n");
    folder.write("p.xyz", "1 0 0 7\n2 0 0 8\n");
    folder.write("bad.png", "no picture");
    const auto told = [&](const std::string& file, const std::string& item,
                          const std::string& more = "") {
        return Scene(read(file) + attributes(item, more), folder.path).failure_at<TriMesh>("made");
    };
    const auto expect = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    expect(told("p.xyz", R"({ "name": "w", "value": "heat" })"),
           "attributes[0] w = \"heat\": unknown name 'heat'; available: x, y, z, column4");
    expect(told("p.xyz", R"({ "name": "w", "value": "texture_r" })"),
           "the mesh has none: unwrap it");
    expect(told("s.obj", R"({ "name": "w", "value": "texture_r" })"),
           "no material of the mesh has a texture: set the parameter 'texture'");
    expect(told("s.obj", R"({ "name": "w", "value": "texture_r" })", R"(, "texture": "bad.png")"),
           "bad.png is not a picture");
    expect(told("p.xyz", R"({ "name": "w", "value": "log(2 - x) / 1" })"),
           "expected a finite number, found -inf at vertex 1 at (2, 0, 0)");
    expect(told("p.xyz", R"({ "name": "x", "value": "1" })"), "means nothing else in expressions");
    expect(told("p.xyz", R"({ "name": "two words", "value": "1" })"), "found \"two words\"");
    expect(told("p.xyz", R"({ "name": "w", "value": "x", "ramp": { "points": [
                          { "at": 1, "value": 0 }, { "at": 0, "value": 1 } ] } })"),
           "ramp.points[1].at: expected at least 1");
}

// A square whose heat is 300 + 40 x at its corners, in cubes of 0.25 m.
std::string hot_square(const std::string& method)
{
    return R"(
        "sheet": { "type": "Primitive@1", "params": { "shape": "grid", "grid": { "size_x": 2,
                   "size_z": 2, "divisions_x": 4, "divisions_z": 4 } } },
        "hot": { "type": "Attributes@1", "inputs": { "mesh": "sheet.mesh" }, "params": {
                 "attributes": [ { "name": "heat", "unit": "K", "value": "300 + 40 * x" } ] } },
        "sampled": { "type": "Sample@2", "inputs": { "mesh": "hot.mesh" }, "params": {
                     "count": 20000, "attributes": "heat" } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "hot.mesh", "points":
                   ["sampled.points"] }, "params": { "size": 0.25, "method": ")" +
           method + R"(")" + (method == "surface" ? R"(, "attributes": "he*")" : "") + R"( } })";
}

TEST(Attributes, GoFromMeshToCubesToMeshesNumbersPicturesAndFiles)
{
    const files::Folder folder;
    Scene scene(hot_square("surface") + R"(,
        "cage": { "type": "CubeMesh@1", "inputs": { "cubes": "cubes.cubes" } },
        "least": { "type": "Measure@1", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "what": "attribute_min", "attribute": "heat" } },
        "most": { "type": "Measure@1", "inputs": { "mesh": "cage.mesh" },
                  "params": { "what": "attribute_max", "attribute": "heat" } },
        "mean": { "type": "Measure@1", "inputs": { "mesh": "cage.mesh" },
                  "params": { "what": "attribute_mean", "attribute": "heat" } },
        "cold": { "type": "Measure@1", "inputs": { "mesh": "cage.mesh" },
                  "params": { "what": "attribute_mean", "attribute": "cold" } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" } },
        "shape": { "type": "Embed@3", "inputs": { "mesh": "sheet.mesh", "cubes": "cubes.cubes",
                   "state": "sim.state" }, "params": { "attributes": { "cubes": "*" } } },
        "file": { "type": "WriteMesh@1", "inputs": { "mesh": "cage.mesh" },
                  "params": { "path": "cage.####.ply" } })",
                folder.path);
    // The outermost cubes lie 0.125 m from the edges: their means are 300 -+ 40 * 0.875.
    const auto cubes = scene.at<Cubes>("cubes");
    ASSERT_EQ(cubes->attributes.size(), 1u);
    EXPECT_NEAR(*scene.at<double>("least"), 265, 1e-4);
    EXPECT_NEAR(*scene.at<double>("most"), 335, 1e-4);
    EXPECT_NEAR(*scene.at<double>("mean"), 300, 1e-4);
    // A vertex in the middle of an edge between cubes has the mean of both: linear once more.
    const auto shape = scene.at<TriMesh>("shape");
    const std::vector<float> carried = values(*shape, "heat");
    ASSERT_EQ(carried.size(), 25u);
    EXPECT_NEAR(carried[12], 300, 1e-3);
    // All eight vertices of a drawn cube have its value.
    const render::CubeShell shell = render::cube_shell(*cubes);
    const auto drawn = render::cube_quantity("heat", *cubes, shell, nullptr);
    ASSERT_EQ(drawn.values.size(), 8 * 64u);
    EXPECT_EQ(drawn.unit, "K");
    EXPECT_FLOAT_EQ(drawn.values[15], float(cubes->attributes[0].values[shell.cube[1]]));
    EXPECT_NE(scene.failure_at<double>("cold").find(
                  "no attribute 'cold'; it has density, young, poisson, fill, heat"),
              std::string::npos)
        << scene.failure_at<double>("cold");
    scene.at<graph::WrittenFile>("file");
    EXPECT_NE(files::bytes_of(folder.path / "cage.0001.ply").find("property float heat\n"),
              std::string::npos);
}

// 312 samples a cube, one in each strip of equal area: the error of a mean is a few thousandths of
// the 10 K that a cube spans.
TEST(Attributes, OfSamplesBecomeThoseOfCubes)
{
    Scene scene(hot_square("samples"));
    const auto cubes = scene.at<Cubes>("cubes");
    ASSERT_EQ(cubes->count(), 64u);
    for (std::size_t c = 0; c < cubes->count(); ++c) {
        const double x = cubes->origin.x() + cubes->size * (cubes->cell[c].x() + 0.5);
        EXPECT_NEAR(cubes->attributes.at(0).values[c], 300 + 40 * x, 0.3);
    }
}

// Names that expressions cannot hold: a digit first, 70 and 120 letters, letters beyond ASCII, one
// that another becomes, and a function's. Those that can be used keep their names.
TEST(Attributes, OfAnyNameCanBeUsed)
{
    const std::string seventy(70, 'a'), more(120, 'a');
    const files::Folder folder;
    std::string header =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float "
        "y\nproperty float z\n";
    for (const std::string& name :
         {std::string("heat-flux"), std::string("heat_flux"), std::string("2d"), seventy, more,
          std::string("wärme"), std::string("sin")}) {
        header += "property float " + name + "\n";
    }
    folder.write("n.ply", header + "end_header\n0 0 0 1 2 4 8 16 32 64\n");
    const std::string same(48, 'a');
    Scene scene(read("n.ply") + attributes(R"({ "name": "w", "value": "heat_flux" },
        { "name": "all", "value": "heat_flux_ + heat_flux + _2d + )" +
                                           same + " + " + same + R"(_ + w__rme + sin_" })"),
                folder.path);
    const auto mesh = scene.at<TriMesh>("made");
    EXPECT_EQ(values(*mesh, "w"), std::vector<float>{2});
    EXPECT_EQ(values(*mesh, "all"), std::vector<float>{127});
}

TEST(Attributes, OfAnotherNameAreToldBeforeCubesAreMade)
{
    std::string nodes = hot_square("surface");
    nodes.replace(nodes.find("he*"), 3, "cold");
    EXPECT_NE(Scene(nodes).failure_at<Cubes>("cubes").find("no attribute 'cold'; it has heat"),
              std::string::npos);
}

}  // namespace
