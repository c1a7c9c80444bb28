#include "geometry/cubes/trilinear.hpp"
#include "physics/body/bent_cube.hpp"
#include "physics/body/plane_touch.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

std::array<Vec3, 8> bent(double size)
{
    std::array<Vec3, 8> x;
    for (std::size_t a = 0; a < 8; ++a) {
        const Vec3 rest(double(a & 1), double((a >> 1) & 1), double(a >> 2));
        x[a] = size * (rest + 0.2 * Vec3(std::sin(3.0 * double(a)), std::cos(5.0 * double(a)),
                                         std::sin(7.0 * double(a) + 1)));
    }
    return x;
}

TEST(BentCube, APlaceIsFoundAgainInAndAroundIt)
{
    const auto x = bent(0.1);
    for (const Vec3& u : {Vec3(0.3, 0.6, 0.2), Vec3(0, 1, 0.5), Vec3(1.1, 0.4, -0.08)}) {
        Vec3 p = Vec3::Zero(), sum = Vec3::Zero();
        const InCube at = place_in(x, u, p);
        const auto weight = geometry::trilinear_weights(u);
        for (std::size_t a = 0; a < 8; ++a) sum += weight[a] * x[a];
        EXPECT_LT((sum - p).norm(), 1e-15);
        const auto in = find_in_cube(x, 0.1, p, 0.2);
        ASSERT_TRUE(in);
        EXPECT_LT((in->u - u).norm(), 1e-8);
        EXPECT_LT((in->axes - at.axes).norm(), 1e-8);
        // The axes are the derivative of the place.
        for (int i = 0; i < 3; ++i) {
            Vec3 ahead, behind;
            place_in(x, u + 1e-6 * Vec3::Unit(i), ahead);
            place_in(x, u - 1e-6 * Vec3::Unit(i), behind);
            EXPECT_LT(((ahead - behind) / 2e-6 - at.axes.col(i)).norm(), 1e-8);
        }
    }
}

TEST(BentCube, APlaceFurtherOffOrInACubeInsideOutIsNone)
{
    auto x = bent(0.1);
    Vec3 p = Vec3::Zero();
    place_in(x, Vec3(1.1, 0.4, 0.5), p);
    EXPECT_FALSE(find_in_cube(x, 0.1, p, 0.05));
    place_in(x, Vec3(0.5, 0.5, 0.5), p);
    std::swap(x[0], x[1]), std::swap(x[2], x[3]), std::swap(x[4], x[5]), std::swap(x[6], x[7]);
    EXPECT_FALSE(find_in_cube(x, 0.1, p, 0.05));
}

TEST(PlaneTouch, WhatIsFoundAgainKeepsItsPlane)
{
    const auto touch = [](std::uint32_t point, std::uint32_t part, double offset) {
        PlaneTouch out;
        out.point = point;
        out.other = part;
        out.offset = offset;
        return out;
    };
    const std::vector<double> x(4, 0.0);
    std::vector<PlaneTouch> touches{touch(2, 0, -1), touch(2, 3, -2), touch(7, 1, -3)};
    EXPECT_FALSE(add_found(touches, {touch(2, 3, -9), touch(4, 0, -0.01)}, x.data(), 0.1));
    EXPECT_TRUE(add_found(touches, {touch(2, 1, -8)}, x.data(), 0.1));
    std::vector<double> offsets;
    for (const PlaneTouch& t : touches) offsets.push_back(t.offset);
    EXPECT_EQ(offsets, (std::vector<double>{-1, -8, -2, -0.01, -3}));
}

PlaneTouch plane_at(std::uint32_t point, double offset, double stiffness)
{
    PlaneTouch out;
    out.point = point;
    out.offset = offset;
    out.stiffness = stiffness;
    return out;
}

TEST(PlaneTouch, RenewedPlanesAreThoseFoundLast)
{
    const std::vector<double> x(4, 0.0);
    std::vector<PlaneTouch> touches{plane_at(1, -1, 5), plane_at(2, 0.5, 5), plane_at(3, -2, 5),
                                    plane_at(4, -3, 5)};
    // 1 is not found any more and goes, 2 is not either but does not press; 3 is as before, 4
    // moved.
    EXPECT_TRUE(renew(touches, {plane_at(3, -2.05, 1), plane_at(4, -1, 9)}, x.data(), 0.1));
    ASSERT_EQ(touches.size(), 3u);
    EXPECT_EQ(touches[0].offset, 0.5);
    EXPECT_EQ(touches[1].offset, -2);
    EXPECT_EQ(touches[1].stiffness, 5);
    EXPECT_EQ(touches[2].offset, -1);
    EXPECT_EQ(touches[2].stiffness, 9);
    EXPECT_FALSE(renew(touches, {plane_at(3, -2, 5), plane_at(4, -1, 9)}, x.data(), 0.1));
    EXPECT_TRUE(renew(touches, {plane_at(3, -2, 5), plane_at(4, -1, 9), plane_at(5, -1, 9)},
                      x.data(), 0.1));
}

// Forces that are to be the slope of a convex function must not jump where a point leaves.
TEST(PlaneTouch, HeldFrictionGoesOnWhereThePushEnds)
{
    PlaneTouch touch = plane_at(0, 0, 100);
    touch.friction = 0.5;
    touch.weight[0] = 1;
    std::vector<double> x{0, -0.01, 0, 0};
    const std::vector<double> v{0.2, 0, 0, 0};
    std::vector<PlaneTouch> touches{touch};
    hold_loads(touches, x.data());  // 1 N
    for (const double y : {-1e-9, 1e-9}) {
        x[1] = y;
        const auto contacts = press(touches, x.data(), v.data(), 0.1, 0);
        ASSERT_EQ(contacts.size(), 1u) << y;
        EXPECT_NEAR(contacts[0].force.x(), -0.5, 1e-9) << y;
        EXPECT_NEAR(contacts[0].force.y(), 0, 1e-6) << y;
    }
    touches[0].load = -1;
    EXPECT_TRUE(press(touches, x.data(), v.data(), 0.1, 0).empty());
}

}  // namespace
}  // namespace physics
