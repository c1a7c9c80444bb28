#include "geometry/base/random.hpp"
#include "geometry/fields/curve_skeleton.hpp"
#include "geometry/fields/evaluate_points.hpp"
#include "geometry/fields/field.hpp"
#include "geometry/fields/polygonize.hpp"
#include "geometry/fields/round_skeleton.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/fields/field_checks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace geometry::skeleton_kinds_test {
namespace {

constexpr double pi = std::numbers::pi;
const std::vector<Transform> unmoved{Transform::Identity()};
const std::vector<Vec3> bent{
    {-0.6, 0, 0.1}, {-0.2, 0.5, 0}, {-0.1, 0.45, 0.05}, {0.4, -0.2, 0.4}, {0.6, 0.3, 0.1}};

using field_checks::in_cube;

Skeleton placed(SkeletonKind kind, const Vec3& half_size)
{
    Skeleton s{.kind = kind, .points = {}, .half_size = half_size};
    s.place.translate(Vec3(0.1, -0.05, 0.02))
        .rotate(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()));
    return s;
}

// Two triangles that meet at a right angle, in the air.
std::shared_ptr<const SkeletonMesh> bent_sheet()
{
    TriMesh mesh;
    mesh.positions = {{-0.4f, 0, -0.4f}, {0.4f, 0, -0.4f}, {-0.4f, 0, 0.4f}, {0.4f, 0.6f, -0.4f}};
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 2, 1}, {1, 2, 3}};
    mesh.topology = topology;
    return std::make_shared<const SkeletonMesh>(mesh);
}

std::vector<Skeleton> one_of_each()
{
    Skeleton sheet = placed(SkeletonKind::sheet, {1, 1, 1});
    sheet.mesh = bent_sheet();
    return {{.kind = SkeletonKind::curve, .points = bent},
            {.kind = SkeletonKind::curve,
             .points = {{0.5, 0, 0}, {0, 0.3, 0.4}, {-0.4, 0, 0}, {0, -0.3, -0.3}, {0.5, 0, 0}}},
            placed(SkeletonKind::torus, {0.6, 0.15, 1}),
            placed(SkeletonKind::torus, {0.5, 0, 1}),
            placed(SkeletonKind::cylinder, {0.3, 0.5, 1}),
            placed(SkeletonKind::cone, {0.5, 0.4, 0.2}),
            placed(SkeletonKind::cone, {0.4, 0.5, 0}),
            placed(SkeletonKind::cone, {0.1, 0.3, 0.4}),
            sheet};
}

const Contribution soft{.thickness = 0.2, .stiffness = 3, .radius = 0.6, .stiffening = 0.5};

ImplicitLayer layer_of(std::vector<Skeleton> skeletons, const Contribution& contribution = soft)
{
    ImplicitLayer layer;
    layer.skeletons = std::move(skeletons);
    layer.contributions.assign(layer.skeletons.size(), contribution);
    layer.frame.assign(layer.skeletons.size(), 0);
    return layer;
}

// The centripetal curve between p1 and p2 by Barry and Goldman's pyramid of straight mixtures.
Vec3 pyramid(const std::array<Vec3, 4>& p, double u)
{
    std::array<double, 4> s{};
    for (std::size_t i = 1; i < 4; ++i) s[i] = s[i - 1] + std::sqrt((p[i] - p[i - 1]).norm());
    const double at = s[1] + u * (s[2] - s[1]);
    std::array<Vec3, 4> q = p;
    for (std::size_t level = 1; level < 4; ++level) {
        for (std::size_t i = 0; i + level < 4; ++i) {
            // The last level mixes over the middle span alone.
            const double from = level == 3 ? s[1] : s[i];
            const double to = level == 3 ? s[2] : level == 2 ? s[i + 2] : s[i + 1];
            q[i] = ((to - at) * q[i] + (at - from) * q[i + 1]) / (to - from);
        }
    }
    return q[0];
}

// The least distance to a solid's surface, over a fine net of its points in the half plane.
double net_distance(SkeletonKind kind, const RoundShape& shape, double rho, double y)
{
    double least = 1e9;
    const auto to = [&](double a, double b) {
        least = std::min(least, std::hypot(rho - a, y - b));
    };
    constexpr int n = 4000;
    for (int i = 0; i <= n; ++i) {
        const double u = double(i) / n;
        if (kind == SkeletonKind::torus) {
            to(shape.ring + shape.tube * std::cos(2 * pi * u), shape.tube * std::sin(2 * pi * u));
            continue;
        }
        to(u * shape.base, -shape.height);
        to(u * shape.top, shape.height);
        to((1 - u) * shape.base + u * shape.top, (2 * u - 1) * shape.height);
    }
    return least;
}

bool within(SkeletonKind kind, const RoundShape& shape, double rho, double y)
{
    if (kind == SkeletonKind::torus) return std::hypot(rho - shape.ring, y) < shape.tube;
    const double up = (y / shape.height + 1) / 2;
    return std::abs(y) < shape.height && rho < (1 - up) * shape.base + up * shape.top;
}

}  // namespace

TEST(CurveSkeleton, IsTheCentripetalCatmullRomCurveThroughItsPositions)
{
    const std::vector<Vec3> bezier = catmull_rom(bent);
    ASSERT_EQ(bezier.size(), 3 * (bent.size() - 1) + 1);
    for (std::size_t i = 0; i < bent.size(); ++i) EXPECT_EQ(bezier[3 * i], bent[i]);
    for (std::size_t i = 1; i + 2 < bent.size(); ++i) {
        const CurveSpan span = curve_span(bezier, i);
        for (double u = 0; u <= 1; u += 0.05) {
            const Vec3 q = pyramid({bent[i - 1], bent[i], bent[i + 1], bent[i + 2]}, u);
            EXPECT_LT((span.at(u) - q).norm(), 1e-14);
        }
    }
}

TEST(CurveSkeleton, DistanceIsTheLeastOverManyPointsOfTheCurve)
{
    const std::vector<Vec3> bezier = catmull_rom(bent);
    const Random random(3);
    for (std::uint64_t i = 0; i < 60; ++i) {
        const Vec3 p = in_cube(random, i, 1.0);
        double least = 1e9;
        for (std::size_t s = 0; s < curve_span_count(bezier); ++s) {
            const CurveSpan span = curve_span(bezier, s);
            for (int k = 0; k <= 4000; ++k) {
                least = std::min(least, (span.at(k / 4000.0) - p).norm());
            }
        }
        // Points 2e-4 apart at most: off by (1e-4)^2 / 2r; r is 0.01 or more here.
        const Foot foot = foot_on_curve(bezier, p);
        EXPECT_LE(foot.r, least + 1e-12);
        EXPECT_NEAR(foot.r, least, 1e-6);
    }
}

TEST(CurveSkeleton, StraightAndDegenerateCurvesAreSegmentsAndPoints)
{
    const Vec3 p(0.3, 0.4, 1.2);
    EXPECT_NEAR(foot_on_curve(catmull_rom(std::vector<Vec3>(3, Vec3::Zero())), p).r, 1.3, 1e-15);
    const std::vector<Vec3> line{{0, 0, 0}, {0, 0, 0}, {0.2, 0, 0}, {1, 0, 0}};
    const std::vector<Vec3> ends{{0, 0, 0}, {1, 0, 0}};
    for (const Vec3& q : {p, Vec3(-0.5, 0.2, 0.1), Vec3(1.5, 0, 0), Vec3(0.7, 0.1, 0)}) {
        const Foot a = foot_on_curve(catmull_rom(line), q), b = foot_on_polyline(ends, q);
        EXPECT_NEAR(a.r, b.r, 1e-12);
        EXPECT_LT((a.n - b.n).norm(), 1e-7);
    }
}

// Through four points of a circle and back to the first: equal knots, so that each span is the same
// arc, and the curve has one slope at its end and start.
TEST(CurveSkeleton, ThatEndsWhereItStartsClosesSmoothly)
{
    const std::vector<Vec3> square{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 0, 0}};
    const std::vector<Vec3> bezier = catmull_rom(square);
    const CurveSpan first = curve_span(bezier, 0), last = curve_span(bezier, 3);
    EXPECT_LT((first.slope(0) - last.slope(1)).norm(), 1e-14);
    EXPECT_NEAR(first.at(0.5).norm(), last.at(0.5).norm(), 1e-14);
    EXPECT_NEAR(foot_on_curve(bezier, {1, 0, 0.5}).r, 0.5, 1e-12);
}

TEST(RoundSkeleton, DistanceIsTheLeastOverManyPointsOfTheSurface)
{
    const std::vector<std::pair<SkeletonKind, Vec3>> cases{
        {SkeletonKind::torus, {0.6, 0.2, 1}},   {SkeletonKind::cylinder, {0.3, 0.5, 1}},
        {SkeletonKind::cone, {0.5, 0.4, 0.2}},  {SkeletonKind::cone, {0.4, 0.5, 0}},
        {SkeletonKind::cone, {0.1, 0.3, 0.45}},
    };
    const Random random(5);
    for (const auto& [kind, half] : cases) {
        const RoundShape shape = round_shape(kind, half);
        for (std::uint64_t i = 0; i < 200; ++i) {
            const Vec3 p = in_cube(random, i, 0.9);
            const double rho = std::hypot(p.x(), p.z());
            const Foot foot =
                kind == SkeletonKind::torus ? foot_on_torus(shape, p) : foot_on_cone(shape, p);
            const double net = net_distance(kind, shape, rho, p.y());
            EXPECT_LE(std::abs(foot.r), net + 1e-12);
            EXPECT_NEAR(std::abs(foot.r), net, 2e-4);  // half a step of the net
            EXPECT_EQ(foot.r < 0, within(kind, shape, rho, p.y()));
        }
    }
}

TEST(SkeletonKinds, GradientAndHessianAreTheDerivativesOfTheDistance)
{
    field_checks::expect_derivatives(make_field(layer_of(one_of_each()), unmoved),
                                     {7, 1.0, 0.02, 1e-3});
    std::vector<Skeleton> curves = field_checks::stretched(one_of_each());
    curves.resize(2);
    field_checks::expect_derivatives(make_field(layer_of(curves), unmoved), {7, 1.0, 0.02, 1e-3});
}

TEST(SkeletonKinds, BlocksGiveWhatEachPointAskedByItselfGives)
{
    std::vector<Skeleton> each = one_of_each();
    for (const Skeleton& s : field_checks::stretched(one_of_each())) each.push_back(s);
    const Random random(11);
    std::vector<Vec3> points;
    for (std::uint64_t i = 0; i < 500; ++i) points.push_back(in_cube(random, i, 1.2));
    points.emplace_back(0.1, -0.05, 0.02);  // the middle of the solids, on their axes
    for (std::size_t s = 0; s < each.size(); ++s) {
        const Field field = make_field(layer_of({each[s]}), unmoved);
        std::vector<double> f(points.size());
        std::vector<Vec3> gradient(points.size());
        evaluate(field, points, f, gradient);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const FieldValue one = value_at(field, points[i]);
            EXPECT_NEAR(f[i], one.f, 1e-12) << "skeleton " << s;
            if (i + 1 < points.size()) {
                EXPECT_LT((gradient[i] - one.gradient).norm(), 1e-9) << "skeleton " << s;
            }
        }
    }
}

TEST(SkeletonKinds, BoundsHoldEveryValueInTheBox)
{
    for (const Skeleton& s : one_of_each()) {
        const Field field = make_field(layer_of({s}), unmoved);
        const Box reach = influence(field);
        const Random random(13);
        std::vector<std::uint32_t> near;
        for (std::uint64_t i = 0; i < 60; ++i) {
            Box box;
            box.add(in_cube(random, 1000 + i, 1.0));
            box.add(box.lo + Vec3::Constant(0.25));
            candidates(field, box, near);
            const Interval range = bounds(field, near, box);
            for (std::uint64_t j = 0; j < 60; ++j) {
                const Vec3 p = box.centre() + in_cube(random, 60 * i + j, 0.125);
                const double f = profile_at(field.profile[0], foot(field, 0, p).r).f;
                EXPECT_GE(f, range.lo - 1e-12);
                EXPECT_LE(f, range.hi + 1e-12);
                const bool out =
                    (p.array() < reach.lo.array()).any() || (p.array() > reach.hi.array()).any();
                if (out) {
                    EXPECT_EQ(f, 0);
                }
            }
        }
    }
}

// Steiner: 2 e A + pi/2 e^2 P + 4/3 pi e^3 about a flat sheet, the same on both sides.
TEST(SkeletonKinds, AnOpenSheetHasTwoSides)
{
    Skeleton sheet{.kind = SkeletonKind::sheet, .points = {}};
    sheet.mesh = std::make_shared<const SkeletonMesh>(grid(1.0, 0.5, 4, 4));
    const Field field = make_field(layer_of({sheet}), unmoved);
    const Random random(17);
    for (std::uint64_t i = 0; i < 100; ++i) {
        const Vec3 p = in_cube(random, i, 0.8);
        EXPECT_EQ(foot(field, 0, p).r, foot(field, 0, p.cwiseProduct(Vec3(1, -1, 1))).r);
    }
    const double e = soft.thickness;
    const double volume = 2 * e * 0.5 + pi / 2 * e * e * 3 + 4 * pi / 3 * e * e * e;
    EXPECT_NEAR(enclosed_volume(polygonize(iso_field(field), 0.02)), volume, 2e-3 * volume);
}

TEST(SkeletonKinds, TheSurfaceHasTheVolumeOfTheOffset)
{
    const double e = 0.1;
    const Contribution layer{.thickness = e, .stiffness = 10, .radius = 0.3};
    const auto volume = [&](const Skeleton& s) {
        return enclosed_volume(
            polygonize(iso_field(make_field(layer_of({s}, layer), unmoved)), 0.01));
    };
    // Pappus.
    const double torus = 2 * pi * pi * 0.45 * 0.25 * 0.25;
    EXPECT_NEAR(volume(placed(SkeletonKind::torus, {0.6, 0.15, 1})), torus, 3e-3 * torus);
    // Steiner, with the mean width of a disc and a line.
    const double a = 0.3, h = 1.0;
    const double cylinder = pi * a * a * h + 2 * pi * a * (a + h) * e + pi * (h + pi * a) * e * e +
                            4 * pi / 3 * e * e * e;
    EXPECT_NEAR(volume(placed(SkeletonKind::cylinder, {a, h / 2, 1})), cylinder, 3e-3 * cylinder);
    // A tube of the length of the curve, with two half balls.
    const std::vector<Vec3> arc{{-0.5, 0, 0}, {-0.2, 0.2, 0}, {0.2, 0.2, 0}, {0.5, 0, 0.1}};
    const std::vector<Vec3> bezier = catmull_rom(arc);
    double length = 0;
    for (std::size_t s = 0; s < curve_span_count(bezier); ++s) {
        const CurveSpan span = curve_span(bezier, s);
        for (int i = 0; i < 1000; ++i) length += span.slope((i + 0.5) / 1000).norm() / 1000;
    }
    const double tube = pi * e * e * length + 4 * pi / 3 * e * e * e;
    EXPECT_NEAR(volume({.kind = SkeletonKind::curve, .points = arc}), tube, 5e-3 * tube);
}

TEST(SkeletonKinds, SizesThatMakeNoSolidThrow)
{
    const auto wrong = [](SkeletonKind kind, const Vec3& half) {
        EXPECT_THROW(check(placed(kind, half)), std::invalid_argument);
    };
    wrong(SkeletonKind::torus, {0.5, 0.3, 1});  // its tube would pass through itself
    wrong(SkeletonKind::torus, {0, 0, 1});
    wrong(SkeletonKind::cylinder, {0, 1, 1});
    wrong(SkeletonKind::cone, {1, 0, 1});
    wrong(SkeletonKind::cone, {1, 1, -1});
    wrong(SkeletonKind::sheet, {1, 1, 1});  // no mesh
    EXPECT_THROW(check({.kind = SkeletonKind::curve, .points = {{0, 0, 0}}}),
                 std::invalid_argument);
}

}  // namespace geometry::skeleton_kinds_test
