#include "geometry/fields/field.hpp"

#include "geometry/base/random.hpp"
#include "geometry/fields/evaluate_block.hpp"
#include "geometry/fields/evaluate_points.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mesh.hpp"
#include "tests/geometry/fields/field_checks.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace geometry {
namespace {

using field_checks::in_cube;

Transform turned(double angle, const Vec3& axis, const Vec3& move)
{
    Transform t = Transform::Identity();
    t.translate(move).rotate(Eigen::AngleAxisd(angle, axis.normalized()));
    return t;
}

Skeleton points_skeleton(SkeletonKind kind, std::vector<Vec3> points)
{
    return {.kind = kind, .points = std::move(points)};
}

Skeleton solid(SkeletonKind kind, const Vec3& half_size, const Transform& place)
{
    return {.kind = kind, .points = {}, .half_size = half_size, .place = place};
}

// Corners +-half, faces outward.
TriMesh box_mesh(const Vec3f& half)
{
    TriMesh mesh;
    for (int i = 0; i < 8; ++i) {
        mesh.positions.push_back(
            half.cwiseProduct(Vec3f(i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f)));
    }
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                           {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    mesh.topology = topology;
    return mesh;
}

// One of each, about the origin, all a good metre across.
std::vector<Skeleton> one_of_each()
{
    Skeleton mesh = solid(SkeletonKind::mesh, {1, 1, 1}, turned(0.2, {1, -1, 0}, {-0.2, 0, 0.1}));
    mesh.mesh = std::make_shared<const SkeletonMesh>(box_mesh({0.25f, 0.5f, 0.125f}));
    return {
        points_skeleton(SkeletonKind::point, {{0.1, 0.2, -0.1}}),
        points_skeleton(SkeletonKind::segment, {{-0.5, 0, 0.1}, {0.4, 0.3, 0}}),
        points_skeleton(SkeletonKind::polyline, {{-0.5, 0, 0}, {0, 0.5, 0}, {0.3, 0.5, 0.6}}),
        points_skeleton(SkeletonKind::triangle, {{-0.5, 0, 0}, {0.5, 0.1, 0}, {0, 0.2, 0.7}}),
        solid(SkeletonKind::box, {0.3, 0.2, 0.4}, turned(0.5, {1, 2, 3}, {0.1, 0, 0})),
        solid(SkeletonKind::ellipsoid, {0.5, 0.2, 0.3}, turned(0.8, {3, 1, 2}, {0, 0.1, 0})),
        mesh,
        solid(SkeletonKind::plane, {1, 1, 1}, turned(0.3, {1, 0, 1}, {0, -0.4, 0})),
    };
}

// Every way to blend, of plain skeletons and of stretched ones.
std::vector<std::pair<BlendRule, std::vector<Skeleton>>> every_rule()
{
    std::vector<std::pair<BlendRule, std::vector<Skeleton>>> out;
    for (const BlendRule rule : {BlendRule::sum, BlendRule::largest_group, BlendRule::smooth_groups,
                                 BlendRule::gradient}) {
        out.emplace_back(rule, one_of_each());
        out.emplace_back(rule, field_checks::stretched(one_of_each()));
    }
    return out;
}

const Contribution soft{.thickness = 0.3, .stiffness = 2, .radius = 0.9, .stiffening = 0.5};

ImplicitLayer layer_of(std::vector<Skeleton> skeletons, BlendRule rule = BlendRule::sum)
{
    ImplicitLayer layer;
    layer.skeletons = std::move(skeletons);
    layer.contributions.assign(layer.skeletons.size(), soft);
    layer.frame.assign(layer.skeletons.size(), 0);
    layer.blend.rule = rule;
    return layer;
}

const std::vector<Transform> at_rest{Transform::Identity()};

// Many point and segment skeletons in a cube of half edge `half`.
ImplicitLayer crowd(std::size_t count, double half, double radius)
{
    const Random random(7);
    ImplicitLayer layer;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 a = in_cube(random, 2 * i, half), b = in_cube(random, 2 * i + 1, half);
        layer.skeletons.push_back(i % 3 == 0
                                      ? points_skeleton(SkeletonKind::segment, {a, a + 0.1 * b})
                                      : points_skeleton(SkeletonKind::point, {a}));
        layer.contributions.push_back({0.4 * radius, 1.5 / radius, radius, 0});
        layer.frame.push_back(0);
    }
    return layer;
}

// f without any structure: every skeleton asked, then blended.
Blended brute_force(const ImplicitLayer& layer, const Field& field, const Vec3& p)
{
    std::vector<Contributor> contributors;
    for (std::uint32_t i = 0; i < field.count(); ++i) {
        const Foot at = foot(field, i, p);
        const ProfileValue v = profile_at(make_profile(layer.contributions[i], 1), at.r);
        if (!(v.f > 0)) continue;
        contributors.push_back({i, v.f, v.slope * at.n});
        set_turning(field, at, contributors.back());
    }
    return blend(field.rule, BlendWeights(layer.blend, field.count()), contributors);
}

}  // namespace

TEST(FieldProfile, MeetsItsIsovalueSlopeAndEndsAndNeverRises)
{
    const FieldProfile p = make_profile({0.4, 1.5, 1.0, 2.0}, 0.8);
    EXPECT_DOUBLE_EQ(profile_at(p, 0.4).f, 0.8);
    EXPECT_DOUBLE_EQ(profile_at(p, 0.4).slope, -1.5);
    EXPECT_NEAR(profile_at(p, 0.4 + 1e-12).slope, -1.5, 1e-10);  // C1 at e
    EXPECT_EQ(profile_at(p, 1.0).f, 0);
    EXPECT_NEAR(profile_at(p, 1.0 - 1e-9).slope, 0, 1e-8);     // and at R
    EXPECT_DOUBLE_EQ(profile_at(p, 0).slope, -1.5 * (1 + 2));  // grown by s at the skeleton
    for (double r = 0; r < 1; r += 1e-3) {
        EXPECT_LE(profile_at(p, r).slope, 0);
        const double h = 1e-6;
        const double numeric = (profile_at(p, r + h).f - profile_at(p, r - h).f) / (2 * h);
        EXPECT_NEAR(profile_at(p, r).slope, numeric, 1e-5);  // h times the jump of f'' at e
    }
}

TEST(FieldProfile, IsTheCubicOfTheMethodsPage)
{
    // (r - R)^2 (a r + b), D = e - R, a = -(k + 2c/D)/D^2, b = c/D^2 - a e.
    const double e = 0.4, k = 1.5, R = 1.0, c = 0.8, D = e - R;
    const double a = -(k + 2 * c / D) / (D * D), b = c / (D * D) - a * e;
    const FieldProfile p = make_profile({e, k, R, 0}, c);
    for (double r = e; r < R; r += 0.01) {
        EXPECT_NEAR(profile_at(p, r).f, (r - R) * (r - R) * (a * r + b), 1e-14);
    }
}

TEST(FieldProfile, AContributionThatWouldRiseThrows)
{
    // k (R - e) = 3c is the last that falls all the way; just beyond it f rises near R.
    EXPECT_NO_THROW(make_profile({0.4, 3 / 0.6, 1.0, 0}, 1));
    EXPECT_THROW(make_profile({0.4, 3.01 / 0.6, 1.0, 0}, 1), std::invalid_argument);
    EXPECT_THROW(make_profile({0.4, 1, 0.4, 0}, 1), std::invalid_argument);
    EXPECT_THROW(make_profile({0, 1, 1, 0}, 1), std::invalid_argument);
    EXPECT_THROW(make_profile({0.4, 0, 1, 0}, 1), std::invalid_argument);
    EXPECT_THROW(make_profile({0.4, 1, 1, -0.1}, 1), std::invalid_argument);
    EXPECT_THROW(make_profile({0.4, 1, 1, 0}, 0), std::invalid_argument);
    EXPECT_THROW(make_profile({std::nan(""), 1, 1, 0}, 1), std::invalid_argument);
}

TEST(FieldProfile, ATranslationMovesTheSurfaceAndKeepsItsSlope)
{
    const FieldProfile p = make_profile({0.4, 1.5, 1.0, 0}, 1, 0.05);
    EXPECT_DOUBLE_EQ(profile_at(p, 0.45).f, 1);
    EXPECT_NEAR(profile_at(p, 0.45).slope, -1.5, 1e-14);
    EXPECT_EQ(profile_at(p, 1.05).f, 0);
}

TEST(FieldSkeleton, DistanceIsTheLeastOverManyPointsOfTheSkeleton)
{
    const std::vector<Vec3> triangle{{-0.5, 0, 0}, {0.5, 0.1, 0}, {0, 0.2, 0.7}};
    const Vec3 axes(0.5, 0.2, 0.3);
    const Random random(3);
    for (std::uint64_t i = 0; i < 40; ++i) {
        const Vec3 p = in_cube(random, i, 1.0);
        double to_triangle = 1e9, to_ellipsoid = 1e9;
        constexpr int n = 300;
        for (int a = 0; a <= n; ++a) {
            for (int b = 0; b <= n; ++b) {
                const double u = a / double(n), v = b / double(n);
                if (a + b <= n) {
                    const Vec3 q = (1 - u - v) * triangle[0] + u * triangle[1] + v * triangle[2];
                    to_triangle = std::min(to_triangle, (p - q).norm());
                }
                const double theta = std::numbers::pi * u, phi = 2 * std::numbers::pi * v;
                const Vec3 q(axes.x() * std::sin(theta) * std::cos(phi),
                             axes.y() * std::sin(theta) * std::sin(phi),
                             axes.z() * std::cos(theta));
                to_ellipsoid = std::min(to_ellipsoid, (p - q).norm());
            }
        }
        // The samples lie at most about 0.005 apart; the distance is off by that squared over the
        // distance, or by that itself where p is near the surface.
        const Foot on_triangle = foot_on_triangle(std::span<const Vec3, 3>(triangle), p);
        EXPECT_NEAR(on_triangle.r, to_triangle, 5e-3);
        EXPECT_LE(on_triangle.r, to_triangle + 1e-12);
        const Foot on_ellipsoid = foot_on_ellipsoid(axes, p);
        EXPECT_NEAR(std::abs(on_ellipsoid.r), to_ellipsoid, 5e-3);
        EXPECT_LE(std::abs(on_ellipsoid.r), to_ellipsoid + 1e-12);
        EXPECT_EQ(on_ellipsoid.r > 0, p.cwiseQuotient(axes).squaredNorm() > 1);
    }
}

TEST(FieldSkeleton, TheEllipsoidIsRightOnItsAxesAndAtItsCentre)
{
    EXPECT_NEAR(foot_on_ellipsoid({1, 2, 3}, {0, 0, 0}).r, -1, 1e-15);
    EXPECT_NEAR(foot_on_ellipsoid({1, 1, 1}, {0, 0, 0}).r, -1, 1e-15);
    EXPECT_NEAR(foot_on_ellipsoid({1, 1, 1}, {0, 3, 0}).r, 2, 1e-14);
    EXPECT_NEAR(foot_on_ellipsoid({1, 2, 3}, {0, 0, 5}).r, 2, 1e-14);
    // On the long axis, inside the evolute (|x| < a - b^2/a): x = a cos, foot off the axis with
    // q_x = a^2 x / (a^2 - b^2).  a = 2, b = 1, x = 0.6: q = (0.8, sqrt(1 - 0.16)), r^2 = 0.04 +
    // 0.84.
    EXPECT_NEAR(foot_on_ellipsoid({2, 1, 1}, {0.6, 0, 0}).r, -std::sqrt(0.88), 1e-14);
    EXPECT_NEAR(foot_on_ellipsoid({2, 1, 3}, {0.6, 1e-18, 0}).r, -std::sqrt(0.88), 1e-14);
}

TEST(FieldSkeleton, AMeshOfABoxIsTheBox)
{
    const SkeletonMesh mesh(box_mesh({0.25f, 0.5f, 0.125f}));
    const Random random(37);
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3 p = in_cube(random, i, 0.8);
        const Foot a = foot_on_mesh(mesh, p), b = foot_on_box({0.25, 0.5, 0.125}, p);
        EXPECT_NEAR(a.r, b.r, 1e-7);  // the tree works on floats
        EXPECT_LT((a.n - b.n).norm(), 1e-5);
        EXPECT_LT((a.hessian - b.hessian).norm(), 1e-4 * (1 + b.hessian.norm()));
    }
}

TEST(FieldSkeleton, GradientAndHessianAreTheDerivativesOfTheDistance)
{
    // h^2 times third derivatives of at most 1/r^2 = 400 (ellipsoids inside: more curved).
    field_checks::expect_derivatives(make_field(layer_of(one_of_each()), at_rest),
                                     {5, 1.2, 0.1, 1e-4});
    field_checks::expect_derivatives(
        make_field(layer_of(field_checks::stretched(one_of_each())), at_rest), {5, 1.2, 0.1, 1e-4});
}

TEST(FieldSkeleton, AStretchedOneIsAsFarAsItsLeastPointInNarrowedSpace)
{
    // Against many points of the skeleton, in a frame that turns.
    const Transform frame = turned(0.9, {1, 1, -2}, {0.3, 0, -0.2});
    std::vector<Skeleton> each = field_checks::stretched(one_of_each());
    each.resize(4);  // those drawn by points
    const Field field = make_field(layer_of(each), std::vector{frame});
    const Random random(23);
    for (std::size_t s = 0; s < each.size(); ++s) {
        const std::vector<Vec3>& points = each[s].points;
        const Mat3 narrow = frame.linear() * each[s].stretch.inverse() * frame.linear().transpose();
        for (std::uint64_t i = 0; i < 20; ++i) {
            const Vec3 p = in_cube(random, i, 1.0);
            double least = 1e9;
            const auto to = [&](const Vec3& q) {
                least = std::min(least, (narrow * (p - frame * q)).norm());
            };
            for (std::size_t k = 0; k < points.size(); ++k) {
                const Vec3 &a = points[k], &b = points[std::min(k + 1, points.size() - 1)];
                for (double u = 0; u <= 1; u += 1.0 / 256) {
                    to(a + u * (b - a));
                    for (double v = 0; points.size() == 3 && s == 3 && u + v <= 1; v += 1.0 / 256) {
                        to(points[0] + u * (points[1] - points[0]) + v * (points[2] - points[0]));
                    }
                }
            }
            EXPECT_NEAR(foot(field, s, p).r, least, 1e-4) << "skeleton " << s;
            EXPECT_LE(foot(field, s, p).r, least + 1e-13);
            EXPECT_EQ(distance(field, s, p), foot(field, s, p).r);
        }
    }
}

TEST(Field, AStretchedPointsSurfaceIsItsEllipsoid)
{
    // Semi-axes 0.3, 0.6 and 0.45, turned by its frame; and nothing of it beyond its influence.
    Skeleton ball = points_skeleton(SkeletonKind::point, {{0.1, 0.2, -0.1}});
    ball.stretch = Vec3(1, 2, 1.5).asDiagonal();
    const Transform frame = turned(0.9, {1, 1, -2}, {0.3, 0, -0.2});
    const Field field = make_field(layer_of({ball}), std::vector{frame});
    const Random random(29);
    Vec3 most = Vec3::Zero();
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const Vec3 out = ball.stretch * in_cube(random, i, 1).normalized();
        const auto at = [&](double r) { return Vec3(frame * (ball.points[0] + r * out)); };
        EXPECT_NEAR(value_at(field, at(0.3)).f, 1, 1e-14);
        EXPECT_NEAR(surface_slope(field, 0, at(0.3)), value_at(field, at(0.3)).gradient.norm(),
                    1e-13);
        EXPECT_EQ(value_at(field, at(0.9 + 1e-12)).f, 0);
        EXPECT_GT(value_at(field, at(0.899)).f, 0);
        most = most.cwiseMax((at(0.9) - frame * ball.points[0]).cwiseAbs());
    }
    const Vec3 half = 0.5 * (influence(field).hi - influence(field).lo);
    EXPECT_TRUE((half.array() >= most.array()).all());
    EXPECT_LT((half - most).norm(), 0.02);
}

TEST(FieldSkeleton, DegenerateSkeletonsEqualWhatTheyCollapseTo)
{
    const Vec3 p(0.3, 0.4, 1.2);
    const std::vector<Vec3> dot(3, Vec3::Zero());
    EXPECT_NEAR(foot_on_polyline(dot, p).r, 1.3, 1e-15);
    EXPECT_NEAR(foot_on_triangle(std::span<const Vec3, 3>(dot), p).r, 1.3, 1e-15);
    const std::vector<Vec3> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    EXPECT_NEAR(foot_on_triangle(std::span<const Vec3, 3>(line), {1.5, 0, 2}).r, 2, 1e-15);
    EXPECT_EQ(foot_on_polyline(dot, {0, 0, 0}).n, Vec3::Zero());
}

TEST(Field, GradientIsTheDerivativeUnderEveryBlend)
{
    for (const auto& [rule, skeletons] : every_rule()) {
        ImplicitLayer layer = layer_of(skeletons, rule);
        if (rule != BlendRule::sum) {
            layer.blend.part = {0, 0, 1, 2, 3, 3, 5, 4};
            layer.blend.links = {{0, 2, 1}, {1, 2, 0.5}, {2, 3, 0.7}, {4, 1, 1}, {6, 0, 0.2}};
        }
        const Field field = make_field(layer, at_rest);
        const Random random(11);
        const double h = 1e-6;
        int checked = 0;
        for (std::uint64_t i = 0; i < 300; ++i) {
            const Vec3 p = in_cube(random, i, 1.0);
            const FieldValue at = value_at(field, p);
            Vec3 central, one_sided;
            for (int axis = 0; axis < 3; ++axis) {
                const double a = value_at(field, p - h * Vec3::Unit(axis)).f;
                const double b = value_at(field, p + h * Vec3::Unit(axis)).f;
                central[axis] = (b - a) / (2 * h);
                one_sided[axis] = (b - at.f) / h;
            }
            if ((central - one_sided).norm() > 1e-3) continue;  // on a crease, or f'' jumps
            ++checked;
            EXPECT_LT((central - at.gradient).norm(), 2e-4 * (1 + central.norm()))
                << "rule " << int(rule) << " at " << p.transpose();
        }
        EXPECT_GT(checked, 250);
    }
}

TEST(Field, BlocksGridAndVectorsGiveWhatEverySkeletonAskedGives)
{
    for (const auto& [rule, skeletons] : every_rule()) {
        ImplicitLayer layer = crowd(150, 1.0, 0.5);
        for (const Skeleton& s : skeletons) {
            layer.skeletons.push_back(s);
            layer.contributions.push_back(soft);
            layer.frame.push_back(0);
        }
        layer.blend.rule = rule;
        for (std::uint32_t i = 0; i < layer.skeletons.size(); ++i) {
            layer.blend.part.push_back(i / 20);
            if (i + 20 < layer.skeletons.size()) {
                layer.blend.links.push_back({i, i + 20, i % 4 * 0.25});
            }
        }
        const Field field = make_field(layer, at_rest);
        const Random random(13);
        std::vector<Vec3> points;  // scattered: counted into the grid
        for (std::uint64_t i = 0; i < 600; ++i) points.push_back(in_cube(random, i, 2.0));
        std::vector<double> f(points.size());
        std::vector<Vec3> gradient(points.size());
        evaluate(field, points, f, gradient);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Blended expected = brute_force(layer, field, points[i]);
            // Rounding of sums of up to 30 terms of size 1; 1/beta amplifies it where beta is
            // small.
            EXPECT_NEAR(f[i], expected.f, 1e-12 * (1 + expected.f));
            EXPECT_LT((gradient[i] - expected.gradient).norm(),
                      1e-9 * (1 + expected.gradient.norm()));
            EXPECT_NEAR(value_at(field, points[i]).f, expected.f, 1e-12 * (1 + expected.f));
        }
        std::vector<double> near_f(64);
        evaluate(field, std::span(points).first(64), near_f);  // one block, no sorting
        for (std::size_t i = 0; i < 64; ++i) EXPECT_NEAR(near_f[i], f[i], 1e-12 * (1 + f[i]));
    }
}

TEST(Field, TheSameBitsForAnyNumberOfThreads)
{
    const Field field = make_field(crowd(300, 1.0, 0.3), at_rest);
    const Random random(17);
    std::vector<Vec3> points;
    for (std::uint64_t i = 0; i < 20000; ++i) points.push_back(in_cube(random, i, 1.2));
    std::vector<std::vector<double>> results;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        std::vector<double> f(points.size());
        evaluate(field, points, f);
        results.push_back(f);
    }
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
}

TEST(Field, BoundsHoldEveryValueAndSlopeInTheBox)
{
    for (const auto& [rule, skeletons] : every_rule()) {
        ImplicitLayer layer = layer_of(skeletons, rule);
        layer.blend.links = {{0, 2, 1}, {1, 2, 0.5}, {2, 3, 0.7}, {4, 1, 1}, {6, 0, 0.2}};
        const Field field = make_field(layer, at_rest);
        const Random random(19);
        std::vector<std::uint32_t> near;
        for (std::uint64_t i = 0; i < 50; ++i) {
            Box box;
            box.add(in_cube(random, 1000 + i, 1.0));
            box.add(box.lo + Vec3::Constant(0.3));
            candidates(field, box, near);
            const Interval range = bounds(field, near, box);
            const double steepest = slope_bound(field, near, box);
            for (std::uint64_t j = 0; j < 50; ++j) {
                const Vec3 p = box.centre() + in_cube(random, 50 * i + j, 0.15);
                const FieldValue at = value_at(field, p);
                EXPECT_GE(at.f, range.lo - 1e-12);
                EXPECT_LE(at.f, range.hi + 1e-12);
                EXPECT_LE(at.gradient.norm(), steepest + 1e-12);
            }
        }
    }
}

TEST(Field, RidesOnItsFrames)
{
    const ImplicitLayer layer = layer_of(one_of_each());
    const Transform moved_frame = turned(1.1, {2, -1, 1}, {3, 4, 5});
    const Field rest = make_field(layer, at_rest);
    const Field moved_field = make_field(layer, std::vector{moved_frame});
    const Random random(23);
    for (std::uint64_t i = 0; i < 100; ++i) {
        const Vec3 p = in_cube(random, i, 1.0);
        const FieldValue a = value_at(rest, p), b = value_at(moved_field, moved_frame * p);
        EXPECT_NEAR(a.f, b.f, 1e-13);
        EXPECT_LT((moved_frame.linear() * a.gradient - b.gradient).norm(), 1e-11);
    }
}

TEST(Field, TerritoriesAreWhereOnesOwnContributionIsLargest)
{
    ImplicitLayer layer = layer_of(one_of_each(), BlendRule::largest_group);
    const Field field = make_field(layer, at_rest);
    const Random random(29);
    FieldBlock block;
    Box box;
    for (std::uint64_t i = 0; i < 100; ++i) {
        block.add(in_cube(random, i, 0.9));
        box.add(block.point(i));
    }
    block.pad();
    std::vector<std::uint32_t> near;
    candidates(field, box, near);
    FieldScratch scratch;
    TerritoryValues values;
    for (std::uint32_t owner = 0; owner < field.count(); ++owner) {
        evaluate(field, near, owner, block, scratch, values);
        for (std::size_t k = 0; k < block.count; ++k) {
            const FieldValue at = value_at(field, block.point(k));
            if (at.largest == owner)
                EXPECT_GE(values.own.f[k], values.rival.f[k]);
            else
                EXPECT_LE(values.own.f[k], values.rival.f[k]);
            EXPECT_NEAR(values.blend.f[k], at.f, 1e-13);
        }
    }
}

TEST(Field, EmptyFieldsAndNonFinitePointsAreOutside)
{
    const std::vector<Vec3> points{
        {0, 0, 0}, {std::nan(""), 0, 0}, {0, HUGE_VAL, 0}, {1e200, -1e200, 1e200}};
    std::vector<double> f(points.size(), 7);
    std::vector<Vec3> gradient(points.size());
    evaluate(make_field({}, {}), points, f, gradient);
    EXPECT_EQ(f, std::vector<double>(4, 0.0));
    std::vector<Skeleton> all = one_of_each();
    all.pop_back();  // half of space is inside the plane, however far
    const Field field = make_field(layer_of(all), at_rest);
    evaluate(field, points, f, gradient);
    EXPECT_GT(f[0], 1);
    for (std::size_t i = 1; i < 4; ++i) {
        EXPECT_EQ(f[i], 0);
        EXPECT_EQ(gradient[i], Vec3::Zero());
        EXPECT_EQ(value_at(field, points[i]).f, 0);
    }
    evaluate(field, {}, {});
    EXPECT_THROW(evaluate(field, points, std::span(f).first(2)), std::invalid_argument);
}

TEST(Field, ErrorsNameTheSkeletonAndTheReason)
{
    ImplicitLayer layer = layer_of(one_of_each());
    layer.contributions[3].radius = 0.1;
    try {
        make_field(layer, at_rest);
        FAIL();
    } catch (const std::invalid_argument& wrong) {
        EXPECT_NE(std::string(wrong.what()).find("skeleton 3"), std::string::npos);
        EXPECT_NE(std::string(wrong.what()).find("radius"), std::string::npos);
    }
    layer = layer_of(one_of_each());
    layer.frame[2] = 1;
    EXPECT_THROW(make_field(layer, at_rest), std::invalid_argument);
    layer = layer_of(one_of_each());
    layer.skeletons[1].points.pop_back();
    EXPECT_THROW(make_field(layer, at_rest), std::invalid_argument);
    layer = layer_of(one_of_each());
    layer.skeletons[4].place.linear() *= 2;
    EXPECT_THROW(make_field(layer, at_rest), std::invalid_argument);
    layer = layer_of(one_of_each());
    layer.blend.links = {{0, 9, 1}};
    EXPECT_THROW(make_field(layer, at_rest), std::invalid_argument);
    layer.blend.links = {{0, 1, 2}};
    EXPECT_THROW(make_field(layer, at_rest), std::invalid_argument);
    layer.blend.links = {{0, 1, 1}, {1, 0, 1}};
    EXPECT_THROW(make_field(layer, at_rest), std::invalid_argument);
}

// Three in a chain, 0 - 1 - 2: the ends do not blend with each other.
TEST(Blend, SkeletonsThatDoNotBlendAreNeverSummed)
{
    Blend chain;
    chain.links = {{0, 1, 1}, {1, 2, 1}};
    const BlendWeights weights(chain, 3);
    const auto with = [&](BlendRule rule, double f0, double f1, double f2) {
        std::vector<Contributor> contributors;
        const double f[] = {f0, f1, f2};
        for (std::uint32_t i = 0; i < 3; ++i) {
            if (f[i] > 0) contributors.push_back({i, f[i], Vec3(1, 0, 0)});
        }
        return blend(rule, weights, contributors).f;
    };
    for (const BlendRule rule : {BlendRule::largest_group, BlendRule::smooth_groups}) {
        EXPECT_DOUBLE_EQ(with(rule, 0.5, 0.4, 0), 0.9);
        EXPECT_DOUBLE_EQ(with(rule, 0, 0.4, 0.3), 0.7);
        EXPECT_DOUBLE_EQ(with(rule, 0.5, 0, 0.3), 0.5);  // an arm beside a hip
        EXPECT_DOUBLE_EQ(with(rule, 0, 0, 0), 0);
    }
    EXPECT_DOUBLE_EQ(with(BlendRule::largest_group, 0.5, 0.1, 0.3), 0.6);
    // beta = (f0 f1 + f1 f2) / (f0 f1 + f1 f2 + f0 f2) = 0.08 / 0.23.
    const double beta = 0.08 / 0.23;
    EXPECT_NEAR(
        with(BlendRule::smooth_groups, 0.5, 0.1, 0.3),
        std::pow(std::pow(0.5, 1 / beta) + std::pow(0.1, 1 / beta) + std::pow(0.3, 1 / beta), beta),
        1e-15);
}

TEST(Blend, TheLargestGroupIsTheBestOfAllSubsets)
{
    const Random random(31);
    for (std::uint64_t round = 0; round < 30; ++round) {
        constexpr std::uint32_t n = 9;
        Blend graph;
        std::uint64_t draw = round * 1000;
        for (std::uint32_t i = 0; i < n; ++i) {
            for (std::uint32_t j = i + 1; j < n; ++j) {
                if (random.unit(draw++) < 0.5) graph.links.push_back({i, j, 1});
            }
        }
        const BlendWeights weights(graph, n);
        std::vector<Contributor> contributors;
        for (std::uint32_t i = 0; i < n; ++i) {
            contributors.push_back({i, random.unit(draw++), Vec3::Zero()});
        }
        const std::vector<Contributor> given = contributors;
        double best = 0;
        for (unsigned subset = 0; subset < 1u << n; ++subset) {
            double sum = 0;
            bool clique = true;
            for (std::uint32_t i = 0; i < n; ++i) {
                if (!(subset >> i & 1)) continue;
                sum += given[i].f;
                for (std::uint32_t j = 0; j < i; ++j) {
                    clique &= !(subset >> j & 1) || weights(i, j) > 0;
                }
            }
            if (clique) best = std::max(best, sum);
        }
        EXPECT_NEAR(blend(BlendRule::largest_group, weights, contributors).f, best, 1e-14);
    }
}

// Across the plane where the largest group changes, the paper's blend turns its gradient by a
// finite angle; the smooth one's one-sided gradients agree.
TEST(Blend, SmoothGroupsHaveNoCrease)
{
    ImplicitLayer layer = layer_of({points_skeleton(SkeletonKind::point, {{-0.4, 0, 0}}),
                                    points_skeleton(SkeletonKind::point, {{0, -0.3, 0}}),
                                    points_skeleton(SkeletonKind::point, {{0.4, 0, 0}})});
    layer.blend.links = {{0, 1, 1}, {1, 2, 1}};
    const auto jump = [&](BlendRule rule) {
        layer.blend.rule = rule;
        const Field field = make_field(layer, at_rest);
        return (value_at(field, {1e-9, 0.1, 0}).gradient -
                value_at(field, {-1e-9, 0.1, 0}).gradient)
            .norm();
    };
    EXPECT_GT(jump(BlendRule::largest_group), 0.5);
    EXPECT_LT(jump(BlendRule::smooth_groups), 1e-6);
}

// Two segments end to end in a line: a plain sum swells the joint, the gradient blend does not; two
// spheres that face each other blend at a distance under the sum, not under the gradient blend.
TEST(Blend, ByGradientNeitherBulgesNorBlendsAtADistance)
{
    ImplicitLayer layer =
        layer_of({points_skeleton(SkeletonKind::segment, {{-1, 0, 0}, {0.1, 0, 0}}),
                  points_skeleton(SkeletonKind::segment, {{-0.1, 0, 0}, {1, 0, 0}})});
    layer.blend.links = {{0, 1, 1}};
    const Vec3 beside_joint(0, soft.thickness, 0);  // on the surface of either alone
    EXPECT_NEAR(value_at(make_field(layer, at_rest), beside_joint).f, 2, 1e-12);
    layer.blend.rule = BlendRule::gradient;
    EXPECT_NEAR(value_at(make_field(layer, at_rest), beside_joint).f, 1, 1e-12);

    layer.skeletons = {points_skeleton(SkeletonKind::point, {{-0.35, 0, 0}}),
                       points_skeleton(SkeletonKind::point, {{0.35, 0, 0}})};
    EXPECT_LT(value_at(make_field(layer, at_rest), {0, 0, 0}).f, 1);  // a gap of 0.1 stays open
    layer.blend.rule = BlendRule::sum;
    EXPECT_GT(value_at(make_field(layer, at_rest), {0, 0, 0}).f, 1);
}

}  // namespace geometry
