// One tetrahedron in every text format that the importer reads, and in binary ones, whole, with a
// number that is none, and cut short: the same mesh from each, and never one that is not finite.

#include "geometry/io/read_mesh.hpp"
#include "geometry/io/write_mesh.hpp"
#include "tests/geometry/files.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

namespace {

using geometry::Vec3f;

// The vertices, a number in words each, in the order in which all formats list them.
using Numbers = std::array<std::array<std::string, 3>, 4>;

const Numbers tetrahedron{{{"0", "0", "0"}, {"1", "0", "0"}, {"0", "1", "0"}, {"0", "0", "1"}}};
constexpr int faces[4][3]{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

std::string vertices(const Numbers& at, const std::string& before, const std::string& after)
{
    std::string out;
    for (const auto& v : at) out += before + v[0] + " " + v[1] + " " + v[2] + after;
    return out;
}

std::string indices(const std::string& before, const std::string& between, const std::string& after,
                    int first = 0)
{
    std::string out;
    for (const auto& f : faces) {
        out += before + std::to_string(f[0] + first) + between + std::to_string(f[1] + first) +
               between + std::to_string(f[2] + first) + after;
    }
    return out;
}

// The corners of each face, for formats without indices.
std::string corners(const Numbers& at, const std::string& before_face, const std::string& before,
                    const std::string& after, const std::string& after_face)
{
    std::string out;
    for (const auto& f : faces) {
        out += before_face;
        for (const int k : f) {
            const auto& v = at[std::size_t(k)];
            out += before + v[0] + " " + v[1] + " " + v[2] + after;
        }
        out += after_face;
    }
    return out;
}

struct Format {
    const char* name;
    std::function<std::string(const Numbers&)> text;
};

std::string collada(const Numbers& at)
{
    return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="1" name="metre"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">)" +
           vertices(at, "", " ") + R"(</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>)" +
           indices("", " ", " ") + R"(</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n" name="t">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

std::string ac3d(const Numbers& at)
{
    std::string out = "AC3Db\nMATERIAL \"m\" rgb 1 0 0  amb 0 0 0  emis 0 0 0  spec 0 0 0  shi 0  "
                      "trans 0\nOBJECT world\nkids 1\nOBJECT poly\nname \"t\"\nnumvert 4\n" +
                      vertices(at, "", "\n") + "numsurf 4\n";
    for (const auto& f : faces) {
        out += "SURF 0x00\nmat 0\nrefs 3\n";
        for (const int k : f) out += std::to_string(k) + " 0 0\n";
    }
    return out + "kids 0\n";
}

std::string direct_x(const Numbers& at)
{
    std::string out = "xof 0303txt 0032\nMesh t {\n4;\n";
    for (std::size_t v = 0; v < 4; ++v) {
        out += at[v][0] + ";" + at[v][1] + ";" + at[v][2] + (v == 3 ? ";;\n" : ";,\n");
    }
    out += "4;\n";
    for (int f = 0; f < 4; ++f) {
        out += "3;" + std::to_string(faces[f][0]) + "," + std::to_string(faces[f][1]) + "," +
               std::to_string(faces[f][2]) + (f == 3 ? ";;\n" : ";,\n");
    }
    return out + "}\n";
}

std::string fbx(const Numbers& at)
{
    std::string numbers, corners;
    for (const auto& v : at)
        numbers += (numbers.empty() ? "" : ",") + v[0] + "," + v[1] + "," + v[2];
    for (const auto& f : faces) {  // the last corner of a face is told by its complement
        corners += (corners.empty() ? "" : ",") + std::to_string(f[0]) + "," +
                   std::to_string(f[1]) + "," + std::to_string(-f[2] - 1);
    }
    return "; FBX 7.3.0 project file\nFBXHeaderExtension:  {\n\tFBXHeaderVersion: 1003\n"
           "\tFBXVersion: 7300\n}\nObjects:  {\n\tGeometry: 1, \"Geometry::t\", \"Mesh\" {\n"
           "\t\tVertices: *12 {\n\t\t\ta: " +
           numbers + "\n\t\t}\n\t\tPolygonVertexIndex: *12 {\n\t\t\ta: " + corners +
           "\n\t\t}\n\t\tGeometryVersion: 124\n\t}\n"
           "\tModel: 2, \"Model::t\", \"Mesh\" {\n\t\tVersion: 232\n\t}\n}\n"
           "Connections:  {\n\tC: \"OO\",2,0\n\tC: \"OO\",1,2\n}\n";
}

const std::vector<Format>& formats()
{
    static const std::vector<Format> all{
        {"t.obj",
         [](const Numbers& at) { return vertices(at, "v ", "\n") + indices("f ", " ", "\n", 1); }},
        {"t.off",
         [](const Numbers& at) {
             return "OFF\n4 4 0\n" + vertices(at, "", "\n") + indices("3 ", " ", "\n");
         }},
        {"t.ply",
         [](const Numbers& at) {
             return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                    "property float z\nelement face 4\nproperty list uchar int vertex_indices\n"
                    "end_header\n" +
                    vertices(at, "", "\n") + indices("3 ", " ", "\n");
         }},
        {"t.stl",
         [](const Numbers& at) {
             return "solid t\n" +
                    corners(at, "facet normal 0 0 0\nouter loop\n", "vertex ", "\n",
                            "endloop\nendfacet\n") +
                    "endsolid t\n";
         }},
        {"t.raw", [](const Numbers& at) { return "t\n" + corners(at, "", "", " ", "\n"); }},
        {"t.nff", [](const Numbers& at) { return corners(at, "p 3\n", "", "\n", ""); }},
        {"t.ac", ac3d},
        {"t.dae", collada},
        {"t.x", direct_x},
        {"t.fbx", fbx},
    };
    return all;
}

// The mesh with its unit and axes as they are in the file, or what was wrong.
std::pair<std::optional<geometry::TriMesh>, std::string> read(const files::fs::path& path)
{
    geometry::ReadOptions options;
    options.unit = geometry::LengthUnit::metre;
    try {
        return {geometry::read_mesh(path, options).mesh, ""};
    } catch (const std::exception& error) {
        return {std::nullopt, error.what()};
    }
}

TEST(ReadFormats, EachGivesTheSameTetrahedron)
{
    const files::Folder folder;
    for (const Format& format : formats()) {
        SCOPED_TRACE(format.name);
        const auto [mesh, error] = read(folder.write(format.name, format.text(tetrahedron)));
        ASSERT_TRUE(mesh) << error;
        meshes::expect_consistent(*mesh);
        EXPECT_EQ(mesh->positions.size(), 4u);
        ASSERT_EQ(mesh->triangles().size(), 4u);
        // Whatever axes the format has: a corner of the unit cube cut off, faces outward.
        double six_volumes = 0;
        for (const auto& [a, b, c] : mesh->triangles()) {
            const auto& p = mesh->positions;
            six_volumes += double(p[a].dot(p[b].cross(p[c])));
        }
        EXPECT_NEAR(std::abs(six_volumes), 1, 1e-6);
    }
}

TEST(ReadFormats, NumbersThatAreNoneOrInfiniteNeverGetThrough)
{
    const files::Folder folder;
    for (const Format& format : formats()) {
        for (const char* number : {"nan", "-inf", "1e999", "x", ""}) {
            Numbers at = tetrahedron;
            at[3][2] = number;
            SCOPED_TRACE(testing::Message() << format.name << " with '" << number << "'");
            const auto [mesh, error] = read(folder.write(format.name, format.text(at)));
            if (!mesh) {
                EXPECT_NE(error.find(format.name), std::string::npos) << error;
                continue;
            }
            for (const Vec3f& p : mesh->positions) EXPECT_TRUE(p.allFinite());
            for (const Vec3f& n : mesh->normals) EXPECT_TRUE(n.allFinite());
        }
    }
}

// Binary files: the same, with the bytes of one number changed for those of a float that is none.
TEST(ReadFormats, BinaryNumbersThatAreNoneOrInfiniteNeverGetThrough)
{
    const files::Folder folder;
    const float marked = 0.734375f;
    geometry::TriMesh mesh;
    mesh.positions = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, 0, marked)};
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    mesh.topology = topology;
    const std::string needle(reinterpret_cast<const char*>(&marked), sizeof marked);
    const std::vector<std::pair<const char*, std::string>> whole{
        {"t.stl", geometry::stl_bytes(mesh)},
        {"t.ply", geometry::ply_bytes(mesh)},
        {"t.glb", geometry::glb_bytes(mesh)}};
    for (const auto& [name, bytes] : whole) {
        SCOPED_TRACE(name);
        ASSERT_NE(bytes.find(needle), std::string::npos);
        const auto [sound, none] = read(folder.write(name, bytes));
        ASSERT_TRUE(sound) << none;
        ASSERT_EQ(sound->triangles().size(), 4u);
        for (const float number :
             {std::nanf(""), HUGE_VALF, -HUGE_VALF, std::numeric_limits<float>::max()}) {
            SCOPED_TRACE(number);
            std::string broken = bytes;
            for (auto at = broken.find(needle); at != std::string::npos; at = broken.find(needle)) {
                std::memcpy(broken.data() + at, &number, sizeof number);
            }
            const auto [mesh_read, error] = read(folder.write(name, broken));
            if (!mesh_read) {
                EXPECT_NE(error.find(name), std::string::npos) << error;
                continue;
            }
            for (const Vec3f& p : mesh_read->positions) EXPECT_TRUE(p.allFinite());
            for (const Vec3f& n : mesh_read->normals) EXPECT_TRUE(n.allFinite());
        }
    }
}

TEST(ReadFormats, FilesCutShortAreReadOrRefused)
{
    const files::Folder folder;
    for (const Format& format : formats()) {
        const std::string text = format.text(tetrahedron);
        for (const std::size_t tenths : {1u, 5u, 9u}) {
            const auto path = folder.write(format.name, text.substr(0, text.size() * tenths / 10));
            SCOPED_TRACE(testing::Message() << format.name << ", " << tenths << " tenths of it");
            const auto [mesh, error] = read(path);
            if (mesh) {
                meshes::expect_consistent(*mesh);
            } else {
                EXPECT_NE(error.find(format.name), std::string::npos) << error;
            }
        }
    }
}

}  // namespace
