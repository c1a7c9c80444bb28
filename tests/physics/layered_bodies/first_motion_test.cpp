// The first spin of layered bodies, and springs along the edges of a mesh.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics::first_motion_test {

using namespace layered_fixtures;

// L = I w about the middle of mass, and no velocity of that.
TEST(LayeredFirstMotion, ASpinTurnsAllAboutTheMiddleOfMass)
{
    const Vec3 spin(0.5, -2, 1);
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(two_limbs(-1, 1));
    part.spin = spin;
    part.velocity = Vec3(0, 0, 3);
    const LayeredScene scene = start({part});
    const Base& base = part.body->base;
    const double mass = base.mass[0] + base.mass[1];
    EXPECT_LT((momentum(scene) - mass * part.velocity).norm(), 1e-12 * mass);
    const Vec3 apart = base.frames[1].translation() - base.frames[0].translation();
    EXPECT_LT(
        (scene.states[0].velocity[1] - scene.states[0].velocity[0] - spin.cross(apart)).norm(),
        1e-12);
    EXPECT_EQ(scene.states[0].spin[0], spin);

    part.body = std::make_shared<const LayeredBody>(make_layered_body(
        soft_layer({point({1, 0, 0}), point({1.4, 0, 0})}, true), BaseKind::particles, 1000, 0.05));
    const LayeredScene drops = start({part});
    EXPECT_LT(
        (drops.states[0].velocity[1] - drops.states[0].velocity[0] - spin.cross(Vec3(0.4, 0, 0)))
            .norm(),
        1e-9);
    EXPECT_EQ(drops.states[0].spin[0], Vec3::Zero());  // particles do not turn
}

TEST(LayeredFirstMotion, SpringsAlongAMeshAreItsEdges)
{
    const geometry::TriMesh grid = geometry::grid(0.6, 0.4, 3, 2);
    std::vector<Skeleton> points;
    for (const geometry::Vec3f& p : grid.positions) points.push_back(point(p.cast<double>()));
    LayeredBody body = make_layered_body(soft_layer(points, true), BaseKind::particles, 1000, 0.1);
    add_spring_edges(body.base, grid, 0.01, 500, 2);
    // Of 3 x 2 squares: 3 * 3 + 4 * 2 sides and 6 diagonals.
    ASSERT_EQ(body.base.springs.size(), 23u);
    for (const LayerSpring& s : body.base.springs) {
        const double length = (grid.positions[s.a] - grid.positions[s.b]).norm();
        EXPECT_NEAR(s.rest, length, 1e-6);
        EXPECT_LT(s.rest, 0.2 * std::sqrt(2.0) + 1e-6);
        EXPECT_EQ(s.stiffness, 500);
    }
    EXPECT_EQ(body.base.substance.stiffness, 0);
    for (geometry::Transform& frame : body.base.frames) frame.pretranslate(Vec3(0, 0.02, 0));
    EXPECT_THROW(add_spring_edges(body.base, grid, 0.01, 500, 2), std::invalid_argument);
}

}  // namespace physics::first_motion_test
