#include "geometry/mesh/mesh.hpp"
#include "physics/layers/surface_samples.hpp"

#include "geometry/fields/polygonize.hpp"
#include "tests/physics/layers/layer_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using geometry::BlendRule;
using geometry::Contribution;
using geometry::Mat3;
using geometry::Skeleton;
using geometry::SkeletonKind;
using layer_fixtures::layer_of;
using layer_fixtures::point;

using std::numbers::pi;
const std::vector<Transform> at_rest{Transform::Identity()};

double total_area(const SampleWalk& walk)
{
    double sum = 0;
    for (const double a : walk.area) sum += a;
    return sum;
}

double mesh_volume(const geometry::TriMesh& mesh)
{
    double sum = 0;
    for (const auto& t : mesh.triangles()) {
        sum += mesh.positions[t[0]].cast<double>().dot(
                   mesh.positions[t[1]].cast<double>().cross(mesh.positions[t[2]].cast<double>())) /
               6;
    }
    return sum;
}

const Contribution wide{.thickness = 0.5, .stiffness = 2, .radius = 1.2, .stiffening = 0.3};

}  // namespace

// Rays' cones cover every direction once, so a ball's volume and area are exact for any number.
TEST(SurfaceSamples, ABallHasItsVolumeAndArea)
{
    for (const double spacing : {0.4, 0.1, 0.03}) {
        const ImplicitLayer layer = layer_of({point({1, 2, 3})}, wide);
        const SampleWalk walk = physics::walk(geometry::make_field(layer, at_rest),
                                              make_surface_samples(layer, spacing), at_rest);
        EXPECT_NEAR(walk.volume(), 4 * pi / 3 * 0.125, 1e-12);
        EXPECT_NEAR(total_area(walk), 4 * pi * 0.25, 1e-11);
        for (const std::uint8_t valid : walk.valid) EXPECT_TRUE(valid);
    }
}

// So are those of an ellipsoid: rays go from the middle as they do in narrowed space.
TEST(SurfaceSamples, AStretchedPointHasItsEllipsoidsVolumeAndSurface)
{
    Skeleton ball = point({1, 2, 3});
    const Mat3 axes = Eigen::AngleAxisd(0.4, Vec3(1, 2, -1).normalized()).matrix();
    ball.stretch = axes * Vec3(1, 3, 2).asDiagonal() * axes.transpose();
    const Mat3 narrow = ball.stretch.inverse();
    const ImplicitLayer layer = layer_of({ball}, wide);
    for (const double spacing : {0.4, 0.1}) {
        const SampleWalk walk = physics::walk(geometry::make_field(layer, at_rest),
                                              make_surface_samples(layer, spacing), at_rest);
        EXPECT_NEAR(walk.volume(), 6 * 4 * pi / 3 * 0.125, 1e-11);
        for (std::size_t i = 0; i < walk.position.size(); ++i) {
            EXPECT_TRUE(walk.valid[i]);
            EXPECT_NEAR((narrow * (walk.position[i] - ball.points[0])).norm(), 0.5, 1e-12);
        }
        // Thomsen's formula is right within 1.2 %.
        const double p = 1.6075, a = 0.5, b = 1.5, c = 1;
        const double mean = (std::pow(a * b, p) + std::pow(b * c, p) + std::pow(c * a, p)) / 3;
        EXPECT_NEAR(total_area(walk), 4 * pi * std::pow(mean, 1 / p), 0.02 * total_area(walk));
    }
    const double most = 0.1;  // a sample on average stands for no more than its spacing squared
    EXPECT_GT(double(make_surface_samples(layer, most).count()) * most * most, 10);
}

// The half size that a point does not use does not count, or no layer of millimetres could be.
TEST(SurfaceSamples, CoatAPointOfAnySize)
{
    for (const double scale : {1e-4, 1.0, 1e4}) {
        const Contribution coat{.thickness = 0.5 * scale, .stiffness = 2, .radius = 1.2 * scale};
        geometry::Skeleton at = point({1, 2, 3});
        at.half_size = Vec3(0.5, 0.5, 0.5);
        EXPECT_GT(make_surface_samples(layer_of({at}, coat), 0.05 * scale).count(), 100u);
        at.kind = geometry::SkeletonKind::box;
        at.points.clear();
        at.half_size = Vec3::Constant(5000 * scale);
        EXPECT_THROW(make_surface_samples(layer_of({at}, coat), 0.05 * scale),
                     std::invalid_argument);
    }
}

// int exp(a . n) over the sphere = 4 pi sinh |a| / |a|. Each face is exact for quadratics, which is
// order 3; where the cubic errors of neighbours cancel, 4. A third of the solid angle a corner
// would have order 2.
TEST(SurfaceSamples, OfAPointIntegrateOverDirectionsWithOrderThreeAtLeast)
{
    const Vec3 a(0.7, -1.1, 1.5);
    const double exact = 4 * pi * std::sinh(a.norm()) / a.norm();
    double last = 0;
    for (const double spacing : {0.2, 0.1, 0.05}) {
        const SurfaceSamples samples =
            make_surface_samples(layer_of({point({1, 2, 3})}, wide), spacing);
        double sum = 0;
        for (std::size_t i = 0; i < samples.count(); ++i) {
            EXPECT_GT(samples.a2[i], 0);
            sum += samples.a2[i] * std::exp(a.dot(samples.direction[i]));
        }
        const double error = std::abs(sum / exact - 1);
        if (last > 0) {
            EXPECT_GT(std::log2(last / error), 3.0) << spacing;
        }
        last = error;
    }
    EXPECT_LT(last, 1e-6);
}

// int (v . n)^12 over the sphere = 4 pi / 13. Along a corner v of the icosahedron the function
// holds the harmonic of degree 6 that the icosahedron's own faces have: what a face is worth must
// follow its solid angle, not its size in the plane, or the error falls with order 2 alone. With it
// errors of neighbours cancel: order 4.
TEST(SurfaceSamples, OfAPointStandForTheSolidAngleOfEachFace)
{
    const Vec3 v = Vec3(-1, std::numbers::phi, 0).normalized();
    const auto error_at = [&](double spacing) {
        const SurfaceSamples samples =
            make_surface_samples(layer_of({point({0, 0, 0})}, wide), spacing);
        double sum = 0;
        for (std::size_t i = 0; i < samples.count(); ++i) {
            sum += samples.a2[i] * std::pow(v.dot(samples.direction[i]), 12);
        }
        return std::abs(sum / (4 * pi / 13) - 1);
    };
    const double coarse = error_at(0.05), fine = error_at(0.0125);
    EXPECT_GT(0.5 * std::log2(coarse / fine), 3.7);
    EXPECT_LT(fine, 2e-6);
}

// By brute force: two faces of one edge, each names the other's third corner.
TEST(SurfaceSamples, NeighboursAcrossEdgesAreFound)
{
    const ImplicitLayer layer = layer_of(
        {point({0, 0, 0}), {.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {1, 0, 0}}}},
        wide);
    const SurfaceSamples samples = make_surface_samples(layer, 0.3);
    ASSERT_EQ(samples.across.size(), samples.faces.size());
    std::vector<std::uint32_t> valence(samples.count(), 0);
    for (std::size_t f = 0; f < samples.faces.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const geometry::Triangle& face = samples.faces[f];
            ++valence[face[k]];
            std::vector<std::uint32_t> found;
            for (std::size_t g = 0; g < samples.faces.size(); ++g) {
                const geometry::Triangle& other = samples.faces[g];
                for (std::size_t c = 0; c < 3; ++c) {
                    if (other[(c + 2) % 3] == face[(k + 1) % 3] &&
                        other[(c + 1) % 3] == face[(k + 2) % 3]) {
                        found.push_back(other[c]);
                    }
                }
            }
            ASSERT_EQ(found.size(), 1u);  // closed
            EXPECT_EQ(samples.across[f][k], found[0]);
        }
    }
    EXPECT_EQ(samples.valence, valence);
}

// Steiner: V(e) = V0 + A0 e + M e^2 + 4/3 pi e^3.
TEST(SurfaceSamples, GiveConvexSkeletonsTheVolumeOfTheirOffset)
{
    const double e = wide.thickness;
    Skeleton box{.kind = SkeletonKind::box, .points = {}, .half_size = {0.5, 0.4, 0.3}};
    box.place.rotate(Eigen::AngleAxisd(0.4, Vec3(1, 2, 2).normalized()));
    const std::vector<std::pair<Skeleton, double>> cases{
        {{.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {1, 1, 0.5}}}, pi * e * e * 1.5},
        {{.kind = SkeletonKind::triangle, .points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
         e + pi / 2 * e * e * (2 + std::sqrt(2.0))},
        {box, 8 * 0.06 + 2 * e * (0.8 + 0.48 + 0.6) + pi * e * e * (1 + 0.8 + 0.6)},
    };
    for (const auto& [skeleton, beyond_ball] : cases) {
        const ImplicitLayer layer = layer_of({skeleton}, wide);
        const SampleWalk walk = physics::walk(geometry::make_field(layer, at_rest),
                                              make_surface_samples(layer, 0.1), at_rest);
        // The vertices that samples come from are floats.
        EXPECT_NEAR(walk.volume(), beyond_ball + 4 * pi / 3 * e * e * e, 1e-6);
    }
}

TEST(SurfaceSamples, GiveAnEllipsoidItsOffsetsVolume)
{
    const ImplicitLayer layer = layer_of(
        {{.kind = SkeletonKind::ellipsoid, .points = {}, .half_size = {0.6, 0.4, 0.3}}}, wide);
    const geometry::Field field = geometry::make_field(layer, at_rest);
    const double volume = physics::walk(field, make_surface_samples(layer, 0.1), at_rest).volume();
    const double reference = mesh_volume(geometry::polygonize(geometry::iso_field(field), 0.05));
    EXPECT_NEAR(volume, reference, 5e-3 * reference);  // inscribed: some (h / r)^2
}

// Two equal balls blended: territories share the volume at the middle plane, and the sum is the
// object's, as its mesh has it.
TEST(SurfaceSamples, ShareTheVolumeOfABlendBetweenTerritories)
{
    const ImplicitLayer layer = layer_of({point({-0.4, 0, 0}), point({0.4, 0, 0})}, wide);
    const geometry::Field field = geometry::make_field(layer, at_rest);
    const SampleWalk walk = physics::walk(field, make_surface_samples(layer, 0.03), at_rest);
    const double reference = mesh_volume(geometry::polygonize(geometry::iso_field(field), 0.015));
    EXPECT_NEAR(walk.local_volume[0], walk.local_volume[1], 1e-3 * reference);
    EXPECT_NEAR(walk.volume(), reference, 2e-3 * reference);
    for (std::size_t i = 0; i < walk.valid.size(); ++i) {
        const auto at = geometry::value_at(field, walk.position[i]);
        if (walk.valid[i]) {
            EXPECT_NEAR(at.f, 1, 1e-10);
        } else {
            EXPECT_NEAR(walk.position[i].x(), 0, 1e-10);  // waiting at the border
        }
    }
}

// dV/dtau_i against the difference quotient of the whole volume, for plain sums and while two parts
// fuse. A ball alone: its area.
TEST(SurfaceSamples, VolumeSlopeIsTheDerivativeByTranslation)
{
    const ImplicitLayer ball = layer_of({point({0, 0, 0})}, wide);
    EXPECT_NEAR(physics::walk(geometry::make_field(ball, at_rest), make_surface_samples(ball, 0.1),
                              at_rest, nullptr, true)
                    .volume_slope[0],
                4 * pi * 0.25, 1e-11);
    ImplicitLayer oval = ball;
    oval.skeletons[0].stretch = Vec3(1, 3, 2).asDiagonal();
    EXPECT_NEAR(physics::walk(geometry::make_field(oval, at_rest), make_surface_samples(oval, 0.1),
                              at_rest, nullptr, true)
                    .volume_slope[0],
                6 * 4 * pi * 0.25, 1e-10);
    ImplicitLayer three =
        layer_of({point({-0.5, 0, 0}), point({0.3, 0.1, 0}), point({0.6, -0.2, 0.3})}, wide);
    three.contributions[1].thickness = 0.3;
    const SurfaceSamples samples = make_surface_samples(three, 0.02);
    for (const double weight : {-1.0, 0.5}) {
        if (weight > 0) {
            three.blend = {BlendRule::smooth_groups, {0, 1, 1}, {{0, 1, weight}, {0, 2, weight}}};
        }
        const SampleWalk here =
            physics::walk(geometry::make_field(three, at_rest), samples, at_rest, nullptr, true);
        for (std::size_t i = 0; i < 3; ++i) {
            std::vector<double> tau(3, 0);
            double volume[2];
            for (int side = 0; side < 2; ++side) {
                tau[i] = side == 0 ? -1e-3 : 1e-3;
                volume[side] =
                    physics::walk(geometry::make_field(three, at_rest, tau), samples, at_rest)
                        .volume();
            }
            const double quotient = (volume[1] - volume[0]) / 2e-3;
            // Some 9,000 samples a ball, of which a hundred jump at the territories' borders.
            EXPECT_NEAR(here.volume_slope[i], quotient, 0.02 * quotient) << i << " " << weight;
        }
    }
}

TEST(SurfaceSamples, FollowTheSurfaceFromWhereTheyWere)
{
    ImplicitLayer layer = layer_of({point({-0.4, 0, 0}), point({0.4, 0, 0})}, wide);
    const SurfaceSamples samples = make_surface_samples(layer, 0.05);
    SampleWalk walk = physics::walk(geometry::make_field(layer, at_rest), samples, at_rest);
    for (int step = 0; step < 10; ++step) {
        layer.skeletons[1].points[0].x() += 0.05;
        SurfaceSamples moved = samples;
        for (std::size_t i = samples.first[1]; i < samples.first[2]; ++i) {
            moved.origin[i] = layer.skeletons[1].points[0];
        }
        const geometry::Field field = geometry::make_field(layer, at_rest);
        walk = physics::walk(field, moved, at_rest, &walk);
        const SampleWalk fresh = physics::walk(field, moved, at_rest);
        for (std::size_t i = 0; i < samples.count(); ++i) {
            EXPECT_NEAR(walk.distance[i], fresh.distance[i], 1e-9);
            EXPECT_EQ(walk.valid[i], fresh.valid[i]);
        }
    }
}

TEST(SurfaceSamples, ASkeletonInsideAnotherHasNoSampleOnTheSurface)
{
    ImplicitLayer layer = layer_of({point({0, 0, 0}), point({0.05, 0, 0})}, wide);
    layer.contributions[1] = {.thickness = 0.1, .stiffness = 0.5, .radius = 0.2};
    const SurfaceSamples samples = make_surface_samples(layer, 0.05);
    const SampleWalk walk = physics::walk(geometry::make_field(layer, at_rest), samples, at_rest);
    for (std::size_t i = samples.first[1]; i < samples.first[2]; ++i) EXPECT_FALSE(walk.valid[i]);
    EXPECT_LT(walk.local_volume[1], 1e-12);
}

TEST(SurfaceSamples, TheyFollowTheFieldOfWhatBlendsWithThem)
{
    ImplicitLayer layer = layer_of({point({-0.45, 0, 0}), point({0.45, 0, 0})}, wide);
    layer.blend.rule = BlendRule::smooth_groups;  // no links: two parts that collide
    const SampleWalk walk = physics::walk(geometry::make_field(layer, at_rest),
                                          make_surface_samples(layer, 0.1), at_rest);
    for (const double d : walk.distance) EXPECT_NEAR(d, 0.5, 1e-11);
}

TEST(SurfaceSamples, ThePreviewMeshIsClosedForABallAndCoversABlend)
{
    const ImplicitLayer ball = layer_of({point({0, 0, 0})}, wide);
    const SurfaceSamples samples = make_surface_samples(ball, 0.05);
    const auto mesh =
        preview_mesh(samples, physics::walk(geometry::make_field(ball, at_rest), samples, at_rest));
    EXPECT_EQ(mesh.positions.size() + mesh.triangles().size(),
              2 + mesh.triangles().size() * 3 / 2);  // Euler: V - E + F = 2, E = 3F/2
    EXPECT_NEAR(mesh_volume(mesh), 4 * pi / 3 * 0.125, 0.01);
}

TEST(SurfaceSamples, TheSameBitsForAnyNumberOfThreads)
{
    const ImplicitLayer layer = layer_of({point({-0.4, 0, 0}), point({0.4, 0, 0})}, wide);
    const SurfaceSamples samples = make_surface_samples(layer, 0.03);
    std::vector<SampleWalk> walks;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        walks.push_back(physics::walk(geometry::make_field(layer, at_rest), samples, at_rest));
    }
    EXPECT_EQ(walks[0].distance, walks[1].distance);
    EXPECT_EQ(walks[0].distance, walks[2].distance);
    EXPECT_EQ(walks[0].local_volume, walks[2].local_volume);
}

TEST(SurfaceSamples, ABadSpacingThrowsAndAnEmptyLayerGivesNone)
{
    const ImplicitLayer layer = layer_of({point({0, 0, 0})}, wide);
    EXPECT_THROW(make_surface_samples(layer, 0), std::invalid_argument);
    EXPECT_THROW(make_surface_samples(layer, std::nan("")), std::invalid_argument);
    EXPECT_THROW(make_surface_samples(layer, 1e-6), std::invalid_argument);
    const SurfaceSamples none = make_surface_samples({}, 0.1);
    Skeleton rod{.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {1, 0, 0}}};
    try {
        make_surface_samples(layer_of({point({0, 0, 0}), rod}, wide), 5);
        FAIL() << "a body that nothing meets";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("too large for skeleton 1 (counted from 0): "),
                  std::string::npos)
            << error.what();
    }
    EXPECT_EQ(physics::walk(geometry::make_field({}, {}), none, {}).volume(), 0);
}

}  // namespace physics
