#include "geometry/mesh/transform.hpp"

#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

namespace {

using namespace geometry;

TEST(Transform, TurnsAboutXThenYThenZ)
{
    // 90 degrees about x takes z to -y; then about z takes -y to x.
    EXPECT_LT((rotation_xyz({90, 0, 90}) * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-15);
    // 90 about y takes x to -z; z is not touched by the turn about x, which came before.
    EXPECT_LT((rotation_xyz({90, 90, 0}) * Vec3::UnitX() + Vec3::UnitZ()).norm(), 1e-15);
}

TEST(Transform, ThePivotStaysButForTheTranslation)
{
    const Vec3 pivot(1, 2, 3), by(0.5, -1, 4);
    const Transform T = placement(by, {10, 20, 30}, {2, 3, -4}, pivot);
    EXPECT_LT((T * pivot - (pivot + by)).norm(), 1e-14);
}

TEST(Transform, NormalsStayPerpendicularUnderUnevenScaleAndMirroring)
{
    for (const Vec3& scale : {Vec3(1, 2, 5), Vec3(-1, 2, 0.3), Vec3(-1, -1, -1), Vec3(3, -1, -2)}) {
        for (auto [name, mesh, closed] : meshes::sound()) {
            SCOPED_TRACE(name);
            if (!closed) continue;
            const double before = enclosed_volume(mesh);
            const Transform T = placement({1, 2, 3}, {40, 50, 60}, scale, {0, 0, 0});
            move(mesh, T);
            if (mirrors(T.linear())) {
                mesh.topology =
                    std::make_shared<const MeshTopology>(turned_inside_out(*mesh.topology));
            }
            meshes::expect_consistent(mesh);
            // Volume scales by |det|, and stays positive: faces still look outwards.
            EXPECT_NEAR(enclosed_volume(mesh), before * std::abs(scale.prod()),
                        1e-4 * before * std::abs(scale.prod()));
            if (name == "box" || name == "fine box") {
                EXPECT_GT(meshes::worst_normal(mesh), 1 - 1e-4);  // flat: exact but for floats
            } else {
                EXPECT_GT(meshes::worst_normal(mesh), 0);
            }
        }
    }
}

TEST(Transform, FlatteningGivesTheNormalOfThePlane)
{
    TriMesh mesh = icosphere(1, 2);
    move(mesh, placement({0, 0, 0}, {0, 0, 0}, {1, 0, 1}, {0, 0, 0}));
    meshes::expect_consistent(mesh);
    for (const Vec3f& n : mesh.normals) EXPECT_NEAR(std::abs(n.y()), n.y() == 0 ? 0 : 1, 1e-6);
    move(mesh, placement({0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}));
    meshes::expect_consistent(mesh);  // a point: normals stay as they were
}

TEST(Transform, ExtremeScalesDoNotSpoilNormals)
{
    for (const double s : {1e-30, 1e30}) {
        TriMesh mesh = box({1, 1, 1}, {1, 1, 1});
        move(mesh, placement({0, 0, 0}, {30, 0, 0}, {s, s, s}, {0, 0, 0}));
        for (const Vec3f& n : mesh.normals) EXPECT_NEAR(n.norm(), 1, 1e-6);
    }
}

}  // namespace
