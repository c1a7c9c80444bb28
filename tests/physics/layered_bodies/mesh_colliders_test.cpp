// Colliders that are meshes, under layers.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

using namespace physics;
using namespace physics::layered_fixtures;

namespace {

using Mesh = std::shared_ptr<const geometry::TriMesh>;

constexpr double frame = 1.0 / 24;  // s

LayeredPart part_of(const LayeredBody& body)
{
    return {.body = std::make_shared<const LayeredBody>(body)};
}

Mesh moved(const geometry::TriMesh& shape, const Vec3& by)
{
    auto mesh = std::make_shared<geometry::TriMesh>(shape);
    for (auto& p : mesh->positions) p += by.cast<float>();
    return mesh;
}

// As a file gives it that is read anew for each frame.
Mesh read_anew(const Mesh& mesh)
{
    auto copy = std::make_shared<geometry::TriMesh>(*mesh);
    copy->topology = std::make_shared<const geometry::MeshTopology>(*mesh->topology);
    return copy;
}

// A ball on a slab that goes sideways.
LayeredScene ridden(bool each_read_anew)
{
    const geometry::TriMesh shape = geometry::box({4, 0.2, 4}, {1, 1, 1});
    Collider slab;
    slab.kind = Collider::Kind::mesh;
    LayeredBody rider = ball({0, 0.19, 0});
    rider.matter.friction = 2e4;
    slab.mesh = moved(shape, Vec3::Zero());
    LayeredScene scene = start({part_of(rider), rigid_part(slab)});
    for (int i = 1; i <= 12; ++i) {
        slab.mesh_before = each_read_anew ? read_anew(slab.mesh) : slab.mesh;
        slab.mesh = moved(shape, {0.5 * frame * i, 0, 0});
        if (each_read_anew) slab.mesh = read_anew(slab.mesh);
        scene = advance(scene, {scene.parts[0], rigid_part(slab)}, {}, frame, 3);
    }
    return scene;
}

}  // namespace

// Frames of a file share no topology, and what is read again is another mesh of the same bytes.
TEST(MeshColliders, MoveAlikeWhetherTheirFramesShareATopology)
{
    const LayeredScene shared = ridden(false), apart = ridden(true);
    EXPECT_GT(shared.states[0].velocity[0].x(), 0.05);
    EXPECT_EQ(apart.states[0].position, shared.states[0].position);
    EXPECT_EQ(apart.states[0].velocity, shared.states[0].velocity);
}

TEST(MeshColliders, StandStillWhereTheyAreReadAgain)
{
    Collider slab;
    slab.kind = Collider::Kind::mesh;
    slab.mesh = moved(geometry::box({4, 0.2, 4}, {1, 1, 1}), Vec3::Zero());
    slab.mesh_before = read_anew(slab.mesh);
    EXPECT_EQ(rigid_part(slab).mesh_before, nullptr);
}

// However large it is: a ball pressed on it by 2 cm feels what it feels on a plane.
TEST(MeshColliders, TheirSurfaceIsWhereThatOfAPlaneIs)
{
    for (const double thickness : {0.0, 0.03}) {
        Collider plane, slab;
        slab.kind = Collider::Kind::mesh;
        slab.mesh = moved(geometry::box({100, 2, 100}, {1, 1, 1}), {0, -1, 0});
        plane.thickness = slab.thickness = thickness;
        const auto push = [&](const Collider& collider) {
            const LayeredScene scene =
                start({part_of(ball({0, thickness + 0.08, 0})), rigid_part(collider)});
            return LayeredMoment(scene).contacts.wrenches[0][0].force.y();
        };
        EXPECT_GT(push(plane), 1);
        EXPECT_NEAR(push(slab), push(plane), 0.01 * push(plane)) << thickness;
    }
}
