// Quads and other polygons of files are written as such.

#include "geometry/embed/torn_faces.hpp"
#include "geometry/io/export_mesh.hpp"
#include "geometry/io/read_mesh.hpp"
#include "geometry/io/read_ply.hpp"
#include "geometry/mesh/polygons.hpp"
#include "tests/geometry/files.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

using namespace geometry;

// A square with a seam of its texture, a notched pentagon, a triangle; and a second group.
const std::string obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 3 0.5 0\n"
                        "v 1.5 0.4 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n"
                        "o left\nf 1/1 2/2 3/3 4/4\nf 2/1 5/2 6/3 8/5 3/4\n"
                        "o right\nf 5/1 7/2 6/3\n";

std::vector<std::size_t> corners(const TriMesh& mesh)
{
    std::vector<std::size_t> out;
    const Outlines faces = outlines(*mesh.topology);
    for (std::size_t p = 0; p < faces.count(); ++p) out.push_back(faces[p].size());
    return out;
}

using Loop = std::vector<std::array<float, 3>>;

// Where corners lie, from the least place on.
template <class Corners> Loop loop_of(const TriMesh& mesh, const Corners& corners)
{
    Loop loop;
    for (const std::uint32_t v : corners) {
        const Vec3f& at = mesh.positions[v];
        loop.push_back({at.x(), at.y(), at.z()});
    }
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    return loop;
}

// Of each polygon, then of each triangle.
std::vector<Loop> places(const TriMesh& mesh)
{
    std::vector<Loop> out;
    const Outlines faces = outlines(*mesh.topology);
    for (std::size_t p = 0; p < faces.count(); ++p) {
        std::vector<std::uint32_t> vertices;
        for (const std::uint32_t c : faces[p]) vertices.push_back(mesh.triangles()[c / 3][c % 3]);
        out.push_back(loop_of(mesh, vertices));
    }
    for (const Triangle& t : mesh.triangles()) out.push_back(loop_of(mesh, t));
    return out;
}

const std::vector<std::size_t> four_five_three{4, 5, 3};

TEST(PolygonsKept, WhatAnObjHoldsComesBackFromEveryFormatThatHasPolygons)
{
    const files::Folder folder;
    const TriMesh mesh = read_mesh(folder.write("a.obj", obj)).mesh;
    ASSERT_EQ(corners(mesh), four_five_three);
    for (const char* name : {"b.obj", "b.ply"}) {
        SCOPED_TRACE(name);
        write_mesh(folder.path / name, mesh_format(name), mesh);
        const TriMesh back = read_mesh(folder.path / name).mesh;
        meshes::expect_consistent(back);
        EXPECT_EQ(places(back), places(mesh));
        EXPECT_EQ(back.topology->uvs.size(), mesh.topology->uvs.size());
    }
    for (const char* name : {"c.obj", "c.ply", "c.dae", "c.fbx", "c.x3d"}) {
        SCOPED_TRACE(name);
        export_mesh(folder.path / name, mesh_format(name), mesh);
        const TriMesh back = read_mesh(folder.path / name).mesh;
        meshes::expect_consistent(back);
        EXPECT_EQ(places(back), places(mesh));
    }
    for (const char* name : {"d.stl", "d.glb"}) {  // which hold triangles alone
        SCOPED_TRACE(name);
        write_mesh(folder.path / name, mesh_format(name), mesh);
        EXPECT_EQ(corners(read_mesh(folder.path / name).mesh), std::vector<std::size_t>(6, 3));
    }
}

TEST(PolygonsKept, AFileOfTrianglesHasNoList)
{
    const files::Folder folder;
    for (const char* name : {"a.obj", "a.ply", "a.glb"}) {
        const auto path = folder.path / name;
        write_mesh(path, mesh_format(path), meshes::sound().back().mesh);
        EXPECT_TRUE(read_mesh(path).mesh.topology->polygon.empty()) << name;
    }
}

TEST(PolygonsKept, APolygonWithoutOneOfItsTrianglesIsTriangles)
{
    const files::Folder folder;
    const TriMesh mesh = read_mesh(folder.write("a.obj", obj)).mesh;
    EXPECT_EQ(corners(without_faces(mesh, {0, 0, 0, 1, 0, 0})),
              (std::vector<std::size_t>{4, 3, 3, 3}));
    EXPECT_EQ(corners(without_faces(mesh, {1, 0, 0, 0, 0, 1})), (std::vector<std::size_t>{3, 5}));
}

// Turned inside out and back: a mirrored instance is wound to face outwards.
TEST(PolygonsKept, AMirroredPolygonIsOneStill)
{
    const files::Folder folder;
    TriMesh mesh = read_mesh(folder.write("a.obj", obj)).mesh;
    mesh.topology = std::make_shared<const MeshTopology>(turned_inside_out(*mesh.topology));
    EXPECT_EQ(corners(mesh), four_five_three);
    auto loops = places(mesh);
    std::reverse(loops[0].begin() + 1, loops[0].end());
    EXPECT_EQ(loops[0], places(read_mesh(folder.path / "a.obj").mesh)[0]);
}

std::string ply_of(const std::string& vertices, std::size_t count, const std::string& faces,
                   std::size_t face_count)
{
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
           std::to_string(face_count) + "\nproperty list int int vertex_indices\nend_header\n" +
           vertices + faces;
}

// Two vertices, one vertex, none; a corner twice in a row and once more later; vertices that are
// not there. The quads around stay.
TEST(PolygonsKept, BrokenPolygonsHarmNoOther)
{
    const files::Folder folder;
    const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 1\n2 1 1\n";
    const std::string faces = "4 0 1 2 3\n2 0 1\n1 3\n0\n5 0 1 1 2 3\n6 0 1 2 0 4 5\n4 0 1 2 9\n"
                              "4 0 0 0 0\n4 1 4 5 2\n";
    const TriMesh ply = read_mesh(folder.write("a.ply", ply_of(square, 6, faces, 9))).mesh;
    meshes::expect_consistent(ply);
    EXPECT_EQ(corners(ply).front(), 4u);
    EXPECT_EQ(corners(ply).back(), 4u);
    EXPECT_EQ(corners(read_mesh(folder.write("b.ply", ply_bytes(ply))).mesh), corners(ply));
    const std::string same = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\nv 2 1 1\n"
                             "f 1 2 3 4\nf 1 2\nf 1 2 2 3 4\nf 1 2 3 1 5 6\nf 1 1 1 1\nf 2 5 6 3\n";
    const TriMesh read = read_mesh(folder.write("a.obj", same)).mesh;
    meshes::expect_consistent(read);
    EXPECT_EQ(corners(read).front(), 4u);
    EXPECT_EQ(corners(read).back(), 4u);
}

// A gear of 10,000 corners, which is cut into a fan; and one of 300, whose list is longer than a
// byte counts.
TEST(PolygonsKept, PolygonsOfManyCorners)
{
    const files::Folder folder;
    for (const std::uint32_t n : {100u, 300u, 10'000u}) {
        SCOPED_TRACE(n);
        std::string vertices, face = std::to_string(n);
        for (std::uint32_t i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi * i / n, r = i % 2 == 0 ? 1 : 0.9;
            vertices += std::to_string(r * std::cos(angle)) + " " +
                        std::to_string(r * std::sin(angle)) + " 0\n";
            face += " " + std::to_string(i);
        }
        const TriMesh mesh =
            read_mesh(folder.write("a.ply", ply_of(vertices, n, face + "\n", 1))).mesh;
        ASSERT_EQ(corners(mesh), std::vector<std::size_t>{n});
        for (const char* name : {"b.ply", "b.obj"}) {
            write_mesh(folder.path / name, mesh_format(name), mesh);
            EXPECT_EQ(corners(read_mesh(folder.path / name).mesh), corners(mesh)) << name;
        }
        const bool byte = ply_bytes(mesh).find("list uchar uint") != std::string::npos;
        EXPECT_EQ(byte, n < 256);
    }
}

}  // namespace
