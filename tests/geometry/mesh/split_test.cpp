#include "geometry/mesh/split.hpp"

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/polygons.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace geometry;

// The place, normal and texture coordinates of each corner of each face.
std::vector<std::array<float, 8>> corners_of(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    std::vector<std::array<float, 8>> out;
    for (std::size_t f = 0; f < t.triangles.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f p = mesh.positions[t.triangles[f][k]];
            const Vec3f n = t.normal_triangles.empty() ? Vec3f(0, 0, 0)
                                                       : mesh.normals[t.normal_triangles[f][k]];
            const Vec2f uv = t.uv_triangles.empty() ? Vec2f(0, 0) : t.uvs[t.uv_triangles[f][k]];
            out.push_back({p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), uv.x(), uv.y()});
        }
    }
    return out;
}

TEST(Split, APartKeepsWhatItsFacesHaveAndTheRestHasTheOthers)
{
    for (const auto& sound : meshes::sound()) {
        SCOPED_TRACE(sound.name);
        const std::size_t faces = sound.mesh.triangles().size();
        std::vector<std::uint8_t> kept(faces), others(faces);
        for (std::size_t f = 0; f < faces; ++f) {
            kept[f] = f % 3 == 0;
            others[f] = kept[f] == 0;
        }
        const TriMesh part = part_of(sound.mesh, kept), rest = part_of(sound.mesh, others);
        meshes::expect_consistent(part);
        meshes::expect_consistent(rest);
        ASSERT_EQ(part.triangles().size() + rest.triangles().size(), faces);
        const auto whole = corners_of(sound.mesh), of_part = corners_of(part),
                   of_rest = corners_of(rest);
        std::size_t p = 0, r = 0;
        for (std::size_t f = 0; f < faces; ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                ASSERT_EQ(whole[3 * f + k], kept[f] != 0 ? of_part[p++] : of_rest[r++]) << f;
            }
        }
        const auto used = [](const TriMesh& mesh) {
            std::vector<std::uint8_t> is(mesh.positions.size(), 0);
            for (const Triangle& t : mesh.triangles()) {
                for (const auto v : t) is[v] = 1;
            }
            return std::count(is.begin(), is.end(), 1);
        };
        EXPECT_EQ(used(part), std::ssize(part.positions));
        EXPECT_EQ(used(rest), std::ssize(rest.positions));
    }
}

TEST(Split, QuadsOfAPartStayQuadsAndThoseThatAreCutFallApart)
{
    TriMesh mesh = box({1, 1, 1}, {1, 1, 1});
    MeshTopology topology = *mesh.topology;
    topology.polygon = {0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5};
    mesh.topology = std::make_shared<const MeshTopology>(topology);
    const std::vector<std::uint8_t> kept{1, 1, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0};
    const Outlines left = outlines(*part_of(mesh, kept).topology);
    ASSERT_EQ(left.count(), 3u);
    EXPECT_EQ(left[0].size(), 4u);
    EXPECT_EQ(left[1].size(), 3u);
    EXPECT_EQ(left[2].size(), 4u);
}

}  // namespace
