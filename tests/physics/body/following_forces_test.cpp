#include "physics/body/following_forces.hpp"

#include "geometry/cubes/sheet.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/body/press_on.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

namespace {

using namespace physics;
using geometry::Cubes;

// A ball of 0.4 m in cubes of 0.1 m that is deformed at random, by up to a third of a cube.
struct Deformed {
    Deformed()
        : mesh(geometry::icosphere(0.4, 2)), cubes(fixtures::box(10, 10, 10, 0.1)), body([this] {
              cubes.origin = Vec3::Constant(-0.5);
              std::vector<std::uint32_t> slot(cubes.corner_count());
              std::iota(slot.rbegin(), slot.rend(), 0u);
              return make_corner_body(cubes, std::move(slot), nullptr);
          }()),
          x(body.rest)
    {
        const geometry::Random random(4);
        for (std::size_t i = 0; i < 4 * body.corners; ++i) {
            if (i % 4 != 3) x[i] += 0.06 * (random.unit(i) - 0.5);
        }
    }

    geometry::TriMesh mesh;
    Cubes cubes;
    CornerBody body;
    Aligned<double> x;
};

struct Resultant {
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // about the origin
};
Resultant resultant(const CornerBody& body, const Aligned<double>& x, const Aligned<double>& f)
{
    Resultant out;
    for (std::size_t k = 0; k < body.corners; ++k) {
        const Vec3 on = Eigen::Map<const Vec3>(f.data() + 4 * k);
        out.force += on;
        out.torque += Vec3(Eigen::Map<const Vec3>(x.data() + 4 * k)).cross(on);
    }
    return out;
}

Aligned<double> pushed(const Deformed& ball, const Force& force, const Aligned<double>& x)
{
    Aligned<double> f(ball.body.numbers, 0);
    add_following_forces(following_forces(ball.body, {&force, 1}), ball.body, x.data(), f);
    return f;
}

TEST(FollowingForces, OfPressureOnAClosedSurfaceSumToNothingHoweverItIsDeformed)
{
    const Deformed ball;
    Force force;
    force.kind = Force::Kind::pressure;
    force.pressure = 1000;
    force.surface = std::make_shared<PressedSurface>(press_on(ball.cubes, ball.mesh, "").surface);
    const auto f = pushed(ball, force, ball.x);
    double all = 0;
    for (const double number : f) all += std::abs(number);
    EXPECT_GT(all, 1000);  // p A = 2 kN
    const Resultant sum = resultant(ball.body, ball.x, f);
    EXPECT_LT(sum.force.norm(), 1e-12 * 2000);
    EXPECT_LT(sum.torque.norm(), 1e-12 * 2000);
}

TEST(FollowingForces, OfPressureAreItsProductWithTheChangeOfVolume)
{
    // In the rest shape, a motion u with div u = d changes the volume by d V: x grows by 1, y and z
    // shrink by 0.2 each; V of the icosphere is that of its faces.
    const Deformed ball;
    Force force;
    force.kind = Force::Kind::pressure;
    force.pressure = 1000;
    force.surface = std::make_shared<PressedSurface>(press_on(ball.cubes, ball.mesh, "").surface);
    const auto f = pushed(ball, force, ball.body.rest);
    double work = 0;
    for (std::size_t k = 0; k < ball.body.corners; ++k) {
        const double* at = ball.body.rest.data() + 4 * k;
        work += f[4 * k] * at[0] - 0.2 * (f[4 * k + 1] * at[1] + f[4 * k + 2] * at[2]);
    }
    double volume = 0;
    for (const auto& [a, b, c] : ball.mesh.triangles()) {
        const auto p = [&](std::uint32_t v) { return Vec3(ball.mesh.positions[v].cast<double>()); };
        volume += p(a).dot(p(b).cross(p(c))) / 6;
    }
    EXPECT_NEAR(work, -1000 * 0.6 * volume, 1e-5 * 600 * volume);  // positions are single
}

TEST(FollowingForces, OfATorqueHaveThatTorqueAndNoForce)
{
    const Deformed ball;
    Force force;
    force.kind = Force::Kind::torque;
    force.torque = Vec3(1, -2, 3);
    force.position = Vec3(0.5, 0.1, 0);
    force.radius = 0.3;
    const Resultant sum = resultant(ball.body, ball.x, pushed(ball, force, ball.x));
    EXPECT_LT(sum.force.norm(), 1e-12);
    EXPECT_LT((sum.torque - force.torque).norm(), 1e-12);

    // It turns with the body, where it follows.
    force.follow = true;
    const geometry::Mat3 turn =
        Eigen::AngleAxisd(2, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    Aligned<double> x = ball.body.rest;
    for (std::size_t k = 0; k < ball.body.corners; ++k) {
        Eigen::Map<Vec3> at(x.data() + 4 * k);
        at = turn * at;
    }
    const Resultant turned = resultant(ball.body, x, pushed(ball, force, x));
    EXPECT_LT((turned.torque - turn * force.torque).norm(), 1e-12);
}

CornerBody body_of_sheet(const Cubes& cubes)
{
    std::vector<std::uint32_t> slot(cubes.corner_count());
    std::iota(slot.begin(), slot.end(), 0u);
    return make_corner_body(cubes, std::move(slot), nullptr);
}

Force pressure_on(const Cubes& sheet, const geometry::TriMesh& mesh)
{
    Force force;
    force.kind = Force::Kind::pressure;
    force.pressure = 100;
    force.surface = std::make_shared<PressedSurface>(press_on(sheet, mesh, "").surface);
    return force;
}

TEST(FollowingForces, OfPressureOnACutSheetAreThoseOfEachOfItsCells)
{
    // Two triangles, 1 m^2, cut into 512: each corner carries a third of the cells around it.
    geometry::TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}};
    auto faces = std::make_shared<geometry::MeshTopology>();
    faces->triangles = {{0, 2, 1}, {0, 3, 2}};
    mesh.topology = faces;
    const Cubes sheet = geometry::make_sheet(mesh, 0.02, {}, 0.0885).cubes;
    ASSERT_EQ(sheet.count(), 512u);
    const Force force = pressure_on(sheet, mesh);
    const CornerBody body = body_of_sheet(sheet);
    Aligned<double> f(body.numbers, 0);
    add_following_forces(following_forces(body, {&force, 1}), body, body.rest.data(), f);
    std::vector<double> expected(sheet.corner_count(), 0);
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        for (const auto k : geometry::sheet_triangle(sheet, c)) expected[k] -= 100.0 / 512 / 3;
    }
    double sum = 0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_NEAR(f[4 * k + 1], expected[k], 1e-6) << k;
        sum += f[4 * k + 1];
    }
    EXPECT_NEAR(sum, -100, 1e-9);
}

TEST(FollowingForces, OfPressureOnAClosedCutSheetSumToNothing)
{
    const geometry::TriMesh mesh = geometry::box({1, 1, 1}, {1, 1, 1});
    const Cubes sheet = geometry::make_sheet(mesh, 0.02, {}, 0.3).cubes;
    ASSERT_GT(sheet.count(), 12u);
    const Force force = pressure_on(sheet, mesh);
    const CornerBody body = body_of_sheet(sheet);
    Aligned<double> x = body.rest, f(body.numbers, 0);
    const geometry::Random random(5);
    for (std::size_t i = 0; i < 4 * body.corners; ++i) {
        if (i % 4 != 3) x[i] += 0.06 * (random.unit(i) - 0.5);
    }
    add_following_forces(following_forces(body, {&force, 1}), body, x.data(), f);
    const Resultant sum = resultant(body, x, f);
    EXPECT_LT(sum.force.norm(), 1e-10);
    EXPECT_LT(sum.torque.norm(), 1e-10);
}

TEST(FollowingForces, ATorqueOnAPointIsRefused)
{
    const Deformed ball;
    Force force;
    force.kind = Force::Kind::torque;
    force.torque = Vec3(1, 0, 0);
    force.position = Vec3(0.5, 0.5, 0.5);
    force.radius = 0;
    EXPECT_THROW(following_forces(ball.body, {&force, 1}), std::invalid_argument);
}

// A cube of 1 m under a hundredth of Young's modulus turns 4 times: forces from where a step starts
// would turn it faster by a fifth a frame.
TEST(FollowingForces, OfPressureLeaveASpinAsItIs)
{
    Cubes cubes = fixtures::box(4, 4, 4, 0.25, {.young = 1e6, .poisson = 0.3});
    cubes.origin = Vec3::Constant(-0.5);
    Force force;
    force.kind = Force::Kind::pressure;
    force.pressure = 1e4;
    const auto mesh = geometry::box({1, 1, 1}, {1, 1, 1});
    force.surface = std::make_shared<PressedSurface>(press_on(cubes, mesh, "").surface);
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back(force);
    State state = rest_state(body);
    const Vec3 spin(0, 0, 2 * std::numbers::pi);
    for (std::size_t k = 0; k < state.v.size(); ++k) state.v[k] = spin.cross(state.x[k]);
    const double before = fixtures::brick_motion(cubes, state).angular.z();
    for (int frame = 0; frame < 96; ++frame) {
        state = advance(body, std::move(state), loads, 1.0 / 24, {});
    }
    const auto after = fixtures::brick_motion(cubes, state);
    EXPECT_NEAR(after.angular.z(), before, 1e-5 * before);
    EXPECT_LT(after.linear.norm(), 1e-6);
}

}  // namespace
