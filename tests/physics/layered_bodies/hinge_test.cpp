// Hinges between rigid frames, with either solver.

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using namespace layered_fixtures;

constexpr double pi = std::numbers::pi;
constexpr double step = 1.0 / 240;  // s

class HingeOf : public testing::TestWithParam<RigidBodies> {
protected:
    static LayeredScene go_on(LayeredScene scene, int steps)
    {
        const LayeredWorld world{.gravity = Vec3::Zero(), .rigid_bodies = GetParam()};
        for (int i = 0; i < steps; ++i) scene = advance(scene, scene.parts, world, step, 1);
        return scene;
    }
};

INSTANTIATE_TEST_SUITE_P(Solver, HingeOf,
                         testing::Values(RigidBodies::implicit, RigidBodies::bullet),
                         [](const auto& info) {
                             return info.param == RigidBodies::bullet ? "Bullet" : "Implicit";
                         });

// Two limbs whose hinge counts its angle from `zero` as drawn, turned by `angle`, its limits and
// its rest at the same places.
LayeredScene turned(double zero, double lowest, double highest, double angle)
{
    LayeredBody body = two_limbs(zero + lowest, zero + highest);
    Hinge& hinge = body.base.hinges[0];
    hinge.zero_b = Eigen::AngleAxisd(zero, hinge.axis_b) * hinge.zero_b;
    hinge.rest = zero + 0.2;
    hinge.stiffness = 2;
    LayeredScene scene = scene_of({body});
    const Eigen::AngleAxisd by(angle, Vec3::UnitZ());
    const Vec3 point(0.45, 0, 0);
    scene.states[0].position[1] = point + by * (scene.states[0].position[1] - point);
    scene.states[0].rotation[1] = Eigen::Quaterniond(by).coeffs();
    return scene;
}

double spin_between(const LayeredScene& scene)
{
    return (scene.states[0].spin[1] - scene.states[0].spin[0]).z();
}

}  // namespace

// Where the angle is counted from is a choice of names: what a spring and limits do does not depend
// on it, though the angle passes half a turn. (Twenty steps whose joints are solved to 1e-10 of
// their forces.)
TEST_P(HingeOf, MovesAlikeWhereverItsAngleIsCountedFrom)
{
    for (const double angle : {0.9, 1.3, -1.3}) {  // within the limits, and beyond either
        const LayeredScene plain = go_on(turned(0, -1, 1, angle), 20);
        EXPECT_LT(angle * spin_between(plain), 0) << angle << ": driven back";
        for (const double zero : {2.4, -2.4}) {
            const LayeredScene other = go_on(turned(zero, -1, 1, angle), 20);
            EXPECT_NEAR(hinge_state(other).angle - zero, hinge_state(plain).angle, 1e-6);
            EXPECT_NEAR(spin_between(other), spin_between(plain), 1e-6) << angle << ' ' << zero;
        }
    }
}

// Nothing stops it at half a turn.
TEST_P(HingeOf, TurnsFreelyWhereItsLimitsAreAWholeTurnApart)
{
    const auto spun = [&](double lowest, double highest) {
        LayeredScene scene = scene_of({two_limbs(lowest, highest)});
        scene.states[0].spin[0] = {0, 0, -4};
        scene.states[0].spin[1] = {0, 0, 4};
        return go_on(std::move(scene), 200);  // more than one turn
    };
    const LayeredScene limits = spun(-pi, pi), none = spun(-1e9, 1e9);
    EXPECT_GT(spin_between(limits), 2);
    EXPECT_LT((limits.states[0].position[1] - none.states[0].position[1]).norm(), 1e-9);
    EXPECT_NEAR(spin_between(limits), spin_between(none), 1e-9);
}

// Without limits its spring pulls the shorter way to its rest.
TEST_P(HingeOf, IsPulledToItsRestTheShorterWay)
{
    for (const double angle : {-0.5, 0.5}) {
        LayeredScene scene = turned(3, -1e9, 1e9, 0.2 + angle);
        EXPECT_LT(angle * spin_between(go_on(std::move(scene), 5)), 0);
    }
}

}  // namespace physics
