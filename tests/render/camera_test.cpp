#include "render/camera.hpp"
#include "render/extent.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace {

using geometry::Box;
using geometry::Vec3;
using geometry::Vec3f;
using render::Camera;

// Where a point falls in the picture: -1..1 across and up.
std::array<double, 2> seen(const Camera& c, const Vec3& p, double aspect)
{
    const Vec3 forward = (c.target - c.eye).normalized();
    const Vec3 right = forward.cross(c.up).normalized(), up = right.cross(forward);
    const Vec3 q = p - c.eye;
    const double depth = q.dot(forward), tan_y = std::tan(c.field_of_view / 2);
    EXPECT_GT(depth, 0);
    return {q.dot(right) / (depth * tan_y * aspect), q.dot(up) / (depth * tan_y)};
}

TEST(Camera, DirectionsAreNamedAsTheCompassSeenFromAbove)
{
    EXPECT_LT((render::direction(0, 0) - Vec3(0, 0, 1)).norm(), 1e-15);
    EXPECT_LT((render::direction(1.5707963267948966, 0) - Vec3(1, 0, 0)).norm(), 1e-15);
    EXPECT_LT((render::direction(2, 1.5707963267948966) - Vec3(0, 1, 0)).norm(), 1e-15);
}

// The nearest camera that holds the box: every corner within the margins, and along at least one
// axis of the picture a corner on each of the two sides.
void expect_held(const Box& box, double azimuth, double elevation, double aspect, double right)
{
    const double margin = 0.08;
    const Camera c = render::fit(box, azimuth, elevation, 0.6, aspect, margin, right);
    double x_low = 9, x_high = -9, y_low = 9, y_high = -9;
    for (int k = 0; k < 8; ++k) {
        const Vec3 corner(k & 1 ? box.hi.x() : box.lo.x(), k & 2 ? box.hi.y() : box.lo.y(),
                          k & 4 ? box.hi.z() : box.lo.z());
        const auto [x, y] = seen(c, corner, aspect);
        x_low = std::min(x_low, x), x_high = std::max(x_high, x);
        y_low = std::min(y_low, y), y_high = std::max(y_high, y);
    }
    const double edge = 1 - 2 * margin;  // 8 % free of a picture 2 wide, each side
    const double edge_right = 1 - 2 * std::max(margin, right);
    EXPECT_GT(x_low, -edge - 1e-9);
    EXPECT_LT(x_high, edge_right + 1e-9);
    EXPECT_GT(y_low, -edge - 1e-9);
    EXPECT_LT(y_high, edge + 1e-9);
    const bool full_x = x_high > edge_right - 1e-6 && x_low < -edge + 1e-6;
    const bool full_y = y_high > edge - 1e-6 && y_low < -edge + 1e-6;
    // A needle seen along its length is nearer than its own front: no side is met.
    const Vec3 size = box.hi - box.lo;
    EXPECT_TRUE(full_x || full_y || size.x() < 0.002);
}

TEST(Camera, FitHoldsTheBoxAndNoMore)
{
    for (const Vec3& size :
         {Vec3(20, 3, 2.5), Vec3(1, 1, 1), Vec3(0.001, 5, 0.001), Vec3(1, 0, 1)}) {
        for (const double azimuth : {0.0, 0.6, 2.5, -1.9}) {
            for (const double elevation : {-0.8, 0.0, 0.4, 1.5707963267948966}) {
                for (const double aspect : {0.5, 1.0, 16.0 / 9}) {
                    for (const double right : {0.0, 0.2}) {
                        Box box;
                        box.add(Vec3(3, -7, 11));
                        box.add(Vec3(Vec3(3, -7, 11) + size));
                        expect_held(box, azimuth, elevation, aspect, right);
                    }
                }
            }
        }
    }
}

TEST(Camera, RoomForALegendMovesOnlyWhatWouldLieUnderIt)
{
    Box tall, wide;
    for (const double side : {-1.0, 1.0}) {
        tall.add(Vec3(0.2 * side, side, 0.2 * side));
        wide.add(Vec3(2 * side, side, 0.2 * side));
    }
    const Camera centred = render::fit(tall, 0, 0, 0.6, 1.5, 0.06);
    EXPECT_EQ(render::fit(tall, 0, 0, 0.6, 1.5, 0.06, 0.2).eye, centred.eye);
    EXPECT_GT(render::fit(wide, 0, 0, 0.6, 1.5, 0.06, 0.2).eye.x(), 0.1);
}

// Points on a sphere of radius 1: the margin is what is free above and below them, and a box's
// corners, which nothing reaches, are not held.
TEST(Camera, TheMarginIsWhatIsFreeAroundThePoints)
{
    std::vector<Vec3f> points;
    for (int i = 0; i < 4000; ++i) {
        const float y = 1 - (float(i) + 0.5f) / 2000, a = 2.39996f * float(i);
        const float r = std::sqrt(1 - y * y);
        points.emplace_back(3 + r * std::cos(a), y - 7, r * std::sin(a));
    }
    for (const double fov : {0.6, render::parallel_view}) {
        for (const double margin : {0.0, 0.1, 0.2}) {
            const Camera c = render::fit(points, 0.7, 0.3, fov, 1.6, margin);
            double low = 9, high = -9, right = -9;
            for (const Vec3f& p : points) {
                const auto [x, y] = seen(c, p.cast<double>(), 1.6);
                low = std::min(low, y), high = std::max(high, y), right = std::max(right, x);
            }
            EXPECT_NEAR(high, 1 - 2 * margin, 1e-6);
            EXPECT_NEAR(low, 2 * margin - 1, 1e-6);
            EXPECT_LT(right, 1 - 2 * margin);
        }
    }
}

// Of a ball of many points a few are kept; the camera that fits these holds all of them, up to the
// 1.2 % that the hull of the few may miss.
TEST(Camera, AnExtentStandsForAllPoints)
{
    std::vector<Vec3f> points;
    for (int i = 0; i < 5000; ++i) {
        const float y = 1 - (float(i) + 0.5f) / 2500, a = 2.39996f * float(i);
        const float r = std::sqrt(1 - y * y);
        points.emplace_back(4 * r * std::cos(a), y, 0.3f * r * std::sin(a));
    }
    points.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f);
    const render::Extent extent = render::extent_of(points);
    EXPECT_LE(extent.points.size(), 162u);
    points.pop_back();
    for (const double azimuth : {0.0, 0.5, 1.4}) {
        const Camera c = render::fit(extent.points, azimuth, 0.4, 0.5, 1.6, 0);
        for (const Vec3f& p : points) {
            const auto [x, y] = seen(c, p.cast<double>(), 1.6);
            ASSERT_LT(std::max(std::abs(x), std::abs(y)), 1.03);
        }
    }
}

// Round a long thing the camera stays at one distance.
TEST(Camera, ATurntableKeepsItsDistance)
{
    const std::vector<Vec3f> points{{-4, 0, -0.2f}, {4, 0, 0.2f}, {-4, 1, 0.2f}, {4, 1, -0.2f}};
    const auto ring = render::turned_about(points);
    double least = 1e9, most = 0;
    for (int k = 0; k < 60; ++k) {
        const Camera c = render::fit(ring, 0.1 * k, 0.3, 0.6, 1.6, 0.1);
        least = std::min(least, (c.eye - c.target).norm());
        most = std::max(most, (c.eye - c.target).norm());
        for (const Vec3f& p : points) {
            const auto [x, y] = seen(c, p.cast<double>(), 1.6);
            ASSERT_LT(std::max(std::abs(x), std::abs(y)), 1.0);
        }
    }
    EXPECT_LT(most, 1.01 * least);
}

TEST(Camera, FitScalesWithTheBox)
{
    Box box;
    box.add(Vec3(-1, -2, -3));
    box.add(Vec3(4, 5, 6));
    const Camera one = render::fit(box, 0.3, 0.2, 0.5, 1.5, 0.05);
    for (const double scale : {1e-6, 1e9}) {
        Box scaled;
        scaled.add(Vec3(scale * box.lo));
        scaled.add(Vec3(scale * box.hi));
        const Camera c = render::fit(scaled, 0.3, 0.2, 0.5, 1.5, 0.05);
        EXPECT_LT((c.eye - scale * one.eye).norm(), 1e-12 * scale * one.eye.norm());
    }
}

TEST(Camera, FitTakesNothingAndAPointForSomethingOneMetreWide)
{
    Box point;
    point.add(Vec3(5, 5, 5));
    const Camera c = render::fit(point, 0, 0, 0.6, 1, 0);
    EXPECT_LT((c.target - Vec3(5, 5, 5)).norm(), 1e-12);
    EXPECT_NEAR((c.eye - c.target).norm(), 0.5 + 0.5 / std::tan(0.3), 1e-12);
    EXPECT_LT(render::fit(Box{}, 0, 0, 0.6, 1, 0).target.norm(), 1e-12);
}

TEST(Camera, FitRefusesWhatIsNotFinite)
{
    Box box;
    box.add(Vec3(0, 0, 0));
    box.hi.x() = std::numeric_limits<double>::infinity();
    EXPECT_THROW(render::fit(box, 0, 0, 0.6, 1, 0), std::invalid_argument);
}

// Of a single point it is whether the point lies in the picture; a box is seen if a corner is.
TEST(Camera, MaySeeWhatLiesInThePicture)
{
    const Camera level{{1, 2, 9}, {0, 1, 0}, {0, 1, 0}, 0.7};
    const Camera down{{0, 5, 0}, {0, 0, 0}, {0, 1, 0}, 0.7};
    const double aspect = 1.6;
    int in_picture = 0;
    for (const Camera& camera : {level, down}) {
        const geometry::Mat3 axes = render::camera_axes(camera);
        EXPECT_LT((axes * axes.transpose() - geometry::Mat3::Identity()).norm(), 1e-14);
        EXPECT_NEAR(axes.determinant(), -1, 1e-14) << "right, up and ahead";
        const double tan_y = std::tan(camera.field_of_view / 2);
        for (int k = 0; k < 4096; ++k) {
            const Vec3 at(k % 16 - 7.3, k / 16 % 16 - 7.1, k / 256 % 16 - 3.4);
            const Vec3 p = axes * (at - camera.eye);
            const bool seen = p[2] >= 0 && std::abs(p[1]) <= tan_y * p[2] &&
                              std::abs(p[0]) <= aspect * tan_y * p[2];
            in_picture += seen;
            Box box;
            box.add(at);
            ASSERT_EQ(render::may_see(camera, box, aspect), seen) << at.transpose();
            box.add(Vec3(at + Vec3(2, 3, 4)));
            ASSERT_TRUE(!seen || render::may_see(camera, box, aspect)) << at.transpose();
        }
        Box around;  // no corner of it lies in the picture
        around.add(Vec3(-50, -50, -50));
        around.add(Vec3(50, 50, 50));
        EXPECT_TRUE(render::may_see(camera, around, aspect));
    }
    EXPECT_GT(in_picture, 100);
}

}  // namespace
