#include "physics/layered_bodies/carry_frames.hpp"

#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_step.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

geometry::Cubes bar()
{
    return fixtures::cubes_on({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, 0.25);
}

LayeredBody two_segments()
{
    geometry::ImplicitLayer layer;
    layer.skeletons = {
        {.kind = geometry::SkeletonKind::segment, .points = {{0.1, 0.12, 0.12}, {0.4, 0.12, 0.12}}},
        {.kind = geometry::SkeletonKind::segment,
         .points = {{0.6, 0.12, 0.12}, {0.9, 0.12, 0.12}}}};
    layer.contributions.assign(2, {.thickness = 0.1, .stiffness = 10, .radius = 0.25});
    layer.frame = {0, 1};
    return make_layered_body(layer, BaseKind::still, 1000, 0.05);
}

}  // namespace

TEST(CarryFrames, FramesMoveRigidlyWithCubesThatDo)
{
    const geometry::Cubes cubes = bar();
    const LayeredBody body = two_segments();
    const CarriedFrames carried = bind_frames(body.base.frames, body.samples, cubes);
    Transform move = Transform::Identity();
    move.translate(Vec3(1, 2, 3)).rotate(Eigen::AngleAxisd(1.1, Vec3(2, 1, -1).normalized()));
    std::vector<Vec3> x;
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        x.push_back(move * cubes.corner_position(k));
    }
    for (const Transform& frame : carry(carried, body.base.frames, cubes, x)) {
        EXPECT_LT((frame.matrix() - move.matrix()).norm(), 1e-5);  // probes are floats
    }
}

// Stretched cubes carry frames along without stretching or turning them; bent ones turn each as the
// bar turns there.
TEST(CarryFrames, FramesTurnButNeverStretch)
{
    const geometry::Cubes cubes = bar();
    const LayeredBody body = two_segments();
    const CarriedFrames carried = bind_frames(body.base.frames, body.samples, cubes);
    std::vector<Vec3> stretched, bent;
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        const Vec3 X = cubes.corner_position(k);
        stretched.push_back(X.cwiseProduct(Vec3(2, 0.5, 0.5)));
        bent.push_back({X.x(), X.y() + 0.2 * X.x() * X.x(), X.z()});
    }
    for (const Transform& frame : carry(carried, body.base.frames, cubes, stretched)) {
        EXPECT_LT((frame.linear() - Mat3::Identity()).norm(), 1e-5);
    }
    const std::vector<Transform> turned = carry(carried, body.base.frames, cubes, bent);
    // The slope there, 0.4 X: R of [1 0; s 1] turns by atan(s / 2).
    const auto angle = [](const Transform& t) {
        return std::atan2(t.linear()(1, 0), t.linear()(0, 0));
    };
    EXPECT_NEAR(angle(turned[0]), std::atan(0.4 * 0.25 / 2), 0.02);
    EXPECT_NEAR(angle(turned[1]), std::atan(0.4 * 0.75 / 2), 0.02);
}

}  // namespace physics
