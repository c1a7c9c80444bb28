// Volume, centre and inertia against closed forms.

#include "geometry/mesh/mass_properties.hpp"
#include "tests/geometry/meshes.hpp"

#include <numbers>

namespace {

using namespace geometry;

TEST(MassProperties, OfATurnedBoxAreThoseOfTheBox)
{
    TriMesh mesh = box({1, 2, 3}, {1, 2, 1});
    const Vec3 degrees(20, 30, 40), by(5, -3, 2);
    const Transform placed = placement(by, degrees, {1, 1, 1}, {0, 0, 0});
    move(mesh, placed);
    const MassProperties found = mass_properties(mesh);
    EXPECT_NEAR(found.mass, 6, 1e-5);
    EXPECT_NEAR((found.centre - by).norm(), 0, 1e-6);
    // m (b^2 + c^2) / 12 about its own axes.
    const Mat3 own = Vec3(6 * 13.0 / 12, 6 * 10.0 / 12, 6 * 5.0 / 12).asDiagonal();
    const Mat3 r = placed.linear();
    EXPECT_NEAR((found.inertia - r * own * r.transpose()).norm(), 0, 1e-5);
}

TEST(MassProperties, OfAFineBallAreThoseOfABall)
{
    const double radius = 2;
    const MassProperties found = mass_properties(icosphere(radius, 5));
    const double volume = 4 * std::numbers::pi / 3 * std::pow(radius, 3);
    EXPECT_NEAR(found.mass / volume, 1, 0.002);  // chords lie inside
    EXPECT_NEAR(found.inertia(0, 0) / (0.4 * volume * radius * radius), 1, 0.004);
    EXPECT_NEAR(found.inertia(0, 1), 0, 1e-4);
}

TEST(MassProperties, OfNoMeshIsNothing)
{
    EXPECT_EQ(mass_properties(TriMesh{}).mass, 0);
}

}  // namespace
