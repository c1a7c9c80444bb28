#include "geometry/mesh/triangle_bvh.hpp"

#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <numbers>

namespace {

using geometry::Random;
using geometry::TriangleBvh;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;

Vec3 random_point(const Random& random, std::uint64_t i, double half)
{
    return half * Vec3(2 * random.unit(3 * i) - 1, 2 * random.unit(3 * i + 1) - 1,
                       2 * random.unit(3 * i + 2) - 1);
}

// Distance to a triangle another way: the nearest of the plane's point where that lies inside (by
// the three side planes), and of the three sides.
double triangle_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const auto segment = [&](const Vec3& u, const Vec3& v) {
        const Vec3 d = v - u;
        const double t =
            d.squaredNorm() > 0 ? std::clamp((p - u).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
        return (u + t * d - p).norm();
    };
    double best = std::min({segment(a, b), segment(b, c), segment(c, a)});
    const Vec3 n = (b - a).cross(c - a);
    if (n.norm() > 1e-12 * (b - a).norm() * (c - a).norm()) {
        const bool inside = n.cross(b - a).dot(p - a) >= 0 && n.cross(c - b).dot(p - b) >= 0 &&
                            n.cross(a - c).dot(p - c) >= 0;
        if (inside) best = std::min(best, std::abs((p - a).dot(n)) / n.norm());
    }
    return best;
}

double brute_distance(const TriMesh& mesh, const Vec3& p)
{
    double best = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : mesh.triangles()) {
        best = std::min(best, triangle_distance(p, mesh.positions[a].cast<double>(),
                                                mesh.positions[b].cast<double>(),
                                                mesh.positions[c].cast<double>()));
    }
    return best;
}

TEST(TriangleBvh, FindsTheDistanceThatEveryTriangleTogetherGives)
{
    for (const double size : {0.05, 1.0, 30.0}) {
        const TriMesh mesh = test_meshes::random_soup(300, 7, size);
        const TriangleBvh bvh(mesh);
        const Random random(3);
        for (std::uint64_t i = 0; i < 300; ++i) {
            const Vec3 p = random_point(random, i, 2 * size);
            const auto hit = bvh.closest(p);
            // Both compute in double from the same floats: n eps times the mesh's size.
            EXPECT_NEAR(hit.distance, brute_distance(mesh, p), 1e-12 * (1 + size));
            EXPECT_NEAR((hit.point - p).norm(), hit.distance, 1e-12 * (1 + size));
        }
    }
}

TEST(TriangleBvh, FindsDistancesToSliversAndToTrianglesWithoutArea)
{
    TriMesh mesh = test_meshes::random_soup(200, 5);
    for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
        const Vec3f a = mesh.positions[i], b = mesh.positions[i + 1];
        if (i % 4 == 0) mesh.positions[i + 2] = 0.5f * (a + b);             // a needle
        if (i % 4 == 1) mesh.positions[i + 2] = a + 1e-6f * (b - a);        // a cap
        if (i % 4 == 2) mesh.positions[i + 1] = mesh.positions[i + 2] = a;  // a point
    }
    const TriangleBvh bvh(mesh);
    const Random random(4);
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3 p = random_point(random, i, 1.5);
        // A needle is flat within rounding of its float corners: 1e-7 of its length.
        EXPECT_NEAR(bvh.closest(p).distance, brute_distance(mesh, p), 1e-7);
    }
}

TEST(TriangleBvh, ASegmentEntersWhereTheFirstOfAllTrianglesIsCrossedFromItsFront)
{
    const TriMesh mesh = test_meshes::icosphere(3);
    const TriangleBvh bvh(mesh);
    const Random random(4);
    int entries = 0;
    for (std::uint64_t i = 0; i < 500; ++i) {
        const Vec3 from = random_point(random, 2 * i, 1.5),
                   to = random_point(random, 2 * i + 1, 1.5);
        double first = 2;  // by the signs of the volumes that the segment has with the sides
        for (const auto& [ia, ib, ic] : mesh.triangles()) {
            const Vec3 a = mesh.positions[ia].cast<double>(), b = mesh.positions[ib].cast<double>(),
                       c = mesh.positions[ic].cast<double>();
            const auto volume = [](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
                return (q - p).cross(r - p).dot(s - p);
            };
            const double above = volume(a, b, c, from), below = volume(a, b, c, to);
            if (!(above >= 0 && below < 0)) continue;
            if (volume(from, to, a, b) > 0 || volume(from, to, b, c) > 0 ||
                volume(from, to, c, a) > 0)
                continue;
            first = std::min(first, above / (above - below));
        }
        const TriangleBvh::Hit hit = bvh.entry(from, to);
        ASSERT_EQ(bool(hit), first <= 1) << i;
        if (!hit) continue;
        ++entries;
        EXPECT_NEAR(hit.distance, first * (to - from).norm(), 1e-9);
        EXPECT_NEAR((hit.point - (from + first * (to - from))).norm(), 0, 1e-9);
        EXPECT_LT(hit.normal.dot(to - from), 0);
        EXPECT_NEAR(hit.point.norm(), 1, 0.02);
        EXPECT_FALSE(bvh.entry(to, from) && bvh.entry(to, from).normal == hit.normal);
    }
    EXPECT_GT(entries, 100);
    const double nan = std::nan("");
    EXPECT_FALSE(bvh.entry(Vec3(0, 2, 0), Vec3(0, nan, 0)));
    EXPECT_TRUE(bvh.entry(Vec3(0, 2, 0), Vec3(0, 0, 0))) << "through a corner";
    EXPECT_FALSE(TriangleBvh().entry(Vec3(0, 2, 0), Vec3(0, 0, 0)));
}

TEST(TriangleBvh, ASegmentMayEnterThroughEitherSide)
{
    const TriMesh grid = geometry::grid(2, 2, 4, 4);
    const TriangleBvh bvh(grid);
    const Vec3 above(0.1, 0.3, 0.2), below(0.3, -0.1, 0.1);
    const auto down = bvh.entry(above, below, TriangleBvh::Faces::both);
    const auto up = bvh.entry(below, above, TriangleBvh::Faces::both);
    ASSERT_TRUE(down && up);
    EXPECT_NEAR((down.point - up.point).norm(), 0, 1e-12);
    EXPECT_NEAR(down.normal.y(), 1, 1e-12);
    EXPECT_NEAR(up.normal.y(), -1, 1e-12);
    EXPECT_FALSE(bvh.entry(below, above));
    EXPECT_FALSE(bvh.entry(above, Vec3(0.3, 0.1, 0.1), TriangleBvh::Faces::both));
    // What starts on it is before its front.
    EXPECT_FALSE(bvh.entry(Vec3(0.1, 0, 0.1), above, TriangleBvh::Faces::both));
    EXPECT_TRUE(bvh.entry(Vec3(0.1, 0, 0.1), below, TriangleBvh::Faces::both));
}

// Seen from a mesh that shifts, a segment ends elsewhere: the mesh at rest and the segment less the
// shift give the same entry.
TEST(TriangleBvh, ASegmentEntersAMeshThatShifts)
{
    const Random random(9);
    const TriMesh after = geometry::icosphere(0.5, 2);
    TriMesh before = after;
    const Vec3f shift(0.4f, -0.3f, 0.2f);
    for (Vec3f& p : before.positions) p -= shift;
    const TriangleBvh bvh(after);
    const double begin = 0.25, end = 0.75;
    const TriangleBvh::Motion motion{
        before.positions,    after.positions, after.topology->triangles, begin, end,
        double(shift.norm())};
    int entries = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3 from = random_point(random, 2 * i, 1), to = random_point(random, 2 * i + 1, 1);
        const auto hit = bvh.entry(from, to, TriangleBvh::Faces::front, &motion);
        const auto same = bvh.entry(from + (1 - begin) * shift.cast<double>(),
                                    to + (1 - end) * shift.cast<double>());
        ASSERT_EQ(bool(hit), bool(same)) << i;
        if (!hit) continue;
        ++entries;
        EXPECT_NEAR((hit.point - same.point).norm(), 0, 1e-6);
        EXPECT_NEAR((motion.way(hit.triangle, hit.barycentric) - shift.cast<double>()).norm(), 0,
                    1e-6);
    }
    EXPECT_GT(entries, 50);
}

TEST(TriangleBvh, KeepsToTheLargestDistanceAsked)
{
    const TriangleBvh bvh(test_meshes::box({0, 0, 0}, {1, 1, 1}));
    EXPECT_FALSE(bvh.closest({2, 0.5, 0.5}, 0.999));
    EXPECT_TRUE(bvh.closest({2, 0.5, 0.5}, 1.001));
    EXPECT_FALSE(bvh.closest({2, 0.5, 0.5}, 0));
}

TEST(TriangleBvh, TellsTheSideOfAClosedMeshAtFacesSidesAndCorners)
{
    const TriangleBvh bvh(test_meshes::box({-1, -2, -3}, {1, 2, 3}));
    const Random random(9);
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const Vec3 p = random_point(random, i, 4);
        const Vec3 d = p.cwiseAbs() - Vec3(1, 2, 3);  // the box's distance function
        const double expected = d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
        EXPECT_NEAR(bvh.closest(p).signed_distance(), expected, 1e-12);
        EXPECT_EQ(bvh.inside(p), expected < 0);
    }
}

// Signed solid angle of a triangle over 4 pi by l'Huilier's formula for the spherical excess.
double solid_angle_share(const Vec3& a, const Vec3& b, const Vec3& c)
{
    const double sign = a.dot(b.cross(c)) < 0 ? -1 : 1;
    const auto arc = [](const Vec3& u, const Vec3& v) {
        return std::atan2(u.cross(v).norm(), u.dot(v));
    };
    const double x = arc(b, c), y = arc(c, a), z = arc(a, b), s = (x + y + z) / 2;
    const double t =
        std::tan(s / 2) * std::tan((s - x) / 2) * std::tan((s - y) / 2) * std::tan((s - z) / 2);
    return sign * std::atan(std::sqrt(std::max(t, 0.0))) / std::numbers::pi;
}

TEST(TriangleBvh, WindingNumberIsTheSumOfSolidAngles)
{
    // Open: a sphere with its cap cut off, where w is no whole number.
    const TriMesh mesh = test_meshes::bumpy_sphere(4);
    std::vector<geometry::Triangle> kept;
    for (const auto& t : mesh.triangles()) {
        if (mesh.positions[t[0]].y() < 0.4f) kept.push_back(t);
    }
    const TriangleBvh bvh(test_meshes::mesh_of(mesh.positions, kept));
    const Random random(2);
    for (std::uint64_t i = 0; i < 200; ++i) {
        const Vec3 p = random_point(random, i, 1.5);
        double expected = 0;
        for (const auto& [a, b, c] : kept) {
            expected += solid_angle_share(mesh.positions[a].cast<double>() - p,
                                          mesh.positions[b].cast<double>() - p,
                                          mesh.positions[c].cast<double>() - p);
        }
        // Two moments at three radii leave a third-order term: at most 6e-3 measured here.
        EXPECT_NEAR(bvh.winding_number(p), expected, 1e-2) << p.transpose();
    }
}

TEST(TriangleBvh, WindingNumberCountsCopiesAndPiecesAndTellsHoles)
{
    using test_meshes::box;
    const TriMesh outer = box({0, 0, 0}, {3, 3, 3}), inner = box({1, 1, 1}, {2, 2, 2});
    const TriangleBvh twice(test_meshes::both(outer, outer));
    EXPECT_NEAR(twice.winding_number({1.5, 1.5, 1.5}), 2, 1e-3);
    EXPECT_NEAR(twice.winding_number({-4, 1.5, 1.5}), 0, 5e-3);
    // Sixteen times around, either way, of triangles nearby alone.
    TriMesh many = inner;
    for (int i = 0; i < 4; ++i) many = test_meshes::both(many, many);
    EXPECT_NEAR(TriangleBvh(many).winding_number({1.4, 1.5, 1.6}), 16, 1e-9);
    std::vector<geometry::Triangle> inward;
    for (const auto& [a, b, c] : many.triangles()) inward.push_back({a, c, b});
    const TriangleBvh turned_over(test_meshes::mesh_of(many.positions, inward));
    EXPECT_NEAR(turned_over.winding_number({1.4, 1.5, 1.6}), -16, 1e-9);
    EXPECT_NEAR(turned_over.winding_number({1.4, 1.5, 2.01}), 0, 1e-9);
    TriMesh cavity = inner;
    std::vector<geometry::Triangle> turned;
    for (const auto& [a, b, c] : inner.triangles()) turned.push_back({a, c, b});
    const TriangleBvh hollow(
        test_meshes::both(outer, test_meshes::mesh_of(inner.positions, turned)));
    EXPECT_NEAR(hollow.winding_number({1.5, 1.5, 1.5}), 0, 1e-3);
    EXPECT_NEAR(hollow.winding_number({0.5, 1.5, 1.5}), 1, 1e-3);
}

// A sphere, in it a box named twice, and across its side a box whose faces look inward: -1 to 3
// times around.
TEST(TriangleBvh, CrossingsAreWhatTheWindingNumberGainsAlongASegment)
{
    using test_meshes::box, test_meshes::both;
    const TriMesh twice = box({0.2, 0.1, 0.3}, {0.7, 0.9, 0.8});
    const TriMesh inward = test_meshes::inside_out(box({-1.3, -0.2, -0.4}, {-0.6, 0.5, 0.2}));
    const TriangleBvh bvh(both(both(test_meshes::bumpy_sphere(3), inward), both(twice, twice)));
    const Random random(3);
    constexpr int count = 2000;
    int unclear = 0;
    std::array<int, 9> gains{};
    for (std::uint64_t i = 0; i < count; ++i) {
        const Vec3 from = random_point(random, 2 * i, 1.4);
        const Vec3 to = random_point(random, 2 * i + 1, 1.4);
        const auto gained = bvh.crossings(from, to);
        if (!gained) {
            ++unclear;
            continue;
        }
        EXPECT_NEAR(*gained, bvh.winding_number(to) - bvh.winding_number(from), 0.05);
        ++gains.at(static_cast<std::size_t>(4 + *gained));
    }
    EXPECT_LT(unclear, count / 500);
    for (const int gain : {-2, -1, 0, 1, 2}) {
        EXPECT_GE(gains.at(static_cast<std::size_t>(4 + gain)), 5) << gain;
    }
    // Through a side, an end on a face, along a face, and what is no segment.
    const TriangleBvh cube(box({0, 0, 0}, {1, 1, 1}));
    EXPECT_FALSE(cube.crossings({-1, -1, 0.4}, {0.5, 0.5, 0.4}));
    EXPECT_FALSE(cube.crossings({0.3, 0.6, 0.4}, {0.3, 0.6, 1}));
    EXPECT_FALSE(cube.crossings({0.3, 0.6, 1}, {0.7, 0.6, 1}));
    EXPECT_FALSE(cube.crossings({0.3, 0.6, std::numeric_limits<double>::quiet_NaN()}, {1, 2, 3}));
    EXPECT_EQ(cube.crossings({0.3, 0.6, 0.5}, {0.3, 0.6, 0.9}), 0);
    EXPECT_EQ(cube.crossings({0.3, 0.6, -0.5}, {0.3, 0.6, 0.9}), 1);
}

TEST(TriangleBvh, TakesWhateverComes)
{
    const TriangleBvh nothing{TriMesh{}};
    EXPECT_FALSE(nothing.closest({0, 0, 0}));
    EXPECT_EQ(nothing.winding_number({0, 0, 0}), 0);

    const float nan = std::numeric_limits<float>::quiet_NaN();
    const TriangleBvh broken(test_meshes::mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}},
                                                  {{0, 1, 3}, {0, 1, 9}, {0, 1, 2}}));
    EXPECT_EQ(broken.triangle_count(), 1u);
    EXPECT_EQ(broken.closest({0.2, 0.2, 1}).triangle, 2u);
    EXPECT_NEAR(broken.closest({0.2, 0.2, 1}).distance, 1, 1e-12);
    EXPECT_FALSE(broken.closest({std::nan(""), 0, 0}));

    TriMesh huge = test_meshes::random_soup(100, 1, 1e30);
    EXPECT_TRUE(std::isfinite(TriangleBvh(huge).closest({0, 0, 0}).distance));
    EXPECT_TRUE(std::isfinite(TriangleBvh(huge).winding_number({0, 0, 0})));
    const TriMesh same = test_meshes::mesh_of(std::vector<Vec3f>(3, {1, 1, 1}),
                                              std::vector<geometry::Triangle>(5000, {0, 1, 2}));
    EXPECT_NEAR(TriangleBvh(same).closest({0, 0, 0}).distance, std::sqrt(3.0), 1e-12);
}

TEST(TriangleBvh, GivesTheSameBitsOnAnyNumberOfThreads)
{
    const TriangleBvh bvh(test_meshes::bumpy_sphere(3));
    std::vector<Vec3> points;
    const Random random(1);
    for (std::uint64_t i = 0; i < 3000; ++i) points.push_back(random_point(random, i, 1.5));
    std::vector<TriangleBvh::Hit> reference;
    for (const unsigned threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        std::vector<TriangleBvh::Hit> hits(points.size());
        bvh.closest(points, 1.0, hits);
        if (reference.empty()) reference = hits;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            EXPECT_EQ(hits[i].distance, reference[i].distance);
            EXPECT_EQ(hits[i].triangle, reference[i].triangle);
        }
    }
}

}  // namespace
