#include "geometry/io/read_mesh.hpp"

#include "geometry/base/srgb.hpp"
#include "geometry/io/assemble_mesh.hpp"
#include "geometry/mesh/unstated_material.hpp"
#include "tests/geometry/files.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

namespace {

using namespace geometry;

std::string read_error(const files::fs::path& path)
{
    try {
        read_mesh(path);
        return "";
    } catch (const std::runtime_error& error) {
        return error.what();
    }
}

// Two triangles that make a unit square in the plane z = 0, unwelded, as importers give it.
ImportedScene square()
{
    ImportedScene scene;
    ImportedMesh mesh;
    mesh.name = "square";
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {-0.f, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    scene.meshes = {mesh};
    scene.materials = {{"paint", {0.5f, 0.5f, 0.5f}}};
    scene.nodes = {{"node", 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}};
    return scene;
}

TEST(ReadMesh, WeldsByPositionAndKeepsNegativeZeroTheSame)
{
    ImportedScene scene = square();
    scene.meshes[0].positions[3] = {-0.f, 0, -0.f};
    const TriMesh mesh = assemble_mesh(scene).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.triangles().size(), 2u);
    EXPECT_NEAR(surface_area(mesh), 1, 1e-6);
    EXPECT_EQ(mesh.topology->groups, std::vector<std::string>{"node"});
    EXPECT_EQ(mesh.topology->materials.at(0).name, "paint");
}

TEST(ReadMesh, WeldsGroupsByThemselvesWhenAsked)
{
    // Three squares in a row: the second and the third are of one group.
    ImportedScene scene = square();
    scene.nodes.push_back({"other", 0, {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0}});
    scene.nodes.push_back({"other", 0, {1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, 0}});
    EXPECT_EQ(assemble_mesh(scene).mesh.positions.size(), 8u);
    ReadOptions options;
    options.weld = Weld::groups;
    const TriMesh mesh = assemble_mesh(scene, options).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.positions.size(), 10u);
    EXPECT_EQ(mesh.triangles().size(), 6u);
    EXPECT_EQ(mesh.topology->groups, (std::vector<std::string>{"node", "other"}));
    EXPECT_EQ(mesh.topology->group, (std::vector<std::uint16_t>{0, 0, 1, 1, 1, 1}));
}

TEST(ReadMesh, NormalsBelongToOneVertexAndMissingOnesAreComputed)
{
    ImportedScene scene = square();
    // Not unit, one not a number, one zero: the flat square's own normal takes their place.
    scene.meshes[0].normals = {{0, 0, 3}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {NAN, 0, 0}, {0, 0, 0}};
    const TriMesh mesh = assemble_mesh(scene).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_GT(meshes::worst_normal(mesh), 1 - 1e-6);
}

TEST(ReadMesh, APlacedInstanceHasItsNodesTransform)
{
    ImportedScene scene = square();
    // Twice: as it is, and scaled by 2 along x, turned 90 degrees about z and moved.
    scene.nodes.push_back({"turned", 0, {0, -1, 0, 10, 2, 0, 0, 0, 0, 0, 1, 5}});
    const TriMesh mesh = assemble_mesh(scene).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.positions.size(), 8u);
    EXPECT_EQ(bounds(mesh).hi, Vec3(10, 2, 5));
    EXPECT_NEAR(surface_area(mesh), 3, 1e-6);
    EXPECT_EQ(mesh.topology->groups, (std::vector<std::string>{"node", "turned"}));
    EXPECT_EQ(mesh.topology->group, (std::vector<std::uint16_t>{0, 0, 1, 1}));
}

TEST(ReadMesh, AMirroredInstanceStillFacesOutwards)
{
    ImportedScene scene;
    ImportedMesh mesh;
    const TriMesh ball = icosphere(1, 2);
    mesh.positions = ball.positions;
    mesh.normals = ball.normals;
    mesh.triangles = ball.triangles();
    scene.meshes = {mesh};
    scene.nodes = {{"left", 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                   {"right", 0, {-2, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0}}};
    const TriMesh both = assemble_mesh(scene).mesh;
    meshes::expect_consistent(both);
    // A copy twice as long: three volumes in all, each counted positive.
    EXPECT_NEAR(enclosed_volume(both), 3 * enclosed_volume(ball), 1e-5);
    EXPECT_GT(meshes::worst_normal(both), 0.7);
}

TEST(ReadMesh, UnitsAndAxesConvert)
{
    ImportedScene scene = square();  // corner (1, 1, 0)
    const auto corner = [&](const ReadOptions& options) {
        return bounds(assemble_mesh(scene, options).mesh);
    };
    ReadOptions options;
    options.unit = LengthUnit::inch;
    EXPECT_NEAR(corner(options).hi.x(), 0.0254, 1e-9);
    options.unit = LengthUnit::custom;
    options.custom_unit = 3;
    EXPECT_NEAR(corner(options).hi.x(), 3, 1e-6);
    options = {};
    options.up = UpAxis::z;  // (x, y, z) -> (x, z, -y)
    EXPECT_EQ(corner(options).lo, Vec3(0, 0, -1));
    options.up = UpAxis::x;  // (x, y, z) -> (-y, x, z)
    EXPECT_EQ(corner(options).lo, Vec3(-1, 0, 0));
    options = {};
    scene.unit = 0.01;  // the file says centimetres, and z up
    scene.has_axes = true;
    scene.to_y_up = {1, 0, 0, 0, 0, 1, 0, -1, 0};
    EXPECT_NEAR(corner(options).lo.z(), -0.01, 1e-9);
    options.unit = LengthUnit::metre;  // the user knows better
    EXPECT_NEAR(corner(options).lo.z(), -1, 1e-9);
}

TEST(ReadMesh, FitsCentresAndGrounds)
{
    ReadOptions options;
    options.fit = 4;
    options.place = Placement::centre;
    Box box = bounds(assemble_mesh(square(), options).mesh);
    EXPECT_LT((box.lo - Vec3(-2, -2, 0)).norm(), 1e-6);
    options.place = Placement::ground;
    box = bounds(assemble_mesh(square(), options).mesh);
    EXPECT_LT((box.lo - Vec3(-2, 0, 0)).norm(), 1e-6);
    EXPECT_LT((box.hi - Vec3(2, 4, 0)).norm(), 1e-6);
}

TEST(ReadMesh, FacesThatCannotBeUsedAreLeftOutAndCounted)
{
    ImportedScene scene = square();
    ImportedMesh& mesh = scene.meshes[0];
    mesh.positions.push_back({NAN, 0, 0});
    mesh.positions.push_back({0, INFINITY, 0});
    mesh.triangles.insert(mesh.triangles.end(),
                          {{0, 1, 6}, {0, 7, 2}, {0, 1, 99}, {0, 0, 1}, {0, 3, 1}});
    mesh.lines = 2;
    mesh.points = {1};
    const ReadMesh read = assemble_mesh(scene);
    meshes::expect_consistent(read.mesh);
    EXPECT_EQ(read.mesh.triangles().size(), 2u);
    EXPECT_EQ(read.mesh.positions.size(), 4u);
    std::string all;
    for (const auto& w : read.warnings) all += w + "\n";
    EXPECT_EQ(all,
              "left out 1 face that names a vertex which is not in the file.\n"
              "left out 2 faces or points whose positions are not finite numbers.\n"
              "left out 2 faces that have one vertex twice.\n"
              "left out 2 lines, which the output 'lines' has: set line_thickness to make tubes of "
              "them.\n"
              "left out 1 loose point beside the faces.\n");
}

TEST(ReadMesh, NothingUsableIsAnErrorThatSaysWhy)
{
    ImportedScene scene = square();
    for (auto& p : scene.meshes[0].positions) p.x() = NAN;
    try {
        assemble_mesh(scene);
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("left out 2 faces"), std::string::npos);
    }
    EXPECT_THROW(assemble_mesh(ImportedScene{}), std::runtime_error);
    scene = square();
    scene.nodes.clear();
    EXPECT_THROW(assemble_mesh(scene), std::runtime_error);
    scene = square();
    scene.nodes[0].mesh = 5;
    EXPECT_THROW(assemble_mesh(scene), std::runtime_error);
    scene = square();
    scene.nodes[0].to_world.fill(NAN);
    EXPECT_THROW(assemble_mesh(scene), std::runtime_error);
}

TEST(ReadMesh, GroupsAfterNumber65535ShareThatOneWithAWarning)
{
    ImportedScene scene = square();
    scene.nodes.clear();
    ReadOptions options;
    options.normals = FileNormals::none;
    for (int i = 0; i < 65'540; ++i) {
        scene.nodes.push_back({std::to_string(i), 0, {1, 0, 0, double(i), 0, 1, 0, 0, 0, 0, 1, 0}});
        if (i != 65'535) continue;
        EXPECT_EQ(assemble_mesh(scene, options).warnings, std::vector<std::string>{});
    }
    const ReadMesh read = assemble_mesh(scene, options);
    EXPECT_EQ(read.mesh.topology->groups.size(), 65'536u);
    EXPECT_EQ(read.mesh.topology->group.back(), 65'535);
    EXPECT_EQ(read.warnings,
              std::vector<std::string>{"the file has 65540 groups: those after the first 65,535 "
                                       "are one. Join some, or split the file."});
}

TEST(ReadMesh, PointsAloneAreAPointCloudWithColours)
{
    ImportedScene scene = square();
    scene.meshes[0].triangles.clear();
    scene.meshes[0].colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {0, 0, 0}, {1, 1, 0}};
    const TriMesh mesh = assemble_mesh(scene).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.colours[1], Vec3f(0, 1, 0));
    EXPECT_TRUE(mesh.triangles().empty());
}

// ---- files ------------------------------------------------------------------------------------

const char* const cube_obj = R"(mtllib cube.mtl
o Cube
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
v -1 1 -1
v -1 -1 1
v 1 -1 1
v 1 1 1
v -1 1 1
usemtl skin
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
usemtl glass
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
)";
const char* const cube_mtl = "newmtl skin\nKd 0.5 0.25 1\nPr 0.25\nPm 1\n"
                             "newmtl glass\nKd 0 0 0\nd 0.25\nNs 30\n";

TEST(ReadMesh, AnObjWithItsMaterials)
{
    const files::Folder folder;
    folder.write("cube.mtl", cube_mtl);
    const ReadMesh read = read_mesh(folder.write("cube.obj", cube_obj));
    meshes::expect_consistent(read.mesh);
    EXPECT_TRUE(meshes::closed(read.mesh));
    EXPECT_NEAR(enclosed_volume(read.mesh), 8, 1e-6);
    EXPECT_EQ(read.warnings.size(), 0u);
    EXPECT_EQ(read.mesh.topology->groups, std::vector<std::string>{"Cube"});
    EXPECT_EQ(read.mesh.normals.size(), 24u);  // 90 degrees are a crease

    const auto& materials = read.mesh.topology->materials;
    ASSERT_EQ(materials.size(), 2u);
    EXPECT_EQ(materials[0].name, "skin");
    // sRGB 0.5 is 0.21404 linear (IEC 61966-2-1), 0.25 is 0.05088.
    EXPECT_LT((materials[0].colour - Vec3f(0.21404f, 0.05088f, 1)).norm(), 1e-4);
    EXPECT_FLOAT_EQ(materials[0].roughness, 0.25f);
    EXPECT_FLOAT_EQ(materials[0].metallic, 1);
    EXPECT_FLOAT_EQ(materials[1].opacity, 0.25f);
    // Exponent 30: width alpha = sqrt(2 / 32) = 1/4, roughness its square root.
    EXPECT_NEAR(materials[1].roughness, 0.5, 1e-6);
    ASSERT_EQ(read.side_files.size(), 1u);
    EXPECT_EQ(read.side_files[0], folder.path / "cube.mtl");
}

// A tetrahedron with normals and texture coordinates, and a vertex that no face has, written with
// `half` for 0.5.
std::string halves(const std::string& half)
{
    const std::string h = ' ' + half;
    return "mtllib ./none.mtl\no part.5 .5\n# v .5 of old\n\nv" + h + " 0 0\nv 1\t" + half +
           " 0\r\nv 0 \\\n" + half + " 1\nv" + h + h + h + "\n v 9 9 9\n" +  //
           "vt" + h + h + "\nvt 1" + h + "\nvt 0 0\n" +                      //
           "vn" + h + " 0 1\nvn 0 1 0\n" +
           "f 1/1/1 2/2/1 3/3/1\nf 1/1/2 2/2/2 4/3/2\nf 2/1/1 3/2/1 4/3/1\n"
           "f 1/1/2 3/2/2 4/3/2";
}

TEST(ReadMesh, NumbersOfAnObjMayBeginWithTheirPoint)
{
    const files::Folder folder;
    const TriMesh plain = read_mesh(folder.write("a.obj", halves("0.5"))).mesh;
    ASSERT_EQ(plain.positions.size(), 4u);
    for (const char* half : {".5", "+.5", ".5000", ".05e1", ".05E+01", "5.e-1", "\t.5"}) {
        const TriMesh mesh = read_mesh(folder.write("b.obj", halves(half))).mesh;
        EXPECT_EQ(mesh.positions, plain.positions) << half;
        EXPECT_EQ(mesh.normals, plain.normals) << half;
        EXPECT_EQ(mesh.topology->uvs, plain.topology->uvs) << half;
        EXPECT_EQ(mesh.triangles(), plain.triangles()) << half;
        EXPECT_EQ(mesh.topology->groups, plain.topology->groups) << half;
    }
    const TriMesh below = read_mesh(folder.write("a.obj", halves("-0.5"))).mesh;
    EXPECT_EQ(read_mesh(folder.write("b.obj", halves("-.5"))).mesh.positions, below.positions);
}

TEST(ReadMesh, AMissingMaterialLibraryIsAWarningAndNamesStay)
{
    const files::Folder folder;
    const ReadMesh read = read_mesh(folder.write("cube.obj", cube_obj));
    ASSERT_EQ(read.mesh.topology->materials.size(), 2u);
    EXPECT_EQ(read.mesh.topology->materials[1].name, "glass");
    // Once, though the importer looks in several places and for other names.
    ASSERT_EQ(read.warnings.size(), 1u);
    EXPECT_NE(read.warnings[0].find("cube.mtl"), std::string::npos);
    ASSERT_FALSE(read.side_files.empty());

    const ReadMesh other = read_mesh(folder.write("other.obj", cube_obj));
    ASSERT_EQ(other.warnings.size(), 1u);
    EXPECT_NE(other.warnings[0].find("cube.mtl"), std::string::npos);

    // The importer asks for the library without its ending, and in other folders, too.
    const ReadMesh below = read_mesh(folder.write("bad/mtl.obj", cube_obj));
    ASSERT_EQ(below.warnings.size(), 1u) << below.warnings.back();

    // Or for letters out of the middle of its path: "b/mats.mt" of /tmp/.../b/mats.mtl.
    const std::string text = "mtllib mats.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const ReadMesh cut = read_mesh(folder.write("b/chair.obj", text));
    ASSERT_EQ(cut.warnings.size(), 1u) << cut.warnings.back();
    EXPECT_EQ(cut.warnings[0].rfind("the file refers to mats.mtl, which cannot", 0), 0u)
        << cut.warnings[0] << " and the folder of the file does not matter";
}

TEST(ReadMesh, ConcavePolygonsAreCutRightly)
{
    // An L of area 3, its notch at vertex 4.
    const files::Folder folder;
    const ReadMesh read = read_mesh(folder.write(
        "l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n"));
    EXPECT_EQ(read.mesh.triangles().size(), 4u);
    EXPECT_NEAR(surface_area(read.mesh), 3, 1e-6);
}

TEST(ReadMesh, LinesAreLeftOutAndPointsAccepted)
{
    const files::Folder folder;
    const ReadMesh lines =
        read_mesh(folder.write("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\nl 2 3\n"));
    EXPECT_EQ(lines.mesh.triangles().size(), 1u);
    EXPECT_FALSE(lines.warnings.empty());
    const ReadMesh cloud = read_mesh(folder.write("cloud.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"));
    EXPECT_EQ(cloud.mesh.positions.size(), 3u);
    const ReadMesh ply = read_mesh(
        folder.write("cloud.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                                  "property float y\nproperty float z\nproperty uchar red\n"
                                  "property uchar green\nproperty uchar blue\nend_header\n"
                                  "0 0 0 255 0 0\n1 2 3 0 0 128\n"));
    ASSERT_EQ(ply.mesh.positions.size(), 2u);
    EXPECT_EQ(ply.mesh.positions[1], Vec3f(1, 2, 3));
    ASSERT_EQ(ply.mesh.colours.size(), 2u);
    EXPECT_LT((ply.mesh.colours[1] - Vec3f(0, 0, 0.2158605f)).norm(), 1e-4);  // sRGB 128
}

TEST(ReadMesh, AttributesOfAPlyAndColumnsOfTextAreKept)
{
    const files::Folder folder;
    // Vertices 0 and 3 lie in one place: they are one, with the values of the first. Vertex 4 is in
    // no face.
    const ReadMesh ply = read_mesh(folder.write(
        "a.ply", "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                 "property float z\nproperty float heat\nproperty uchar age\nelement face 2\n"
                 "property list uchar int vertex_indices\nend_header\n0 0 0 1 10\n1 0 0 2 20\n"
                 "0 1 0 nan 30\n0 0 0 4 40\n5 5 5 9 90\n3 0 1 2\n3 3 2 1\n"));
    ASSERT_EQ(ply.mesh.attributes.size(), 2u);
    EXPECT_EQ(ply.mesh.attributes[0].values, (std::vector<float>{1, 2, 0}));
    EXPECT_EQ(ply.mesh.attributes[1].values, (std::vector<float>{10, 20, 30}));
    ASSERT_EQ(ply.warnings.size(), 1u);
    EXPECT_NE(ply.warnings[0].find("1 value of an attribute that is not a finite number: 0 stands"),
              std::string::npos)
        << ply.warnings[0];

    const ReadMesh scan =
        read_mesh(folder.write("a.pts", "2\n0 0 0 -1200 255 0 0\n1 2 3 800.5 0 0 128\n"));
    ASSERT_EQ(scan.mesh.attributes.size(), 1u);
    EXPECT_EQ(scan.mesh.attributes[0].name, "column4");
    EXPECT_EQ(scan.mesh.attributes[0].values, (std::vector<float>{-1200, 800.5f}));
    EXPECT_EQ(scan.mesh.colours.size(), 2u);

    const ReadMesh named =
        read_mesh(folder.write("b.xyz", "x y z heat age\n0 0 0 1.5 7\n1 0 0 2.5 8\n"));
    ASSERT_EQ(named.mesh.attributes.size(), 2u);
    EXPECT_EQ(named.mesh.attributes[0].name, "heat");
    EXPECT_EQ(named.mesh.attributes[1].name, "age");
    EXPECT_EQ(named.mesh.attributes[1].values, (std::vector<float>{7, 8}));
    // Lines of different lengths say nothing.
    EXPECT_TRUE(read_mesh(folder.write("c.xyz", "0 0 0 1\n1 0 0\n")).mesh.attributes.empty());
}

// So that they are drawn in these, see unstated_material.hpp.
TEST(ReadMesh, AFileWithVertexColoursAndNoMaterialStatesNone)
{
    const files::Folder folder;
    const auto ply = folder.write(
        "t.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                 "property float z\nproperty uchar red\nproperty uchar green\n"
                 "property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n"
                 "end_header\n0 0 0 220 20 20\n1 0 0 220 20 20\n0 1 0 220 20 20\n3 0 1 2\n");
    const auto obj = folder.write("t.obj", "v 0 0 0 0.8 0 0\nv 1 0 0 0.8 0 0\nv 0 1 0 0.8 0 0\n"
                                           "f 1 2 3\n");
    // Its positions are its colours.
    const auto gltf = folder.write("t.gltf", R"({"asset":{"version":"2.0"},
        "scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
            "min":[0,0,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "buffers":[{"byteLength":36,"uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
    for (const auto& path : {ply, obj, gltf}) {
        const TriMesh mesh = read_mesh(path).mesh;
        EXPECT_TRUE(has_vertex_colours(mesh)) << path;
        ASSERT_EQ(mesh.topology->materials.size(), 1u) << path;
        EXPECT_TRUE(is_unstated(mesh.topology->materials[0])) << path;
    }
    EXPECT_EQ(read_mesh(ply).mesh.topology->materials[0], Material{});
}

TEST(ReadMesh, GltfIsLinearAndColladaSaysItsUnit)
{
    const files::Folder folder;
    // One triangle, positions in a data URI: (0,0,0) (1,0,0) (0,1,0); node mirrored and moved.
    const ReadMesh gltf = read_mesh(folder.write("t.gltf", R"({"asset":{"version":"2.0"},
        "scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0,"name":"flipped","scale":[-1,1,1],"translation":[0,0,2]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "materials":[{"name":"m","pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1],
            "metallicFactor":0.5,"roughnessFactor":0.75}}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
            "min":[0,0,0],"max":[1,1,0]}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "buffers":[{"byteLength":36,"uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})"));
    meshes::expect_consistent(gltf.mesh);
    EXPECT_EQ(gltf.mesh.topology->materials.at(0).colour, Vec3f(0.5f, 0.25f, 0.125f));
    EXPECT_FLOAT_EQ(gltf.mesh.topology->materials[0].metallic, 0.5f);
    EXPECT_FLOAT_EQ(gltf.mesh.topology->materials[0].roughness, 0.75f);
    EXPECT_EQ(gltf.mesh.topology->groups, std::vector<std::string>{"flipped"});
    EXPECT_EQ(bounds(gltf.mesh).lo, Vec3(-1, 0, 2));
    // Seen from +z the triangle was counter-clockwise, and is so still after mirroring.
    for (const Vec3f& n : gltf.mesh.normals) EXPECT_NEAR(n.z(), 1, 1e-6);

    const ReadMesh dae = read_mesh(folder.write("t.dae", R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01" name="centimeter"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 100 0 0 0 0 100</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n" name="plate">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)"));
    EXPECT_LT((bounds(dae.mesh).hi - Vec3(1, 1, 0)).norm(), 1e-6);  // z up became y up, cm m
    EXPECT_EQ(dae.mesh.topology->groups, std::vector<std::string>{"plate"});
}

TEST(ReadMesh, FbxSaysItsUnitAndAxes)
{
    const files::Folder folder;
    const ReadMesh read = read_mesh(folder.write("t.fbx", R"(; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7400
}
GlobalSettings:  {
	Version: 1000
	Properties70:  {
		P: "UpAxis", "int", "Integer", "",2
		P: "UpAxisSign", "int", "Integer", "",1
		P: "FrontAxis", "int", "Integer", "",1
		P: "FrontAxisSign", "int", "Integer", "",-1
		P: "CoordAxis", "int", "Integer", "",0
		P: "CoordAxisSign", "int", "Integer", "",1
		P: "UnitScaleFactor", "double", "Number", "",2.54
	}
}
Objects:  {
	Geometry: 1000, "Geometry::tri", "Mesh" {
		Vertices: *9 {
			a: 0,0,0,100,0,0,0,0,100
		}
		PolygonVertexIndex: *3 {
			a: 0,1,-3
		}
		GeometryVersion: 124
	}
	Model: 2000, "Model::plate", "Mesh" {
		Version: 232
	}
}
Connections:  {
	C: "OO",2000,0
	C: "OO",1000,2000
}
)"));
    // 100 units of 2.54 cm; what was z is up.
    EXPECT_LT((bounds(read.mesh).hi - Vec3(2.54, 2.54, 0)).norm(), 1e-5);
    EXPECT_EQ(read.mesh.topology->groups, std::vector<std::string>{"plate"});
}

TEST(ReadMesh, BadFilesAreErrorsThatName)
{
    const files::Folder folder;
    const std::map<std::string, std::string> bad{
        {"truncated.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
                          "float y\nproperty float z\nelement face 1\nproperty list uchar int "
                          "vertex_indices\nend_header\n0 0 0\n1 0"},
        {"truncated_binary.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty "
                                 "float x\nproperty float y\nproperty float z\nelement face 1\n"
                                 "property list uchar int vertex_indices\nend_header\n0123456789"},
        {"nonsense.stl", "solid x\nfacet normal 0 0"},
        {"nonsense.glb", "glTF\x02\x00\x00\x00\xff\xff\xff\x7f"},
        {"empty.gltf", "{}"},
        {"nonsense.fbx", "Kaydara FBX Binary  \x00\x1a\x00"},
        {"broken.dae", "<?xml version=\"1.0\"?><COLLADA><asset>"},
        {"comment.obj", "# nothing here\n"},
        {"all_nan.obj", "v nan 0 0\nv 0 inf 0\nv 0 0 nan\nf 1 2 3\n"},
        {"degenerate.obj", "v 0 0 0\nv 1 0 0\nf 1 1 2\n"},
        {"out_of_range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n"},
    };
    for (const auto& [name, content] : bad) {
        const std::string error = read_error(folder.write(name, content));
        EXPECT_NE(error.find(name), std::string::npos) << name << ": " << error;
        EXPECT_GT(error.size(), name.size() + 20) << error;
    }
    EXPECT_NE(read_error(folder.path / "missing.obj").find("no file"), std::string::npos);
}

TEST(ReadMesh, EveryPrefixOfAFileIsReadOrRefused)
{
    const files::Folder folder;
    const std::string text = cube_obj;
    for (std::size_t n = 1; n < text.size(); n += 37) {
        const auto path = folder.write("cut.obj", text.substr(0, n));
        try {
            meshes::expect_consistent(read_mesh(path).mesh);
        } catch (const std::runtime_error&) {
        }
    }
}

TEST(ReadMesh, AHugeScaleIsReadAsItIs)
{
    const files::Folder folder;
    const ReadMesh read = read_mesh(folder.write(
        "huge.obj",
        "v 0 0 0\nv 1e9 0 0\nv 0 1e9 0\nv 0 0 1e9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"));
    meshes::expect_consistent(read.mesh);
    EXPECT_NEAR(enclosed_volume(read.mesh), 1e27 / 6, 1e21);
}

TEST(ReadMesh, TheSharedBridgeInCentimetres)
{
    const auto path = files::shared() / "models/simple_bridge.obj";
    if (!files::fs::exists(path)) GTEST_SKIP() << "no " << path;
    ReadOptions options;
    options.unit = LengthUnit::centimetre;
    options.up = UpAxis::z;
    const ReadMesh read = read_mesh(path, options);
    meshes::expect_consistent(read.mesh);
    // 16,616 faces, of which 15,398 are quads: 32,014 triangles, two with one vertex twice.
    EXPECT_EQ(read.mesh.triangles().size(), 32'012u);
    EXPECT_NEAR(bounds(read.mesh).size().x(), 0.2, 1e-3);
    EXPECT_NEAR(bounds(read.mesh).size().y(), 0.025, 1e-3);
}

TEST(ReadMesh, AFormatThatIsNotReadAndAPointerInPlaceOfAFileAreTold)
{
    const files::Folder folder;
    const auto shot = folder.write("shot.abc", "Ogawa and so on");
    EXPECT_EQ(read_error(shot), shot.string() + " is of a format that is not read: export it as "
                                                "glTF, FBX, PLY or OBJ");
    const auto chair = folder.write("chair.glb", "version https://git-lfs.github.com/spec/v1\n"
                                                 "oid sha256:00\nsize 132\n");
    EXPECT_EQ(read_error(chair), chair.string() + " is a pointer of Git LFS in place of the file: "
                                                  "fetch the file with 'git lfs pull'");
}

}  // namespace
