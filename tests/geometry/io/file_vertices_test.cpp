#include "geometry/io/file_vertices.hpp"

#include "geometry/io/read_mesh.hpp"
#include "geometry/io/read_positions.hpp"
#include "tests/geometry/files.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

namespace {

using namespace geometry;

// A unit square whose first vertex no face uses, and with two vertices at (1, 1, 0). Faces use the
// others from the last to the first.
constexpr const char* square_obj = "# made by hand\n"
                                   "v 5 5 5\n"
                                   "v 0 0 0\r\n"
                                   "v  +1.0 0 0 1.0\n"
                                   "vt 0 0\n"
                                   "v 1 1 0\n"
                                   "v 1 1 0\n"
                                   "v 0 1e0 -0.0\n"
                                   "f 6 2 4\n"
                                   "f 5 2 3\n";

const std::vector<Vec3f> square_vertices{{5, 5, 5}, {0, 0, 0}, {1, 0, 0},
                                         {1, 1, 0}, {1, 1, 0}, {0, 1, 0}};

ReadOptions in_order()
{
    ReadOptions options;
    options.keep_order = true;
    return options;
}

std::string message_of(const files::fs::path& path)
{
    try {
        read_mesh(path, in_order());
        return "";
    } catch (const std::runtime_error& error) {
        return error.what();
    }
}

TEST(FileVertices, AnObjKeepsItsVerticesAndTheirOrder)
{
    const files::Folder folder;
    const auto path = folder.write("square.obj", square_obj);
    EXPECT_EQ(read_mesh(path).mesh.positions.size(), 4u) << "welded, and none without a face";
    const TriMesh mesh = read_mesh(path, in_order()).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.positions, square_vertices);
    ASSERT_EQ(mesh.triangles().size(), 2u);
    EXPECT_NEAR(surface_area(mesh), 1, 1e-6);
    for (const Triangle& t : mesh.triangles()) {
        for (const std::uint32_t v : t) EXPECT_TRUE(v != 0 && v != 4) << v;
    }
}

TEST(FileVertices, UnitAxisAndPlaceMoveThoseWithoutAFaceToo)
{
    const files::Folder folder;
    ReadOptions options = in_order();
    options.unit = LengthUnit::millimetre;
    options.up = UpAxis::z;
    const TriMesh mesh = read_mesh(folder.write("square.obj", square_obj), options).mesh;
    ASSERT_EQ(mesh.positions.size(), 6u);
    EXPECT_LT((mesh.positions[0] - Vec3f(0.005f, 0.005f, -0.005f)).norm(), 1e-9f);
    EXPECT_LT((mesh.positions[3] - Vec3f(0.001f, 0, -0.001f)).norm(), 1e-9f);
}

TEST(FileVertices, APlyKeepsThemWithTheirColoursAndAttributes)
{
    const files::Folder folder;
    const auto path = folder.write("square.ply", "ply\nformat ascii 1.0\nelement vertex 6\n"
                                                 "property float x\nproperty float y\n"
                                                 "property float z\nproperty uchar red\n"
                                                 "property uchar green\nproperty uchar blue\n"
                                                 "property float heat\nelement face 2\n"
                                                 "property list uchar int vertex_indices\n"
                                                 "end_header\n5 5 5 0 0 0 9\n0 0 0 255 0 0 1\n"
                                                 "1 0 0 255 0 0 2\n1 1 0 255 0 0 3\n"
                                                 "1 1 0 255 0 0 3\n0 1 0 255 0 0 5\n"
                                                 "3 5 1 3\n3 4 1 2\n");
    const TriMesh mesh = read_mesh(path, in_order()).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.positions, square_vertices);
    ASSERT_EQ(mesh.attributes.size(), 1u);
    EXPECT_EQ(mesh.attributes[0].values, (std::vector<float>{0, 1, 2, 3, 3, 5}))
        << "0 where no face is";
    ASSERT_EQ(mesh.colours.size(), 6u);
    EXPECT_EQ(mesh.colours[0], Vec3f(1, 1, 1));
    EXPECT_EQ(mesh.colours[4], Vec3f(1, 0, 0));
}

// Faces whose corners have other texture coordinates at a vertex make no vertices.
TEST(FileVertices, APlyWithSeamsOfItsTextureHasNoMoreOfThem)
{
    const files::Folder folder;
    const auto path =
        folder.write("seam.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                 "property float y\nproperty float z\nelement face 2\n"
                                 "property list uchar int vertex_indices\n"
                                 "property list uchar float texcoord\nend_header\n"
                                 "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
                                 "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 0.1 0 0.9 1 0 1\n");
    const std::vector<Vec3f> four{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const TriMesh mesh = read_mesh(path, in_order()).mesh;
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.positions, four);
    EXPECT_EQ(mesh.topology->uvs.size(), 6u);
    EXPECT_EQ(read_positions(path, 1), four);
}

// Two triangles that share an edge, as objects with vertices of their own.
TEST(FileVertices, ObjectsThatTouchStayApart)
{
    const files::Folder folder;
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 0 -1 0\n";
    const auto path = folder.write("a.obj", vertices + "o a\nf 1 2 3\no b\nf 5 4 6\n");
    ReadOptions options = in_order();
    EXPECT_EQ(read_mesh(path, options).mesh.triangles()[1], (Triangle{1, 0, 5})) << "welded";
    options.weld = Weld::groups;
    const TriMesh mesh = read_mesh(path, options).mesh;
    meshes::expect_consistent(mesh);
    ASSERT_EQ(mesh.positions.size(), 6u);
    EXPECT_EQ(mesh.triangles()[0], (Triangle{0, 1, 2}));
    EXPECT_EQ(mesh.triangles()[1], (Triangle{4, 3, 5}));
    // The second object uses vertices of the first; the first has two vertices at one place.
    for (const std::string& text :
         {std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\no a\nf 1 2 3\no b\nf 2 1 4\n"),
          vertices + "v 0 0 0\no a\nf 1 2 3\nf 3 2 7\no b\nf 5 4 6\n"}) {
        const auto shared = folder.write("b.obj", text);
        try {
            const TriMesh kept = read_mesh(shared, options).mesh;
            FAIL() << text;
        } catch (const std::runtime_error& error) {
            EXPECT_NE(std::string(error.what()).find("set weld = all"), std::string::npos)
                << error.what();
        }
    }
}

TEST(FileVertices, NumbersTooSmallForAFloatAreZero)
{
    EXPECT_EQ(obj_vertices("v 1e-46 -1e-400 2\n"), std::vector<Vec3f>{Vec3f(0, 0, 2)});
    EXPECT_EQ(obj_vertices("v 0 0 1e400\n").at(0).z(), INFINITY);
}

TEST(FileVertices, ManyInOnePlaneAndManyInOnePlaceAreFoundQuickly)
{
    // 90,000 in a plane, their doubles, and 90,000 in one place: comparing them in pairs takes
    // minutes.
    constexpr int side = 300;
    std::vector<Vec3f> of_file;
    for (int i = 0; i < side * side; ++i) {
        const int row = i / side, column = i % side;
        of_file.emplace_back(0.f, float(row), float(column));
    }
    const auto single = of_file;
    of_file.insert(of_file.end(), single.begin(), single.end());
    of_file.insert(of_file.end(), single.size(), Vec3f(0, 7, 7));
    TriMesh mesh;
    auto topology = std::make_shared<MeshTopology>();
    for (int i = side * side - 1; i >= 2; i -= 3) {
        const auto v = std::uint32_t(mesh.positions.size());
        for (int k = 0; k < 3; ++k) mesh.positions.push_back(single[std::size_t(i - k)]);
        topology->triangles.push_back({v, v + 1, v + 2});
    }
    mesh.topology = topology;
    keep_file_vertices(mesh, of_file);
    EXPECT_EQ(mesh.positions, of_file);
    const auto last = std::uint32_t(side * side - 1);
    EXPECT_EQ(mesh.triangles().front(), (Triangle{last, last - 1, last - 2}));
}

TEST(FileVertices, MessagesSayWhatToDo)
{
    const files::Folder folder;
    const std::string stl = message_of(
        folder.write("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                              "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"));
    EXPECT_NE(stl.find("OBJ and PLY alone"), std::string::npos) << stl;
    const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1\nf 1 2 3\n";
    try {
        obj_vertices(text);
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "line 3: expected three numbers after v");
    }
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}};
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 1, 2}};
    mesh.topology = topology;
    EXPECT_THROW(keep_file_vertices(mesh, square_vertices), std::runtime_error);
}

}  // namespace
