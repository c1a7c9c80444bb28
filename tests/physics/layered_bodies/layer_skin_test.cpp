#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layer_skin.hpp"

#include "geometry/fields/polygonize.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_step.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

constexpr double e = 0.1;

LayeredPart still_ball(const Vec3& at, double spacing = 0.02)
{
    geometry::ImplicitLayer layer;
    layer.skeletons = {{.kind = geometry::SkeletonKind::point, .points = {at}}};
    layer.contributions = {{.thickness = e, .stiffness = 10, .radius = 0.25}};
    layer.frame = {0};
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(
        make_layered_body(layer, BaseKind::still, 1000, spacing));
    return part;
}

geometry::TriMesh sphere(const Vec3& at)
{
    geometry::TriMesh mesh = geometry::icosphere(e, 3);
    for (auto& p : mesh.positions) p += at.cast<float>();
    return mesh;
}

}  // namespace

TEST(LayerSkin, StaysAtRestAndTurnsWithItsFrame)
{
    LayeredPart part = still_ball({0.3, 0, 0});
    geometry::TriMesh mesh = sphere({0.3, 0, 0});
    for (std::size_t v = 0; v < mesh.positions.size(); v += 3) {  // details of its own
        mesh.positions[v] += 0.1f * (mesh.positions[v] - geometry::Vec3f(0.3f, 0, 0));
    }
    const LayerSkin skin = bind(mesh, *part.body);
    part.pose.rotate(Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()));
    part.pose.pretranslate(Vec3(1, 2, 3));
    const geometry::TriMesh moved = follow(skin, mesh, start({part}), 0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3 expected = part.pose * mesh.positions[v].cast<double>();
        EXPECT_LT((moved.positions[v].cast<double>() - expected).norm(), 1e-6);
    }
}

// Two balls 0.18 apart press each other flat at x = 0: so are their skins.
TEST(LayerSkin, FeelsContact)
{
    const LayeredPart left = still_ball({-0.09, 0, 0}), right = still_ball({0.09, 0, 0});
    const geometry::TriMesh mesh = sphere({-0.09, 0, 0});
    const geometry::TriMesh pressed = follow(bind(mesh, *left.body), mesh, start({left, right}), 0);
    float highest = -1;
    int flat = 0;
    for (const auto& p : pressed.positions) {
        highest = std::max(highest, p.x());
        flat += std::abs(p.x()) < 1e-6f;
    }
    EXPECT_LT(highest, 1e-6f);
    EXPECT_GT(flat, 5);
}

// A vertex at rest on the surface stays on it when the contribution is moved outward.
TEST(LayerSkin, BreathesWithTheLayer)
{
    const LayeredPart part = still_ball({0, 0, 0});
    const geometry::TriMesh mesh = sphere({0, 0, 0});
    LayeredScene scene = start({part});
    scene.states[0].translation[0] = 0.02;
    const geometry::TriMesh grown = follow(bind(mesh, *part.body), mesh, scene, 0);
    for (const auto& p : grown.positions) EXPECT_NEAR(p.norm(), 0.12f, 1e-5f);
}

namespace {

// How a skin came through a pose.
struct Shape {
    int folded = 0;      // triangles whose inner side looks out
    double stretch = 0;  // longest edge by what it was at rest
    double miss = 0;     // most that a vertex is off its value
};

// Two limbs with a hinge at the origin and the skin that they have at rest.
struct Arm {
    LayeredPart part;
    geometry::TriMesh mesh;
    LayerSkin skin;

    Arm()
    {
        geometry::ImplicitLayer layer;
        for (const double side : {-1.0, 1.0}) {
            layer.skeletons.push_back({.kind = geometry::SkeletonKind::segment,
                                       .points = {{0.3 * side, 0, 0}, {0.045 * side, 0, 0}}});
            layer.contributions.push_back({.thickness = 0.06, .stiffness = 14, .radius = 0.175});
        }
        layer.frame = {0, 1};
        layer.blend.rule = geometry::BlendRule::smooth_groups;
        layer.blend.links = {{0, 1, 1.0}};
        part.body = std::make_shared<const LayeredBody>(
            make_layered_body(layer, BaseKind::led, 1000, 0.015));
        const Field drawn = geometry::make_field(part.body->layer, part.body->base.frames);
        mesh = geometry::polygonize(geometry::iso_field(drawn), 0.012);
        skin = bind(mesh, *part.body);
    }

    // The second limb turned, and `both` before.
    geometry::TriMesh turned(double degrees, const Vec3& axis, double both = 0)
    {
        constexpr double degree = std::numbers::pi / 180;
        part.frames = part.body->base.frames;
        part.frames[0].prerotate(Eigen::AngleAxisd(both * degree, axis));
        part.frames[1].prerotate(Eigen::AngleAxisd((both + degrees) * degree, axis));
        return follow(skin, mesh, start({part}), 0);
    }

    Shape shape(const geometry::TriMesh& now) const
    {
        const Field field = geometry::make_field(part.body->layer, part.frames);
        Shape out;
        for (const geometry::Triangle& t : now.triangles()) {
            const auto p = [&](std::size_t k) { return Vec3(now.positions[t[k]].cast<double>()); };
            const Vec3 area = (p(1) - p(0)).cross(p(2) - p(0));
            out.folded += area.dot(value_at(field, (p(0) + p(1) + p(2)) / 3).gradient) > 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto a = t[k], b = t[(k + 1) % 3];
                const double before = (mesh.positions[a] - mesh.positions[b]).norm();
                if (before < 0.002) continue;  // the mesher's shortest
                const double length = (now.positions[a] - now.positions[b]).norm();
                out.stretch = std::max(out.stretch, length / before);
            }
        }
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const double f = value_at(field, now.positions[v].cast<double>()).f;
            out.miss = std::max(out.miss, std::abs(f - skin.value[v]));
        }
        return out;
    }
};

}  // namespace

// By linear blending and projection alone the elbow had 156 of 5948 triangles folded and an edge
// 15 times its length at 120 degrees, the twisted arm one of 5.5.
TEST(LayerSkin, AJointThatBendsOrTwistsFarKeepsItsSkinWhole)
{
    Arm arm;
    const auto shape_at = [&](double degrees, const Vec3& axis, double both = 0) {
        return arm.shape(arm.turned(degrees, axis, both));
    };
    const Shape bent = shape_at(90, Vec3::UnitZ()), far = shape_at(120, Vec3::UnitZ()),
                twisted = shape_at(160, Vec3::UnitX());
    for (const Shape& shape : {bent, far, twisted}) {
        EXPECT_EQ(shape.folded, 0);
        EXPECT_LT(shape.miss, 1e-6);
    }
    EXPECT_LT(bent.stretch, 1.9);
    EXPECT_LT(far.stretch, 4);
    EXPECT_LT(twisted.stretch, 2);
    EXPECT_LT(shape_at(30, Vec3::UnitX(), 230).stretch, 1.2) << "not the long way round";
    // Where the limbs cover each other there is less surface than skin: most of it stays in order.
    EXPECT_LT(shape_at(140, Vec3::UnitZ()).folded, 170);
}

TEST(LayerSkin, TheSameBitsForAnyNumberOfThreads)
{
    Arm arm;
    const geometry::TriMesh first = arm.turned(130, Vec3::UnitZ());
    for (const unsigned threads : {1u, 2u, 8u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_EQ(arm.turned(130, Vec3::UnitZ()).positions, first.positions) << threads;
    }
}

TEST(LayerSkin, VerticesOutOfReachRideOnTheirFrameAndMismatchedInputThrows)
{
    const LayeredPart part = still_ball({0, 0, 0});
    const geometry::TriMesh far = sphere({3, 0, 0});
    const LayerSkin skin = bind(far, *part.body);
    EXPECT_EQ(skin.out_of_reach, far.positions.size());
    const LayeredScene scene = start({part});
    EXPECT_LT((follow(skin, far, scene, 0).positions[0] - far.positions[0]).norm(), 1e-6f);
    EXPECT_THROW(follow(skin, far, scene, 1), std::invalid_argument);
    EXPECT_THROW(follow(skin, geometry::TriMesh{}, scene, 0), std::invalid_argument);
    EXPECT_TRUE(follow(bind({}, *part.body), {}, scene, 0).positions.empty());
}

}  // namespace physics
