#include "geometry/io/read_ply.hpp"

#include <gtest/gtest.h>

#include <random>

namespace {

using namespace geometry;

std::string ply_error(const std::string& bytes)
{
    try {
        read_ply(bytes);
        return "";
    } catch (const std::runtime_error& error) {
        return error.what();
    }
}

// A quad and a triangle, with a normal, an unknown property and a colour.
const std::string text = "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info 1\r\n"
                         "element vertex 5\r\nproperty float x\r\nproperty double y\r\n"
                         "property float32 z\r\nproperty float nz\r\nproperty int flags\r\n"
                         "property uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\n"
                         "element face 2\r\nproperty list uchar int vertex_indices\r\n"
                         "property list uchar float texcoord\r\nelement edge 1\r\n"
                         "property int vertex1\r\nproperty int vertex2\r\nend_header\r\n"
                         "0 0 0 1 7 255 0 0\r\n1 0 0 1 7 255 0 0\r\n+1 1e0 0 1 7 255 0 0\r\n"
                         "0 1 0 1 7 255 0 0\r\n0.5 2 0 1 7 0 51 0\r\n"
                         "4 0 1 2 3 2 0.5 0.5\r\n3 3 2 4 0\r\n0 1\r\n";

TEST(ReadPly, TextWithPolygonsAndPropertiesItDoesNotKnow)
{
    const ImportedScene scene = read_ply(text);
    const ImportedMesh& mesh = scene.meshes.at(0);
    ASSERT_EQ(mesh.positions.size(), 5u);
    EXPECT_EQ(mesh.positions[2], Vec3f(1, 1, 0));
    EXPECT_EQ(mesh.normals.at(4), Vec3f(0, 0, 1));
    EXPECT_LT((mesh.colours.at(4) - Vec3f(0, 0.2f, 0)).norm(), 1e-6);
    EXPECT_EQ(mesh.triangles.size(), 3u);
    // The unknown property is an attribute.
    ASSERT_EQ(mesh.attributes.size(), 1u);
    EXPECT_EQ(mesh.attributes[0].name, "flags");
    EXPECT_EQ(mesh.attributes[0].values, std::vector<float>(5, 7));
}

TEST(ReadPly, NumbersOfTheFilesOwnAreAttributesOfAnyType)
{
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                             "property float y\nproperty float z\nproperty double heat\n"
                             "property list uchar int seen_by\nproperty char side\n"
                             "property int heat\n";
    const ImportedMesh mesh = read_ply(head + "end_header\n0 0 0 1.5 2 8 9 -3 7\n1 0 0 -2 0 4 7\n"
                                              "0 1 0 1e-3 1 5 5 7\n")
                                  .meshes.at(0);
    ASSERT_EQ(mesh.attributes.size(), 2u);  // a list is none, and the second heat is not read
    EXPECT_EQ(mesh.attributes[0].name, "heat");
    EXPECT_EQ(mesh.attributes[0].values, (std::vector<float>{1.5f, -2, 1e-3f}));
    EXPECT_EQ(mesh.attributes[1].name, "side");
    EXPECT_EQ(mesh.attributes[1].values, (std::vector<float>{-3, 4, 5}));
}

template <class T> void put(std::string& out, T value, bool big)
{
    std::array<char, sizeof(T)> bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big) std::reverse(bytes.begin(), bytes.end());
    out.append(bytes.data(), bytes.size());
}

// Its first data byte is a line end, which some readers take for part of the header.
std::string binary(bool big)
{
    std::string out = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                      "property short z\nelement face 1\n"
                      "property list uchar uint vertex_index\nend_header\n";
    const float odd = std::bit_cast<float>(0x3e0a0d0au);
    for (const std::array<float, 2>& p : {std::array{odd, 0.f}, {1.f, odd}, {0.f, 1.f}}) {
        put(out, p[0], big);
        put(out, p[1], big);
        put(out, std::int16_t(-3), big);
    }
    put(out, std::uint8_t(3), big);
    for (const std::uint32_t v : {0u, 1u, 2u}) put(out, v, big);
    return out;
}

TEST(ReadPly, BinaryOfEitherByteOrder)
{
    for (const bool big : {false, true}) {
        const ImportedMesh mesh = read_ply(binary(big)).meshes.at(0);
        EXPECT_EQ(mesh.positions.at(0).x(), std::bit_cast<float>(0x3e0a0d0au));
        EXPECT_EQ(mesh.positions.at(2), Vec3f(0, 1, -3));
        EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
    }
}

TEST(ReadPly, StripsTurnEveryOtherTriangleOver)
{
    const ImportedMesh mesh =
        read_ply("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                 "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
                 "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 2 1 0\n")
            .meshes.at(0);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {2, 1, 0}}));
}

TEST(ReadPly, EveryCutIsRefused)
{
    // All but the last line's end, which nothing needs.
    for (std::size_t n = 0; n + 3 < text.size(); ++n) {
        EXPECT_NE(ply_error(text.substr(0, n)), "") << n;
    }
    for (std::size_t n = 0; n < binary(false).size(); ++n) {
        EXPECT_NE(ply_error(binary(false).substr(0, n)), "") << n;
    }
    EXPECT_NE(ply_error(binary(true).substr(0, binary(true).size() - 1)).find("cut short"),
              std::string::npos);
}

TEST(ReadPly, HeadersThatAnnounceTheWorldAreRefusedAtOnce)
{
    const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex ";
    EXPECT_NE(ply_error(head + "18446744073709551615\nproperty float x\nend_header\n"), "");
    EXPECT_EQ(ply_error(head + "18446744073709551615\nend_header\n"), "");  // of nothing
    EXPECT_NE(ply_error(head + "-1\nproperty float x\nend_header\n"), "");
    EXPECT_NE(ply_error(head + "1\nproperty list uint int x\nend_header\n\xff\xff\xff\xff"), "");
    EXPECT_NE(ply_error(head + "1\nproperty quaternion x\nend_header\n"), "");
    EXPECT_NE(ply_error("not ply"), "");
    EXPECT_NE(ply_error(""), "");
}

TEST(ReadPly, WordsThatAreNoNumbersAreNotCutShort)
{
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                             "property float y\nproperty float z\nelement face 1\n"
                             "property list uchar int vertex_indices\nend_header\n";
    const ImportedScene bad = read_ply(head + "0 0 0\n1,5 0 0\n1.5abc 0 0\n0x27 1 0\n3 0 1 2\n");
    for (std::size_t v = 1; v < 4; ++v) {
        EXPECT_TRUE(std::isnan(bad.meshes.at(0).positions.at(v).x())) << v;
    }
    ASSERT_EQ(bad.warnings.size(), 1u);
    EXPECT_EQ(bad.warnings[0], "3 of its words are no number, the first is \"1,5\" in vertex 2: "
                               "write numbers like 1.5.");

    // Corner 1.5 is not corner 1, and what only leaves the range of a double is a number.
    const ImportedScene good = read_ply(head + "0 1e-400 0\n1e400 0 0\n0 1 0\n1 1 0\n3 0 1.5 2\n");
    EXPECT_TRUE(good.warnings.empty());
    EXPECT_EQ(good.meshes.at(0).positions.at(0), Vec3f(0, 0, 0));
    EXPECT_TRUE(std::isinf(good.meshes[0].positions.at(1).x()));
    for (const Triangle& t : good.meshes[0].triangles)
        EXPECT_GE(*std::max_element(t.begin(), t.end()), 4u);
}

// Their numbers could not be told apart: values of the second would go to vertices of the first.
TEST(ReadPly, ASecondElementOfVerticesIsRefused)
{
    const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
    const std::string vertices = xyz + "property float heat\n";
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 1\n" + vertices;
    const std::string face = "element face 1\nproperty list uchar int vertex_indices\n"
                             "property list uchar float texcoord\nend_header\n";
    EXPECT_EQ(ply_error(head + "element vertex 2\n" + vertices + face +
                        "0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 2 2 6 0 0 1 0 0 1\n"),
              "its header has a second element of vertices, \"element vertex 2\", where one was "
              "expected: join the two, or write them to two files");
    EXPECT_EQ(ply_error(head + face + "0 0 0 1\n3 0 0 0 6 0 0 1 0 0 1\n"), "");
}

// A corner with coordinates of its own is a copy of its vertex, with the numbers of that.
TEST(ReadPly, CopiesOfVerticesHaveTheirAttributes)
{
    const ImportedMesh mesh =
        read_ply("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                 "property float z\nproperty float heat\nelement face 2\n"
                 "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
                 "end_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2 6 0 0 1 0 0 1\n"
                 "3 2 1 0 6 0.5 1 1 0 0 0\n")
            .meshes.at(0);
    ASSERT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.attributes.at(0).values, (std::vector<float>{1, 2, 3, 3}));
}

TEST(ReadPly, NoisyFilesAreReadOrRefused)
{
    std::minstd_rand random(3);
    for (int i = 0; i < 3000; ++i) {
        std::string bytes = i % 2 ? text : binary(i % 4 == 0);
        for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = char(random());
        ply_error(bytes);
    }
}

}  // namespace
