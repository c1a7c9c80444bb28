#include "geometry/mesh/mesh.hpp"
#include "physics/body/external_forces.hpp"

#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace {

using namespace physics;
using geometry::Cubes;

CornerBody body_of(const Cubes& cubes, const geometry::TriMesh* surface = nullptr)
{
    std::vector<std::uint32_t> slot(cubes.corner_count());
    std::iota(slot.begin(), slot.end(), 0u);
    return make_corner_body(cubes, std::move(slot), surface);
}

Force push(const Vec3& position, double radius)
{
    Force f;
    f.kind = Force::Kind::point;
    f.force = Vec3(1, -2, 3);
    f.position = position;
    f.radius = radius;
    return f;
}

struct Resultant {
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // about the origin
    int corners = 0;                                   // that feel anything
};
Resultant resultant(const CornerBody& body, const Force& force)
{
    Aligned<double> f(body.numbers, 0);
    add_steady_forces(body, std::span(&force, 1), f);
    Resultant out;
    for (std::size_t k = 0; k < body.corners; ++k) {
        const Vec3 at = Eigen::Map<const Vec3>(body.rest.data() + 4 * k);
        const Vec3 on = Eigen::Map<const Vec3>(f.data() + 4 * k);
        out.force += on;
        out.torque += at.cross(on);
        out.corners += !on.isZero(0);
    }
    return out;
}

TEST(PointForce, HasTheSameForceAndTorqueHoweverLargeTheCubes)
{
    // Where the skin is pressed, by points spread evenly over it.
    const geometry::TriMesh ball = geometry::icosphere(0.4, 3);
    const Vec3 centre(0.3, 0.25, 0.1);
    const double radius = 0.15;
    Vec3 pressed = Vec3::Zero();
    double total = 0;
    for (const auto& [a, b, c] : ball.triangles()) {
        const Vec3 p = ball.positions[a].cast<double>(), q = ball.positions[b].cast<double>(),
                   r = ball.positions[c].cast<double>();
        const double area = (q - p).cross(r - p).norm();
        for (int i = 0; i < 40; ++i) {
            for (int j = 0; i + j < 40; ++j) {
                const Vec3 at = p + (i + 1.0 / 3) / 40 * (q - p) + (j + 1.0 / 3) / 40 * (r - p);
                const double s = 1 - (at - centre).squaredNorm() / (radius * radius);
                if (s <= 0) continue;
                pressed += area * s * s * at;
                total += area * s * s;
            }
        }
    }
    pressed /= total;
    const Force force = push(centre, radius);
    for (const double size : {0.3, 0.1, 0.05}) {
        const Cubes cubes = geometry::voxelize_surface(
            ball, {{}, {{}}, {}}, 0, geometry::fit_grid(geometry::triangle_bounds(ball), size), {});
        const Resultant got = resultant(body_of(cubes, &ball), force);
        EXPECT_LT((got.force - force.force).norm(), 1e-12);
        // Both sums are of second order in the size of their parts, an eighth and a fortieth.
        EXPECT_LT((got.torque - pressed.cross(force.force)).norm(), 2e-3 * got.torque.norm())
            << size;
    }
}

TEST(PointForce, OnTheEndOfABeamBendsItLikeAnEndLoad)
{
    // Nothing but the end face is within the radius.
    for (const int across : {1, 2, 4}) {
        const double h = 0.1 / across;
        const Cubes cubes = fixtures::box(12 * across, across, across, h);
        const Vec3 end(1.2, 0.05, 0.05);
        const Force force = push(end, 0.04);
        const Resultant got = resultant(body_of(cubes), force);
        EXPECT_LT((got.force - force.force).norm(), 1e-12);
        EXPECT_LT((got.torque - end.cross(force.force)).norm(), 1e-6) << across;
    }
}

TEST(PointForce, DeepInsidePullsAtTheMaterialAround)
{
    const Cubes cubes = fixtures::box(8, 8, 8, 0.1);
    const Vec3 middle(0.4, 0.4, 0.4);
    const Force force = push(middle, 0.15);
    const Resultant got = resultant(body_of(cubes), force);
    EXPECT_EQ(got.corners, 19);  // one, its 6 neighbours at 0.1 and 12 at 0.141
    EXPECT_LT((got.force - force.force).norm(), 1e-12);
    EXPECT_LT((got.torque - middle.cross(force.force)).norm(), 1e-12);
}

TEST(PointForce, WithoutARadiusActsAtItsPoint)
{
    const CornerBody body = body_of(fixtures::box(3, 2, 2, 0.1));
    for (const Vec3& at : {Vec3(0.13, 0.02, 0.17), Vec3(0.1, 0.1, 0.1), Vec3(0.3, 0.2, 0.05)}) {
        const Force force = push(at, 0);
        const Resultant got = resultant(body, force);
        EXPECT_LT((got.force - force.force).norm(), 1e-12);
        EXPECT_LT((got.torque - at.cross(force.force)).norm(), 1e-12);
    }
    // Outside all cubes: the nearest corner.
    const Resultant far = resultant(body, push(Vec3(5, 0.2, 0.2), 0.1));
    EXPECT_EQ(far.corners, 1);
    EXPECT_LT((far.torque - Vec3(0.3, 0.2, 0.2).cross(far.force)).norm(), 1e-12);
}

}  // namespace
