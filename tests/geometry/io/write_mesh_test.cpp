#include "geometry/io/export_mesh.hpp"
#include "geometry/io/read_mesh.hpp"
#include "tests/geometry/files.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstring>

namespace {

using namespace geometry;

// Every kind of thing that a mesh can carry.
TriMesh rich()
{
    TriMesh mesh = meshes::sound().back().mesh;
    for (const Vec3f& p : mesh.positions) {
        mesh.colours.push_back((0.25f * (p + Vec3f(1, 1, 1))).cwiseMax(0).cwiseMin(1));
    }
    mesh.attributes = {{"speed of it", "m/s", std::vector<float>(mesh.positions.size(), 2.5f)}};
    return mesh;
}

ReadMesh there_and_back(const files::Folder& folder, const std::string& name, const TriMesh& mesh)
{
    const auto path = folder.path / name;
    write_mesh(path, mesh_format(path), mesh);
    return read_mesh(path);
}

// The same shape: as many faces, volume, area and bounds alike.
void expect_same_shape(const TriMesh& a, const TriMesh& b)
{
    EXPECT_EQ(a.triangles().size(), b.triangles().size());
    EXPECT_EQ(a.positions.size(), b.positions.size());
    // assimp reads decimal numbers to the last place or two of a float.
    EXPECT_LT((bounds(a).lo - bounds(b).lo).norm(), 1e-6);
    EXPECT_LT((bounds(a).hi - bounds(b).hi).norm(), 1e-6);
    EXPECT_NEAR(surface_area(a), surface_area(b), 1e-5);
    EXPECT_NEAR(enclosed_volume(a), enclosed_volume(b), 1e-5);
}

// Binary PLY keeps every bit of an attribute, at each vertex of faces and of clouds. A name that
// PLY has for something else gets a _.
TEST(WriteMesh, AttributesComeBackFromPlyAsTheyWere)
{
    const files::Folder folder;
    TriMesh mesh = meshes::sound().back().mesh;
    Attribute odd{"heat_1", "K", {}}, coordinate{"s", "", {}};
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        odd.values.push_back(float(v) / 3 - 1e-7f);
        coordinate.values.push_back(1e30f * float(v));
    }
    mesh.attributes = {odd, coordinate};
    TriMesh cloud;
    cloud.positions = mesh.positions;
    cloud.attributes = mesh.attributes;
    for (const TriMesh& m : {mesh, cloud}) {
        const TriMesh back = there_and_back(folder, "a.ply", m).mesh;
        ASSERT_EQ(back.positions, m.positions);
        ASSERT_EQ(back.attributes.size(), 2u);
        EXPECT_EQ(back.attributes[0].name, "heat_1");
        EXPECT_EQ(back.attributes[0].values, odd.values);
        EXPECT_EQ(back.attributes[1].name, "s_");
        EXPECT_EQ(back.attributes[1].values, coordinate.values);
    }
}

// Names that the reader takes for something else, and names that are one without their spaces.
TEST(WriteMesh, EveryAttributeHasAPropertyOfItsOwn)
{
    const files::Folder folder;
    const std::vector<std::string> names{"texture_u", "diffuse_red", "diffuse_x", "a b",
                                         "a_b",       "u",           "u_",        ""};
    TriMesh mesh = meshes::sound().back().mesh;
    for (const std::string& name : names) {
        const auto value = static_cast<float>(mesh.attributes.size());
        mesh.attributes.push_back({name, "", std::vector<float>(mesh.positions.size(), value)});
    }
    const TriMesh back = there_and_back(folder, "a.ply", mesh).mesh;
    EXPECT_EQ(back.positions, mesh.positions);
    std::vector<std::string> found;
    for (const Attribute& a : back.attributes) {
        EXPECT_EQ(a.values, mesh.attributes.at(found.size()).values) << a.name;
        found.push_back(a.name);
    }
    EXPECT_EQ(found, (std::vector<std::string>{"texture_u_", "diffuse_red_", "diffuse_x_", "a_b",
                                               "a_b_", "u_", "u__", "value"}));
}

TEST(WriteMesh, EveryFormatComesBackTheSameShape)
{
    const files::Folder folder;
    for (const auto& [name, mesh, closed] : meshes::sound()) {
        for (const char* ending : {"obj", "ply", "stl", "glb"}) {
            SCOPED_TRACE(name + " as " + ending);
            const ReadMesh back = there_and_back(folder, std::string("a.") + ending, mesh);
            meshes::expect_consistent(back.mesh);
            expect_same_shape(mesh, back.mesh);
            EXPECT_EQ(back.warnings, std::vector<std::string>{});
            if (std::string(ending) == "obj" || std::string(ending) == "glb") {
                EXPECT_EQ(back.mesh.normals.size(), mesh.normals.size());
                EXPECT_NEAR(meshes::worst_normal(back.mesh), meshes::worst_normal(mesh), 1e-5);
            }
        }
    }
}

// What goes from frame to frame is where vertices are, not how many: also where two of them meet.
TEST(WriteMesh, FramesOfAMovingMeshKeepTheirVertices)
{
    const auto vertices = [](const TriMesh& mesh) {
        const std::string obj = obj_text(mesh, "");
        std::size_t lines = 0;
        for (std::size_t at = 0; (at = obj.find("v ", at)) != std::string::npos; ++at) ++lines;
        const std::string glb = glb_bytes(mesh);
        std::uint32_t length = 0;
        std::memcpy(&length, glb.data() + 12, sizeof length);
        const auto json = nlohmann::json::parse(glb.substr(20, length));
        std::size_t in_glb = 0;
        for (const auto& primitive : json["meshes"][0]["primitives"]) {
            const std::size_t accessor = primitive["attributes"]["POSITION"];
            in_glb += json["accessors"][accessor]["count"].get<std::size_t>();
        }
        return std::array{lines, in_glb};
    };
    TriMesh mesh = meshes::soup({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
                                {{0, 1, 2}, {3, 4, 5}});
    ASSERT_EQ(vertices(mesh), (std::array<std::size_t, 2>{6, 6}));
    mesh.positions[3] = mesh.positions[0];
    EXPECT_EQ(vertices(mesh), (std::array<std::size_t, 2>{6, 6}));
    std::copy_n(mesh.positions.begin(), 3, mesh.positions.begin() + 3);
    EXPECT_EQ(vertices(mesh), (std::array<std::size_t, 2>{6, 6}));
}

TEST(WriteMesh, ObjAndGlbKeepMaterialsGroupsColoursAndTextureCoordinates)
{
    const files::Folder folder;
    const TriMesh mesh = rich();
    for (const char* name : {"a.obj", "a.glb"}) {
        SCOPED_TRACE(name);
        const TriMesh back = there_and_back(folder, name, mesh).mesh;
        ASSERT_EQ(back.topology->materials.size(), 2u);
        for (std::size_t i = 0; i < 2; ++i) {
            const Material &a = mesh.topology->materials[i], &b = back.topology->materials[i];
            EXPECT_EQ(a.name, b.name);
            EXPECT_LT((a.colour - b.colour).norm(), 1e-5);
            EXPECT_NEAR(a.opacity, b.opacity, 1e-6);
            EXPECT_NEAR(a.roughness, b.roughness, 1e-6);
        }
        EXPECT_EQ(back.topology->material, mesh.topology->material);
        EXPECT_EQ(back.topology->groups, mesh.topology->groups);
        EXPECT_EQ(back.topology->group, mesh.topology->group);
        // Faces keep their order here, so corners can be compared one by one.
        ASSERT_EQ(back.colours.size(), back.positions.size());
        const auto &s = *mesh.topology, &t = *back.topology;
        ASSERT_EQ(t.uv_triangles.size(), s.uv_triangles.size());
        for (std::size_t f = 0; f < s.triangles.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto v = s.triangles[f][k], w = t.triangles[f][k];
                ASSERT_LT((mesh.positions[v] - back.positions[w]).norm(), 1e-6);
                ASSERT_LT((mesh.colours[v] - back.colours[w]).norm(), 1e-5);
                ASSERT_LT((s.uvs[s.uv_triangles[f][k]] - t.uvs[t.uv_triangles[f][k]]).norm(), 1e-6);
                ASSERT_LT((mesh.normals[s.normal_triangles[f][k]] -
                           back.normals[t.normal_triangles[f][k]])
                              .norm(),
                          1e-6);
            }
        }
    }
}

TEST(WriteMesh, PlyKeepsColoursAndBitsOfPositions)
{
    const files::Folder folder;
    const TriMesh mesh = rich();
    const TriMesh back = there_and_back(folder, "a.ply", mesh).mesh;
    EXPECT_TRUE(back.positions == mesh.positions);
    ASSERT_EQ(back.colours.size(), mesh.colours.size());
    // 8 bits of sRGB: half a step is 1/510, and light changes at most 2.3 times as fast.
    for (std::size_t v = 0; v < mesh.colours.size(); ++v) {
        ASSERT_LT((back.colours[v] - mesh.colours[v]).cwiseAbs().maxCoeff(), 2.3f / 510 + 1e-6f);
    }
    EXPECT_NE(ply_bytes(mesh).find("property float speed_of_it\n"), std::string::npos);
}

TEST(WriteMesh, PointCloudsComeBackAsPoints)
{
    const files::Folder folder;
    TriMesh cloud;
    cloud.positions = {{1, 2, 3}, {4, 5, 6}, {-1, 0, 0.1f}};
    cloud.colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const char* name : {"p.obj", "p.ply", "p.glb"}) {
        SCOPED_TRACE(name);
        const TriMesh back = there_and_back(folder, name, cloud).mesh;
        EXPECT_TRUE(back.triangles().empty());
        ASSERT_EQ(back.positions.size(), 3u);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_LT((back.positions[i] - cloud.positions[i]).norm(), 1e-6);
            EXPECT_LT((back.colours.at(i) - cloud.colours[i]).norm(), 1e-3);
        }
    }
    EXPECT_THROW(stl_bytes(cloud), std::invalid_argument);
    EXPECT_THROW(glb_bytes(TriMesh{}), std::invalid_argument);
}

TEST(WriteMesh, NamesThatBreakLinesOrRepeatAreTamed)
{
    const TriMesh a = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), {"a\nb c", {1, 0, 0}}, "\n");
    const TriMesh b = meshes::with_material(icosphere(1, 0), {"a b c", {0, 1, 0}}, "x\ty\xff");
    const std::array<const TriMesh*, 2> both{&a, &b};
    const TriMesh mesh = merge(both);
    const std::string mtl = mtl_text(mesh);
    EXPECT_NE(mtl.find("newmtl a_b_c\n"), std::string::npos);
    EXPECT_NE(mtl.find("newmtl a_b_c.1\n"), std::string::npos);
    const files::Folder folder;
    EXPECT_EQ(there_and_back(folder, "n.obj", mesh).mesh.topology->materials.size(), 2u);
    EXPECT_EQ(there_and_back(folder, "n.glb", mesh).mesh.topology->materials.size(), 2u);
}

TEST(WriteMesh, MaterialsOfOneNameGetNamesThatNoOtherHas)
{
    TriMesh mesh;
    auto topology = std::make_shared<MeshTopology>();
    for (const char* name : {"m", "m", "m.1", "m", "m.1"}) topology->materials.push_back({name});
    mesh.topology = topology;
    std::string names;
    const std::string text = mtl_text(mesh);
    for (std::size_t at = 0; (at = text.find("newmtl ", at)) != std::string::npos; ++at) {
        names += text.substr(at + 7, text.find('\n', at) - at - 7) + " ";
    }
    EXPECT_EQ(names, "m m.2 m.1 m.3 m.1.1 ");
}

TEST(WriteMesh, FilesAreWholeOrNotThere)
{
    const files::Folder folder;
    const TriMesh mesh = box({1, 1, 1}, {1, 1, 1});
    // A folder stands where the file should go.
    files::fs::create_directories(folder.path / "a.obj" / "b");
    EXPECT_THROW(write_mesh(folder.path / "a.obj", MeshFormat::obj, mesh), std::runtime_error);
    // A file stands where a folder is needed.
    folder.write("file", "x");
    EXPECT_THROW(write_mesh(folder.path / "file/b.obj", MeshFormat::obj, mesh), std::runtime_error);
    for (const auto& entry : files::fs::directory_iterator(folder.path)) {
        EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
    }
    // New folders are made.
    write_mesh(folder.path / "x/y/z.ply", MeshFormat::ply, mesh);
    EXPECT_EQ(files::bytes_of(folder.path / "x/y/z.ply"), ply_bytes(mesh));
}

TEST(WriteMesh, AnUnknownEndingNamesThoseThatAreKnown)
{
    EXPECT_EQ(mesh_format("a.GLB"), MeshFormat::glb);
    EXPECT_THROW(mesh_format("a.abc"), std::invalid_argument);
}

// ---- through assimp -----------------------------------------------------------------------------

TEST(ExportMesh, EveryFormatComesBackTheSameShapeInItsUnitAndColours)
{
    const files::Folder folder;
    for (const auto& [name, mesh, closed] : meshes::sound()) {
        for (const char* ending : {"obj", "ply", "stl", "glb", "gltf", "dae", "fbx", "x3d"}) {
            SCOPED_TRACE(name + " as " + ending);
            const auto path = folder.path / (std::string("b.") + ending);
            export_mesh(path, mesh_format(path), mesh);
            const ReadMesh back = read_mesh(path);
            meshes::expect_consistent(back.mesh);
            expect_same_shape(mesh, back.mesh);
            const bool has_materials = std::string(ending) != "ply" && std::string(ending) != "stl";
            if (!has_materials || mesh.topology->materials.empty()) continue;
            // Faces keep their colours, whichever way the format holds them.
            const auto colour = [](const TriMesh& m, std::size_t f) {
                const MeshTopology& t = *m.topology;
                return t.materials[t.material.empty() ? 0 : t.material[f]].colour;
            };
            const auto mean = [&](const TriMesh& m) {
                Vec3f sum = Vec3f::Zero();
                for (std::size_t f = 0; f < m.triangles().size(); ++f) sum += colour(m, f);
                return Vec3f(sum / float(m.triangles().size()));
            };
            EXPECT_LT((mean(mesh) - mean(back.mesh)).norm(), 1e-4);
        }
    }
}

TEST(ExportMesh, SideFilesAreWhereTheFileSaysTheyAre)
{
    const files::Folder folder;
    const TriMesh mesh = rich();
    const auto library = export_mesh(folder.path / "s/a.0001.obj", MeshFormat::obj, mesh);
    EXPECT_NE(files::bytes_of(folder.path / "s/a.0001.obj").find("mtllib a.0001.mtl"),
              std::string::npos);
    EXPECT_EQ(library, std::vector{folder.path / "s/a.0001.mtl"});
    EXPECT_TRUE(std::filesystem::exists(library[0]));
    const auto numbers = export_mesh(folder.path / "s/a.0002.gltf", MeshFormat::gltf, mesh);
    EXPECT_EQ(numbers, std::vector{folder.path / "s/a.0002.bin"});
    EXPECT_NE(files::bytes_of(folder.path / "s/a.0002.gltf").find("a.0002.bin"), std::string::npos);
    EXPECT_TRUE(std::filesystem::exists(folder.path / "s/a.0002.bin"));
}

TEST(ExportMesh, SaysWhatToDoWhenAssimpFails)
{
    const files::Folder folder;
    const auto path = folder.path / "a.dae";
    const files::FakeAssimp out_of_memory("exit 3");
    try {
        export_mesh(path, MeshFormat::dae, rich());
        FAIL() << "written without memory";
    } catch (const std::runtime_error& error) {
        const std::string what = error.what();
        EXPECT_NE(what.find("a.dae"), std::string::npos) << what;
        EXPECT_NE(what.find("OBJ, PLY or GLB"), std::string::npos) << what;
    }
    EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
