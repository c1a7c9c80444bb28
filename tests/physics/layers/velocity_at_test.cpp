#include "physics/layers/velocity_at.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

using geometry::SkeletonKind;

geometry::Skeleton solid(SkeletonKind kind, const Vec3& half_size)
{
    geometry::Skeleton out;
    out.kind = kind;
    out.half_size = half_size;
    return out;
}

// How far the place at p goes.
Vec3 way(SkeletonKind kind, const Vec3& from, const Vec3& to, const Vec3& p)
{
    return way_of(solid(kind, (from + to) / 2), solid(kind, from), solid(kind, to), p);
}

TEST(VelocityAt, AStretchedSegmentMovesAPlaceByItsNearestPointInNarrowedSpace)
{
    // Its far end rises by 1: a place goes as far as its share of the length.
    const auto share_of = [](const geometry::Mat3& stretch, const Vec3& p) {
        geometry::Skeleton now{
            .kind = SkeletonKind::segment, .points = {{0, 0, 0}, {1, 0, 0}}, .stretch = stretch};
        geometry::Skeleton after = now;
        after.points[1].y() = 1;
        return way_of(now, now, after, p).y();
    };
    const geometry::Mat3 axes = Eigen::AngleAxisd(0.6, Vec3::UnitZ()).matrix();
    const geometry::Mat3 stretch = axes * Vec3(3, 1, 1).asDiagonal() * axes.transpose();
    const Vec3 p(0.4, 0.2, 0.1);
    double best = 0, least = 1e9;
    for (int i = 0; i <= 100000; ++i) {
        const double t = i * 1e-5;
        const double far = (stretch.inverse() * (p - Vec3(t, 0, 0))).norm();
        if (far < least) least = far, best = t;
    }
    EXPECT_NEAR(share_of(stretch, p), best, 2e-5);
    EXPECT_GT(std::abs(best - 0.4), 0.05);
    EXPECT_NEAR(share_of(geometry::Mat3::Identity(), p), 0.4, 1e-12);
}

TEST(VelocityAt, RoundSkeletonsThatGrowPushByWhatGrows)
{
    // A cylinder gets taller by 0.1 at its cap, whatever the distance from its axis, and wider by
    // 0.1 at its side, whatever the height.
    const auto taller = [](const Vec3& p) {
        return way(SkeletonKind::cylinder, {1, 0.95, 0}, {1, 1.05, 0}, p);
    };
    EXPECT_NEAR(taller({0.95, 1.2, 0}).y(), 0.1, 1e-12);
    EXPECT_NEAR(taller({0.1, 1.2, 0}).y(), 0.1, 1e-12);
    const Vec3 wider = way(SkeletonKind::cylinder, {0.95, 1, 0}, {1.05, 1, 0}, {0, 0.9, 1.5});
    EXPECT_NEAR(wider.z(), 0.1, 1e-12);
    EXPECT_NEAR(wider.y(), 0, 1e-12);
    // The top of a cone gets wider: its rim by all of that, half way up by half.
    const auto opened = [](double y) {
        return way(SkeletonKind::cone, {1, 1, 0.45}, {1, 1, 0.55}, {2, y, 0}).x();
    };
    EXPECT_NEAR(opened(1), 0.1, 1e-12);
    EXPECT_NEAR(opened(0), 0.05, 1e-12);
    EXPECT_NEAR(opened(-1), 0, 1e-12);
    // The tube of a torus gets thicker by 0.05 while its outer radius stays: the ring shrinks by
    // 0.05, so that the inner side goes in by 0.1 and the outer one stays.
    const auto thicker = [](double x) {
        return way(SkeletonKind::torus, {1, 0.2, 0}, {1, 0.25, 0}, {x, 0, 0}).x();
    };
    EXPECT_NEAR(thicker(0.4), -0.1, 1e-12);
    EXPECT_NEAR(thicker(1.2), 0, 1e-12);
}

}  // namespace
}  // namespace physics
