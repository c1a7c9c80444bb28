#include "physics/state/radial_force.hpp"

#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

Force radial(double outward, const Vec3& swirl = Vec3::Zero())
{
    Force out;
    out.kind = Force::Kind::radial;
    out.outward = outward;
    out.swirl = swirl;
    out.position = Vec3(1, 2, 3);
    out.radius = 4;
    return out;
}

TEST(RadialForce, PushesAwayDrawsInAndSwirls)
{
    const Vec3 at(3, 2, 3);  // 2 m beside its position
    const double near = 0.75 * 0.75;
    EXPECT_LT((radial_acceleration(radial(8), at) - Vec3(8 * near, 0, 0)).norm(), 1e-12);
    EXPECT_LT((radial_acceleration(radial(-8), at) - Vec3(-8 * near, 0, 0)).norm(), 1e-12);
    EXPECT_LT((radial_acceleration(radial(0, {0, 5, 0}), at) - Vec3(0, 0, -5 * near)).norm(),
              1e-12);
    EXPECT_EQ(radial_acceleration(radial(8), Vec3(5, 2, 3)), Vec3(0, 0, 0));
    EXPECT_EQ(radial_acceleration(radial(8), Vec3(1, 9, 3)), Vec3(0, 0, 0));
    EXPECT_EQ(radial_acceleration(radial(8, {1, 1, 1}), Vec3(1, 2, 3)), Vec3(0, 0, 0));
    const Vec3 close = radial_acceleration(radial(8), Vec3(1.2, 2, 3));  // half of a tenth
    EXPECT_NEAR(close.x(), 4, 0.04);
}

Vec3 mean(const std::vector<Vec3>& of)
{
    Vec3 sum = Vec3::Zero();
    for (const Vec3& v : of) sum += v / double(of.size());
    return sum;
}

TEST(RadialForce, AcceleratesCubesOfAnyMassByEveryMethod)
{
    Loads loads;
    loads.forces.push_back(radial(8, {0, 5, 0}));
    const double dt = 1e-3;
    for (const double density : {1.0, 1e4}) {
        geometry::Cubes cubes = fixtures::box(2, 2, 2, 0.05, {.density = density, .young = 1e6});
        cubes.origin = Vec3(3, 2, 3) - Vec3::Constant(0.05);
        const Vec3 expected = dt * radial_acceleration(loads.forces[0], Vec3(3, 2, 3));
        const auto check = [&](const auto& body, const char* method) {
            const State state = advance(body, rest_state(body), loads, dt, StepOptions{});
            EXPECT_LT((mean(state.v) - expected).norm(), 2e-3 * expected.norm())
                << method << " " << density << " " << mean(state.v).transpose();
        };
        check(make_bricks(cubes), "bricks");
        check(make_bricks(cubes, {.rigid = {1}}), "rigid");
        check(make_springs(cubes), "springs");
        check(make_lattice(cubes), "lattice");
    }
}

TEST(RadialForce, AcceleratesLayers)
{
    using namespace layered_fixtures;
    LayeredScene scene = scene_of({ball({3, 2, 3})});
    const LayeredWorld world{.gravity = Vec3::Zero(), .forces = {radial(8)}};
    const double dt = 1e-3;
    scene = advance(scene, scene.parts, world, dt, 2);
    const Vec3 expected = dt * radial_acceleration(world.forces[0], Vec3(3, 2, 3));
    EXPECT_LT((scene.states[0].velocity[0] - expected).norm(), 2e-3 * expected.norm());
}

}  // namespace
}  // namespace physics
