#include "physics/layer_skin.hpp"

#include "geometry/primitive.hpp"

#include <gtest/gtest.h>

#include <cmath>

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
    const geometry::TriMesh mesh = sphere({0.3, 0, 0});
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

TEST(LayerSkin, OutOfReachItRidesAndMismatchesAreSaid)
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
