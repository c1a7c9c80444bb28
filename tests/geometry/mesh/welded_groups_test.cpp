// Objects that touch in one file are found in the piece that welding makes of them.

#include "geometry/mesh/welded_groups.hpp"

#include "geometry/mesh/mesh.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace {

using namespace geometry;

// A tetrahedron of these vertices, outwards.
std::vector<Triangle> tetrahedron(std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                  std::uint32_t d)
{
    return {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}};
}

TriMesh mesh_of(const std::vector<std::vector<Triangle>>& groups)
{
    TriMesh mesh;
    mesh.positions.assign(16, Vec3f::Zero());
    for (std::size_t v = 0; v < 16; ++v) mesh.positions[v].x() = static_cast<float>(v);
    auto topology = std::make_shared<MeshTopology>();
    for (std::size_t g = 0; g < groups.size(); ++g) {
        topology->groups.push_back("group " + std::to_string(g));
        for (const Triangle& t : groups[g]) {
            topology->triangles.push_back(t);
            topology->group.push_back(static_cast<std::uint16_t>(g));
        }
    }
    mesh.topology = std::move(topology);
    return mesh;
}

void expect(const TriMesh& mesh, std::size_t groups, std::size_t pieces)
{
    const WeldedGroups found = find_welded_groups(mesh);
    EXPECT_EQ(found.groups, groups);
    EXPECT_EQ(found.pieces, pieces);
}

TEST(WeldedGroups, AreClosedOnesThatShareVertices)
{
    const auto first = tetrahedron(0, 1, 2, 3);
    expect(mesh_of({first, tetrahedron(4, 5, 6, 7)}), 0, 0);  // apart
    expect(mesh_of({first, tetrahedron(3, 4, 5, 6)}), 2, 1);  // at a vertex
    expect(mesh_of({first, tetrahedron(0, 2, 1, 4)}), 2, 1);  // at a whole face
    // Two pairs, and one by itself.
    expect(mesh_of({first, tetrahedron(3, 4, 5, 6), tetrahedron(7, 8, 9, 10),
                    tetrahedron(10, 11, 12, 13), tetrahedron(14, 15, 14, 15)}),
           4, 2);
}

TEST(WeldedGroups, AreNotThePartsOfOneSurface)
{
    const auto all = tetrahedron(0, 1, 2, 3);
    expect(mesh_of({{all[0], all[1]}, {all[2], all[3]}}), 0, 0);
    expect(mesh_of({all, {{3, 4, 5}}}), 0, 0);  // a flag on a closed one
    expect(mesh_of({all}), 0, 0);
    expect(mesh_of({}), 0, 0);
}

}  // namespace
