#include "geometry/fields/iso_rays.hpp"

#include "geometry/fields/iso_extent.hpp"
#include "tests/geometry/fields/ray_march.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace geometry {
namespace {

using namespace ray_march;

constexpr double tolerance = 1e-9;
const std::vector<Transform> unmoved{Transform::Identity()};
const Contribution round_one{.thickness = 0.1, .stiffness = 10, .radius = 0.25};

ImplicitLayer layer_of(std::vector<Skeleton> skeletons,
                       const Contribution& contribution = round_one)
{
    ImplicitLayer layer;
    layer.skeletons = std::move(skeletons);
    layer.contributions.assign(layer.skeletons.size(), contribution);
    layer.frame.assign(layer.skeletons.size(), 0);
    return layer;
}

std::vector<RayHit> traced(const Field& field, std::span<const Ray> rays)
{
    const IsoField iso = iso_field(field);
    std::vector<RayHit> hits(rays.size());
    trace(iso, iso_cells(iso), rays, tolerance, hits);
    return hits;
}

// Points and segments in a heap, in three parts of which two blend.
Field heap(BlendRule rule, std::uint64_t seed)
{
    const Random random(seed);
    std::vector<Skeleton> skeletons;
    const auto place = [&](std::uint64_t i) {
        return Vec3(0.5 * random.unit(3 * i), 0.4 * random.unit(3 * i + 1),
                    0.5 * random.unit(3 * i + 2));
    };
    for (std::uint64_t i = 0; i < 9; ++i) {
        Skeleton s{.kind = SkeletonKind::point, .points = {place(2 * i)}};
        if (i % 3 == 0) {
            s.kind = SkeletonKind::segment;
            s.points.push_back(place(2 * i + 1));
        }
        skeletons.push_back(s);
    }
    ImplicitLayer layer =
        layer_of(skeletons, {.thickness = 0.05, .stiffness = 15, .radius = 0.14, .stiffening = 1});
    layer.blend.rule = rule;
    layer.blend.part = {0, 0, 0, 1, 1, 1, 2, 2, 2};
    for (std::uint32_t a = 0; a < 3; ++a) {
        for (std::uint32_t b = 3; b < 6; ++b) layer.blend.links.push_back({a, b, 0.6});
    }
    return make_field(layer, unmoved);
}

constexpr std::array rules{BlendRule::sum, BlendRule::largest_group, BlendRule::smooth_groups,
                           BlendRule::gradient};

}  // namespace

// A point skeleton alone is a sphere of its thickness: t = b - sqrt(b^2 - (q^2 - e^2)) with q the
// distance to the centre and b its part along the ray. Grazing rays too.
TEST(IsoRays, ASphereIsMetWhereItsEquationSays)
{
    const Vec3 centre(0.3, -0.2, 0.1);
    const Field field =
        make_field(layer_of({{.kind = SkeletonKind::point, .points = {centre}}}), unmoved);
    std::vector<Ray> rays;
    for (int i = 0; i < 400; ++i) {
        const double beside = 0.1 * (1 - std::pow(0.95, i)) * (i % 2 == 0 ? 1 : -1);
        Ray ray{centre + Vec3(beside, 0, -1.5), Vec3(0, 0, 2), 0};  // of any length
        if (i % 3 == 1) std::swap(ray.origin.x(), ray.origin.y());
        if (i % 3 == 1) ray.origin += Vec3(centre.x() - centre.y(), centre.y() - centre.x(), 0);
        rays.push_back(ray);
    }
    const std::vector<RayHit> hits = traced(field, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Vec3 q = centre - rays[i].origin;
        const double b = q.z(), room = b * b - (q.squaredNorm() - 0.01);
        // Nearer to the rim than doubles tell, either answer is right.
        if (room < 1e-12) continue;
        ASSERT_TRUE(hits[i].there()) << "ray " << i << ", " << room << " m^2 inside the rim";
        const double t = b - std::sqrt(room);
        EXPECT_NEAR(2 * hits[i].t, t, std::max(1e-8, 1e-12 / std::sqrt(room))) << "ray " << i;
        const Vec3 normal = (rays[i].origin + Vec3(0, 0, t) - centre) / 0.1;
        EXPECT_LT((hits[i].normal - normal).norm(), 1e-6);
    }
}

// A capsule: its side is a cylinder, met where the ray's part across the axis is at distance e.
TEST(IsoRays, ASegmentIsMetWhereItsCapsuleIs)
{
    const Field field = make_field(
        layer_of({{.kind = SkeletonKind::segment, .points = {{-0.5, 0, 0}, {0.5, 0, 0}}}}),
        unmoved);
    std::vector<Ray> rays;
    for (int i = 0; i < 200; ++i) {
        rays.push_back({{-0.45 + 0.004 * i, 1, 0.0995 - 0.00095 * i}, {0.1, -1, 0}, 0});
    }
    const std::vector<RayHit> hits = traced(field, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const double z = rays[i].origin.z(), y = std::sqrt(0.01 - z * z);
        ASSERT_TRUE(hits[i].there()) << i;
        EXPECT_NEAR(hits[i].t, 1 - y, 1e-8) << i;
    }
}

// On the plane between two equal points the sum is twice one contribution: it is the isovalue where
// that is half of it, at a distance r that is found here by halving.
TEST(IsoRays, ABlendIsMetWhereHalfOfItIsOneContribution)
{
    const double d = 0.12;
    const Field field = make_field(layer_of({{.kind = SkeletonKind::point, .points = {{-d, 0, 0}}},
                                             {.kind = SkeletonKind::point, .points = {{d, 0, 0}}}}),
                                   unmoved);
    double near = 0.1, far = 0.25;
    for (int i = 0; i < 60; ++i) {
        const double r = 0.5 * (near + far);
        (profile_at(field.profile[0], r).f > 0.5 ? near : far) = r;
    }
    std::vector<Ray> rays;
    for (int i = 0; i < 100; ++i) {
        const double a = 2 * std::numbers::pi * i / 100;
        rays.push_back({{0, std::cos(a), std::sin(a)}, {0, -std::cos(a), -std::sin(a)}, 0});
    }
    for (const RayHit& hit : traced(field, rays)) {
        EXPECT_NEAR(hit.t, 1 - std::sqrt(near * near - d * d), 1e-8);
    }
}

TEST(IsoRays, AHeapOfBlendsIsMetWhereBruteForceMeetsIt)
{
    for (const BlendRule rule : rules) {
        const Field field = heap(rule, 5);
        const IsoField iso = iso_field(field);
        const auto rays = rays_at(iso.domain, 250, 11);
        EXPECT_GT(expect_as_brute_force(iso, rays, 4000, tolerance), 40);
    }
}

TEST(IsoRays, ADistanceIsThatOfTheFoot)
{
    const Random random(8);
    const Field field = heap(BlendRule::sum, 1);
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3 p(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2));
        EXPECT_EQ(distance(field, i % 9, p), foot(field, i % 9, p).r);
    }
}

TEST(IsoRays, TheSlopeNowhereExceedsItsBound)
{
    const Random random(3);
    for (const BlendRule rule : rules) {
        for (std::uint64_t seed = 0; seed < 8; ++seed) {
            const Field field = heap(rule, seed);
            const IsoField iso = iso_field(field);
            const Vec3 size = iso.domain.size();
            for (std::uint64_t i = 0; i < 400; ++i) {
                const auto place = [&](std::uint64_t k) {
                    return Vec3(random.unit(9 * i + k), random.unit(9 * i + k + 1),
                                random.unit(9 * i + k + 2));
                };
                Box box;
                box.lo = iso.domain.lo + size.cwiseProduct(place(0));
                box.hi = box.lo + 0.05 * place(3);
                const Vec3 p = box.lo + box.size().cwiseProduct(place(6));
                EXPECT_LE(value_at(field, p).gradient.norm(),
                          iso.steepness(box).slope * (1 + 1e-9));
            }
        }
    }
}

// A thin sheet, f = 1.01 exp(-(z - z0)^2 / w^2) - 1, of which nothing is known but its values: it
// is half a mm thick, and the steps of a quarter of a cell, 4 mm, lead over it. It is found as a
// peak between two samples outside.
TEST(IsoRays, ASheetThatStepsLeapOverIsFoundAsAPeak)
{
    const double w = 0.0025, z0 = 0.4123;
    IsoField iso;
    iso.domain.add(Vec3(Vec3::Zero()));
    iso.domain.add(Vec3(Vec3::Ones()));
    iso.bounds = [](const Box&) { return Interval{-1, 1}; };
    iso.ask = [=](const FieldBlock& block, BlockValues& values) {
        values.clear(block.count);
        for (std::size_t i = 0; i < block.count; ++i) {
            const double z = (block.z[i] - z0) / w, bell = 1.01 * std::exp(-z * z);
            values.f[i] = bell - 1;
            values.gz[i] = -2 * z / w * bell;
        }
    };
    std::vector<Ray> rays;
    for (int i = 0; i < 200; ++i) {
        rays.push_back({{0.5, 0.5, -1 - 0.001 * i}, {0.001 * i, 0, 1}, 0});
        rays.back().begin = 1 + 1e-5 * i;
    }
    std::vector<RayHit> hits(rays.size());
    trace(iso, iso_cells(iso), rays, tolerance, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_NEAR(rays[i].origin.z() + hits[i].t, z0 - w * std::sqrt(std::log(1.01)), 1e-7);
    }
}

// A field that jumps has no slope that would tell of a thin sheet: here f is 0.5 in a sheet 2 mm
// thick and -0.5 elsewhere.
TEST(IsoRays, AThinSheetIsFoundWhereTheFieldMayJump)
{
    const double z0 = 0.4123;
    IsoField iso;
    iso.domain.add(Vec3(Vec3::Zero()));
    iso.domain.add(Vec3(Vec3::Ones()));
    iso.bounds = [](const Box&) { return Interval{-1, 1}; };
    iso.steepness = [](const Box&) { return Steepness{0, 1}; };
    iso.ask = [=](const FieldBlock& block, BlockValues& values) {
        values.clear(block.count);
        for (std::size_t i = 0; i < block.count; ++i) {
            values.f[i] = std::abs(block.z[i] - z0) < 1e-3 ? 0.5 : -0.5;
        }
    };
    std::vector<Ray> rays;
    for (int i = 0; i < 100; ++i) rays.push_back({{0.5, 0.5, -1 - 0.001 * i}, {0, 0, 1}, 0});
    std::vector<RayHit> hits(rays.size());
    trace(iso, iso_cells(iso), rays, tolerance, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_NEAR(rays[i].origin.z() + hits[i].t, z0 - 1e-3, 1e-8);
        EXPECT_NEAR(hits[i].normal.z(), -1, 1e-12) << "towards where it came from";
    }
}

TEST(IsoRays, FromInsideTheSurfaceIsMetFromBehind)
{
    const Field field = make_field(layer_of({{.kind = SkeletonKind::point}}), unmoved);
    const std::vector<Ray> rays{{{0, 0, 0}, {0, 1, 0}, 0}, {{0.02, 0, 0.03}, {1, 0, 0}, 0}};
    const std::vector<RayHit> hits = traced(field, rays);
    EXPECT_NEAR(hits[0].t, 0.1, 1e-8);
    EXPECT_NEAR(hits[1].t, std::sqrt(0.01 - 0.0009) - 0.02, 1e-8);
    EXPECT_NEAR(hits[0].normal.y(), 1, 1e-6);
}

TEST(IsoRays, ARayEndsWhereItIsToldTo)
{
    const Field field = make_field(layer_of({{.kind = SkeletonKind::point}}), unmoved);
    const std::vector<Ray> rays{{{0, 0, -1}, {0, 0, 1}, 0, 0.8999},
                                {{0, 0, -1}, {0, 0, 1}, 0, 0.9001}};
    const std::vector<RayHit> hits = traced(field, rays);
    EXPECT_FALSE(hits[0].there());
    EXPECT_TRUE(hits[1].there());
}

TEST(IsoRays, WhatARayMeetsDoesNotDependOnItsCompany)
{
    const Field field = heap(BlendRule::smooth_groups, 2);
    const IsoField iso = iso_field(field);
    auto rays = rays_at(iso.domain, 700, 4);
    const std::vector<RayHit> all = traced(field, rays);
    std::reverse(rays.begin(), rays.end());
    rays.resize(123);
    const std::vector<RayHit> few = traced(field, rays);
    for (std::size_t i = 0; i < few.size(); ++i) {
        const RayHit& same = all[all.size() - 1 - i];
        EXPECT_EQ(few[i].t, same.t);
        EXPECT_EQ(few[i].normal, same.normal);
    }
}

TEST(IsoRays, NothingIsMetWhereThereIsNothing)
{
    const Field field = make_field(layer_of({}), unmoved);
    const IsoField iso = iso_field(field);
    EXPECT_TRUE(iso_cells(iso).bounds.empty());
    EXPECT_TRUE(surface_box(iso, iso_cells(iso)).empty());
    EXPECT_FALSE(traced(field, std::vector<Ray>{{{0, 0, -1}, {0, 0, 1}, 0}})[0].there());
    EXPECT_TRUE(traced(field, {}).empty());
}

// A capsule across the axes: its box is that of its two end spheres.
TEST(IsoExtent, ACapsuleReachesAsFarAsItsEnds)
{
    const Field field = make_field(
        layer_of({{.kind = SkeletonKind::segment, .points = {{-0.3, 0.1, 0}, {0.5, 0.2, 0.7}}}}),
        unmoved);
    const IsoField iso = iso_field(field);
    const Box box = surface_box(iso, iso_cells(iso));
    EXPECT_LT((box.lo - Vec3(-0.4, 0, -0.1)).norm(), 1e-6);
    EXPECT_LT((box.hi - Vec3(0.6, 0.3, 0.8)).norm(), 1e-6);
}

}  // namespace geometry
