#include "physics/layered_bodies/inverse_kinematics.hpp"

#include "physics/layered_bodies/layered_body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

// A base, two arms of 0.5 m along x, hinges about z at x = 0 and 0.5.
Base arm(double limit = 1e9)
{
    Base base;
    for (const double x : {-0.1, 0.25, 0.75}) {
        Transform t = Transform::Identity();
        t.translate(Vec3(x, 0, 0));
        base.frames.push_back(t);
    }
    base.mass.assign(3, 1);
    base.inertia.assign(3, Mat3::Identity());
    for (const std::uint32_t h : {0u, 1u}) {
        Hinge& hinge = add_hinge(base, h, h + 1, {0.5 * h, 0, 0}, {0, 0, 1});
        hinge.lowest = -limit;
        hinge.highest = limit;
    }
    return base;
}

const Vec3 hand(1, 0, 0);

}  // namespace

// At distance d the elbow is bent by cos q = (d^2 - 2 L^2) / (2 L^2), L = 0.5.
TEST(InverseKinematics, TwoArmsBendAsTheCosineLawSays)
{
    const Base base = arm();
    for (const Vec3& target : {Vec3(0.6, 0.3, 0), Vec3(-0.2, 0.5, 0), Vec3(0.1, -0.9, 0)}) {
        const std::vector<PoseGoal> goals{{2, hand, target}};
        const std::vector<double> start{0.1, 0.2};
        const SolvedPose at = inverse_kinematics(base, Transform::Identity(), goals, start);
        EXPECT_LT(at.miss, 2e-6);
        EXPECT_NEAR(std::cos(at.angle[1]), (target.squaredNorm() - 0.5) / 0.5, 1e-5);
        EXPECT_LT((at.frames[2] * Vec3(0.25, 0, 0) - target).norm(), 2e-6);
        // Still jointed: both frames put the elbow at one place.
        const Vec3 elbow_a = at.frames[1] * Vec3(0.25, 0, 0);
        const Vec3 elbow_b = at.frames[2] * Vec3(-0.25, 0, 0);
        EXPECT_LT((elbow_a - elbow_b).norm(), 1e-14);
        EXPECT_LT((at.frames[0].matrix() - base.frames[0].matrix()).norm(), 1e-14);
    }
}

TEST(InverseKinematics, AGoalOutOfReachIsApproached)
{
    const SolvedPose at = inverse_kinematics(arm(), Transform::Identity(),
                                             std::vector<PoseGoal>{{2, hand, {1.2, 1.6, 0}}},
                                             std::vector<double>{0.1, 0.2});
    EXPECT_NEAR(at.miss, 1, 2e-3);  // 2 m away, the arm is 1 m long: stretched towards it
    EXPECT_NEAR(at.angle[0], std::atan2(1.6, 1.2), 0.05);
}

// Drawn straight, with its goal on that line: no hinge helps at first order.
TEST(InverseKinematics, AStraightArmBendsTowardsItsGoal)
{
    const std::vector<PoseGoal> goals{{2, hand, {0.7, 0, 0}}};
    EXPECT_LT(inverse_kinematics(arm(), Transform::Identity(), goals).miss, 2e-6);
}

TEST(InverseKinematics, HingeLimitsHold)
{
    const SolvedPose at = inverse_kinematics(arm(0.4), Transform::Identity(),
                                             std::vector<PoseGoal>{{2, hand, {0, 0.9, 0}}});
    for (const double angle : at.angle) EXPECT_LE(std::abs(angle), 0.4);
    // Both at their limit is the nearest that it gets.
    EXPECT_NEAR(at.angle[0], 0.4, 1e-6);
    EXPECT_NEAR(at.angle[1], 0.4, 1e-6);
}

// A goal on a circle that the hand follows: from a little below half a turn to a little above.
TEST(InverseKinematics, AHingeWithoutLimitsTurnsPastHalfATurn)
{
    const Base base = arm(std::numbers::pi);
    std::vector<double> angle{2.55, 0.9};
    for (int step = 0; step <= 20; ++step) {
        const double a = 3 + 0.05 * step;
        const std::vector<PoseGoal> goals{{2, hand, 0.9 * Vec3(std::cos(a), std::sin(a), 0)}};
        const SolvedPose at = inverse_kinematics(base, Transform::Identity(), goals, angle);
        EXPECT_LT(at.miss, 2e-6) << "at " << a;
        for (std::size_t h = 0; h < 2; ++h) {
            EXPECT_LT(std::abs(at.angle[h] - angle[h]), 0.2) << "no jump at " << a;
        }
        angle = at.angle;
    }
    EXPECT_GT(angle[0], std::numbers::pi);
}

// The same arm with its hinges counted the other way round: the same pose, opposite angles.
TEST(InverseKinematics, AHingeMayCarryEitherOfItsFrames)
{
    Base base = arm(), other = arm();
    other.hinges.clear();
    for (const std::uint32_t h : {0u, 1u}) {
        add_hinge(other, h + 1, h, {0.5 * h, 0, 0}, {0, 0, 1});
    }
    const std::vector<PoseGoal> goals{{2, hand, {0.1, -0.9, 0}}};
    const SolvedPose as_drawn =
        inverse_kinematics(base, Transform::Identity(), goals, std::vector{0.1, 0.2});
    const SolvedPose at =
        inverse_kinematics(other, Transform::Identity(), goals, std::vector{-0.1, -0.2});
    EXPECT_LT(at.miss, 2e-6);
    EXPECT_EQ(at.iterations, as_drawn.iterations);
    for (std::size_t h = 0; h < 2; ++h) EXPECT_NEAR(at.angle[h], -as_drawn.angle[h], 1e-9);
    for (std::size_t f = 0; f < 3; ++f) {
        EXPECT_LT((at.frames[f].matrix() - as_drawn.frames[f].matrix()).norm(), 1e-9);
    }
}

// A hinge whose limits leave it no room is as good as none: the others' steps do not count on it.
TEST(InverseKinematics, AHingeThatCannotTurnIsLeftOutOfTheStep)
{
    // Upper arm, forearm, hand; with a shoulder that is stuck, or hanging on the upper arm itself.
    const auto limb = [](bool shoulder) {
        Base base;
        const std::vector<double> at{0.3, 0.25, 0.75, 1.2};
        for (std::size_t f = shoulder ? 0 : 1; f < at.size(); ++f) {
            Transform t = Transform::Identity();
            t.translate(Vec3(at[f], 0, 0));
            base.frames.push_back(t);
        }
        base.mass.assign(base.frames.size(), 1);
        base.inertia.assign(base.frames.size(), Mat3::Identity());
        for (std::uint32_t h = 0; h + 1 < base.frames.size(); ++h) {
            add_hinge(base, h, h + 1, {0.5 * (h + (shoulder ? 0 : 1)), 0, 0}, {0, 0, 1});
        }
        if (shoulder) base.hinges[0].lowest = base.hinges[0].highest = 0;
        return base;
    };
    const Vec3 finger(1.4, 0, 0), target(0.7, 0.6, 0);
    const SolvedPose stuck =
        inverse_kinematics(limb(true), Transform::Identity(),
                           std::vector<PoseGoal>{{3, finger, target}}, std::vector{0.0, 0.1, 0.1});
    const SolvedPose hanging =
        inverse_kinematics(limb(false), Transform::Identity(),
                           std::vector<PoseGoal>{{2, finger, target}}, std::vector{0.1, 0.1});
    EXPECT_LT(stuck.miss, 2e-6);
    EXPECT_EQ(stuck.iterations, hanging.iterations);
    EXPECT_EQ(stuck.angle[0], 0);
    for (std::size_t h = 0; h < 2; ++h) {
        EXPECT_NEAR(stuck.angle[h + 1], hanging.angle[h], 1e-9);
    }
}

TEST(InverseKinematics, TheRootTakesTheFigureAlong)
{
    Transform root = Transform::Identity();
    root.translate(Vec3(0, 0, 3)).rotate(Eigen::AngleAxisd(0.7, Vec3::UnitY()));
    const Vec3 target = root * Vec3(0.3, 0.6, 0);
    const SolvedPose at = inverse_kinematics(arm(), root, std::vector<PoseGoal>{{2, hand, target}});
    EXPECT_LT(at.miss, 2e-6);
    EXPECT_LT((at.frames[0].matrix() - (root * arm().frames[0]).matrix()).norm(), 1e-14);
}

TEST(InverseKinematics, LoopsLooseFramesAndBadGoalsThrow)
{
    Base base = arm();
    add_hinge(base, 0, 2, {0, 1, 0}, {0, 0, 1});
    EXPECT_THROW(inverse_kinematics(base, Transform::Identity(), {}), std::invalid_argument);
    base = arm();
    base.hinges.pop_back();
    EXPECT_THROW(inverse_kinematics(base, Transform::Identity(), {}), std::invalid_argument);
    EXPECT_THROW(
        inverse_kinematics(arm(), Transform::Identity(), std::vector<PoseGoal>{{7, hand, hand}}),
        std::invalid_argument);
    EXPECT_THROW(inverse_kinematics(arm(), Transform::Identity(),
                                    std::vector<PoseGoal>{{2, hand, {std::nan(""), 0, 0}}}),
                 std::invalid_argument);
    EXPECT_EQ(inverse_kinematics(arm(), Transform::Identity(), {}).miss, 0);
}

}  // namespace physics
