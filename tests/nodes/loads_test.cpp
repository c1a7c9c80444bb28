// What Pin, Force and Ground do to a body that Simulate moves, against motion known beforehand.

#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;
using graph::Value;
using Vector = std::array<double, 3>;

// A metre of 2 x 2 x 2 cubes of 1000 kg, all told.
Value block(double young = 1e6)
{
    return Value::of(fixtures::box(2, 2, 2, 0.5, {.density = 1000, .young = young}));
}

Value pins_of(NodeRun& pin, const Value& cubes)
{
    pin.inputs["cubes"] = {cubes};
    return pin.run();
}

// By mass, of cubes that are all alike.
Vec3 mean_of(const std::vector<Vec3>& values, const geometry::Cubes& cubes)
{
    Vec3 sum = Vec3::Zero();
    for (const auto& eight : cubes.corners) {
        for (const auto k : eight) sum += values[k];
    }
    return sum / (8.0 * double(cubes.count()));
}
Vec3 mean_velocity(const geometry::Cubes& cubes, const physics::State& state)
{
    return mean_of(state.v, cubes);
}

// A body under one force and no gravity of Simulate's own, `frames` frames of 1/24 s after its
// start.
std::shared_ptr<const physics::State> moved_by(NodeRun& force, const Value& cubes, int frames)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["forces"] = {force.run()};
    simulate.param("gravity").is = Vector{0, 0, 0};
    simulate.param("step.tolerance").is = 1e-9;
    Value state = simulate.run();
    for (int i = 0; i < frames; ++i) {
        simulate.previous = {state};
        state = simulate.run();
    }
    EXPECT_TRUE(simulate.warnings.empty());
    return state.as<physics::State>();
}

TEST(Pin, ChoosesTheCornersOfItsPlace)
{
    const Value cubes = block();  // corners at 0, 0.5 and 1 m each way: 27
    const auto held = [&](const std::string& where, auto&& set) {
        NodeRun pin("Pin");
        pin.param("where").is = where;
        set(pin);
        return pins_of(pin, cubes).as<physics::Pins>()->corner.size();
    };
    EXPECT_EQ(held("box",
                   [](NodeRun& pin) {
                       pin.param("box.centre").is = Vector{0, 0, 0};
                       pin.param("box.size").is = Vector{1.2, 0.2, 2.2};
                   }),
              2u * 1u * 3u);
    EXPECT_EQ(held("sphere",
                   [](NodeRun& pin) {
                       pin.param("sphere.centre").is = Vector{0.5, 0.5, 0.5};
                       pin.param("sphere.radius").is = 0.6;
                   }),
              7u);  // the middle and its six neighbours
    EXPECT_EQ(held("below", [](NodeRun& pin) { pin.param("below.height").is = 0.5; }), 18u);
    EXPECT_EQ(held("ends",
                   [](NodeRun& pin) {
                       pin.param("ends.axis").is = std::string("z");
                       pin.param("ends.end").is = std::string("high");
                       pin.param("ends.layers").is = std::int64_t{1};
                   }),
              18u);
    EXPECT_EQ(held("rim", [](NodeRun&) {}), 26u);
}

TEST(Pin, LetsGoWhereItIsOff)
{
    for (const char* hold : {"corners", "points"}) {
        NodeRun pin("Pin");
        pin.param("hold").is = std::string(hold);
        pin.param("on").is = std::int64_t{0};
        const auto pins = pins_of(pin, block()).as<physics::Pins>();
        EXPECT_TRUE(pins->corner.empty() && pins->matter.cubes.empty()) << hold;
        EXPECT_TRUE(pin.warnings.empty()) << hold;
    }
}

TEST(Pin, TellsWhatItHoldsNothingOfOrAllOf)
{
    NodeRun none("Pin");
    none.param("box.centre").is = Vector{0.5, 1.3, 0.5};
    none.param("box.size").is = Vector{0.2, 0.2, 0.2};
    pins_of(none, block());
    ASSERT_EQ(none.warnings.size(), 1u);
    EXPECT_NE(none.warnings[0].find("The nearest one, at (0.5, 1, 0.5), is 0.2 m outside, and "
                                    "corners are 0.5 m apart"),
              std::string::npos)
        << none.warnings[0];
    NodeRun all("Pin");
    all.param("box.size").is = Vector{9, 9, 9};
    pins_of(all, block());
    ASSERT_EQ(all.warnings.size(), 1u);
    EXPECT_NE(all.warnings[0].find("so this body cannot move. Where it is not meant as an anchor"),
              std::string::npos);
}

// A body that is thrown or dropped: the first frame alone says nothing of it.
TEST(Pin, HoldsAllOfABodySilentlyWhereItMovesOrIsLetGoLater)
{
    const auto warnings = [](const std::string& more) {
        fixtures::Scene scene(R"(
            "mesh": { "type": "Primitive@1", "params": { "shape": "box" } },
            "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "mesh" },
                       "params": { "method": "solid", "size": 0.5 } },
            "pin": { "type": "Pin@1", "inputs": { "cubes": "cubes" },
                     "params": { "where": "below", "below": { "height": 9 })" +
                                  more + "} }",
                              {}, 12);
        scene.at<physics::Pins>("pin", 1);
        return scene.warnings;
    };
    EXPECT_EQ(warnings("").size(), 1u);
    EXPECT_EQ(warnings(R"(, "translate": { "keys": [[1, [0, 0, 0]], [6, [0, 0, 0]]] })").size(),
              1u);
    for (const char* more :
         {R"(, "translate": { "keys": [[1, [0, 0, 0]], [6, [1, 0, 0]]] })",
          R"(, "rotate_degrees": [0, "=360 * time", 0])", R"(, "on": "=frame < 6")"}) {
        EXPECT_TRUE(warnings(more).empty()) << more;
    }
}

TEST(Pin, RotatesAboutItsPivotBeforeItTranslates)
{
    const Value cubes = block();
    NodeRun pin("Pin");
    pin.param("where").is = std::string("below");
    pin.param("below.height").is = 9.0;
    pin.param("translate").is = Vector{10, 0, 0};
    pin.param("rotate_degrees").is = Vector{0, 0, 90};
    pin.param("pivot").is = Vector{1, 0, 0};
    const Value pins = pins_of(pin, cubes);
    const auto got = pins.as<physics::Pins>();
    ASSERT_EQ(got->corner.size(), 27u);
    for (std::size_t i = 0; i < 27; ++i) {
        // About (1, 0): (x, y) goes to (1 - y, x - 1); then 10 m along x.
        const Vec3 p = cubes.as<geometry::Cubes>()->corner_position(got->corner[i]);
        const Vec3 goal(11 - p.y(), p.x() - 1, p.z());
        EXPECT_TRUE(got->target[i].isApprox(goal, 1e-12)) << got->target[i].transpose();
    }

    // Simulate takes them there within the frame: they turn evenly about the pivot, which moves
    // along a line.
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = {pins};
    const Value start = simulate.run();
    simulate.previous = {start};
    const auto state = simulate.run().as<physics::State>();
    const Vec3 turn(0, 0, std::numbers::pi / 2), way(10, 0, 0), pivot(11, 0, 0);
    for (std::size_t i = 0; i < 27; ++i) {
        const auto k = got->corner[i];
        EXPECT_EQ(state->x[k], got->target[i]);
        const Vec3 velocity = 24 * (way + turn.cross(got->target[i] - pivot));
        EXPECT_LT((state->v[k] - velocity).norm(), 1e-9 * velocity.norm());
    }
}

TEST(Pin, FollowsAMeshVertexByVertex)
{
    const Value cubes = block();
    geometry::TriMesh moved;
    for (const auto& p : geometry::corner_positions(*cubes.as<geometry::Cubes>())) {
        moved.positions.push_back((p + Vec3(0, 0, 3)).cast<float>());
    }
    NodeRun pin("Pin");
    pin.param("where").is = std::string("below");
    pin.param("below.height").is = 0.0;
    pin.inputs["follow"] = {Value::of(moved)};
    const auto got = pins_of(pin, cubes).as<physics::Pins>();
    ASSERT_EQ(got->corner.size(), 9u);
    for (std::size_t i = 0; i < 9; ++i) EXPECT_GE(got->target[i].z(), 3);
    moved.positions.push_back(moved.positions[0]);  // as where it is cut
    pin.inputs["follow"] = {Value::of(moved)};
    try {
        pin.run();
        FAIL() << "was followed";
    } catch (const std::invalid_argument& error) {
        for (const char* part :
             {"`follow`", "28 vertices", "expected 27", "Plane", "torn = hide"}) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    }
}

// All parts of a free body's momentum are the force's: m v = F t, 1000 kg for a quarter of a
// second.
TEST(Force, GravityAndAPointForceGiveTheMomentumOfTheirImpulse)
{
    const Value cubes = block();
    NodeRun gravity("Force");
    gravity.param("gravity.acceleration").is = Vector{1, -2, 3};
    const auto fallen = moved_by(gravity, cubes, 6);
    for (const Vec3& v : fallen->v) EXPECT_TRUE(v.isApprox(Vec3(0.25, -0.5, 0.75), 1e-12));

    NodeRun push("Force");
    push.param("kind").is = std::string("point");
    push.param("point.force").is = Vector{0, 400, -800};
    push.param("point.position").is = Vector{1, 0.5, 0.5};
    for (const double radius : {0.0, 0.2, 3.0}) {
        push.param("point.radius").is = radius;
        const Vec3 mean = mean_velocity(*cubes.as<geometry::Cubes>(), *moved_by(push, cubes, 6));
        EXPECT_LT((mean - Vec3(0, 0.1, -0.2)).norm(), 1e-12) << radius;
    }
}

TEST(Force, WindForceGrowsWithAreaAndSquareOfSpeed)
{
    // A face of 1 m^2 across a wind of 5 m/s, and the one behind: 1/2 * 1.2 * 2 * 5^2 = 30 N on
    // 1000 kg; a frame later it goes at 30 / 1000 / 24 m/s, too slow to matter to the drag.
    const Value cubes = block();
    NodeRun wind("Force");
    wind.param("kind").is = std::string("wind");
    wind.param("wind.drag").is = 2.0;
    const auto speed = [&] {
        return mean_velocity(*cubes.as<geometry::Cubes>(), *moved_by(wind, cubes, 1));
    };
    EXPECT_LT((speed() - Vec3(30.0 / 24000, 0, 0)).norm(), 1e-3 * 30 / 24000);
    wind.param("wind.velocity").is = Vector{0, 0, -10};
    EXPECT_LT((speed() - Vec3(0, 0, -120.0 / 24000)).norm(), 1e-3 * 120 / 24000);
    wind.param("wind.air_density").is = 0.0;
    EXPECT_EQ(speed(), Vec3::Zero());
}

// A force that grows from nothing to F in the second frame.
struct Growing {
    const char* kind;
    const char* number;
    Vector full;
};
Value grown(const Growing& of)
{
    NodeRun force("Force");
    force.param("kind").is = std::string(of.kind);
    force.param(of.number).is = Vector{0, 0, 0};
    if (std::string(of.kind) == "torque") force.param("torque.radius").is = 3.0;
    if (std::string(of.kind) == "torque") force.param("torque.position").is = Vector{0.5, 0.5, 0.5};
    force.previous = {force.run()};
    force.param(of.number).is = of.full;
    return force.run();
}

// A free block after a frame, and what it had of the whole impulse F / 24 s (or that of a torque).
struct Substeps {
    const char* method;
    const char* integrator;
    int count;
};
double share_of_impulse(const Growing& of, const Substeps& step)
{
    const Value cubes = block(1e7);
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["forces"] = {grown(of)};
    simulate.param("gravity").is = Vector{0, 0, 0};
    simulate.param("method").is = std::string(step.method);
    simulate.param("step.integrator").is = std::string(step.integrator);
    simulate.param("step.substeps").is = std::int64_t{step.count};
    simulate.param("step.tolerance").is = 1e-9;
    simulate.previous = {simulate.run()};
    const auto state = simulate.run().as<physics::State>();
    const auto& body = *cubes.as<geometry::Cubes>();
    const Vec3 full(of.full[0], of.full[1], of.full[2]), along = full.normalized();
    const auto motion = fixtures::brick_motion(body, *state);
    const bool turns = std::string(of.kind) == "torque";
    const bool falls = std::string(of.kind) == "gravity";
    const double impulse = (falls ? 1000.0 : 1.0) * full.norm() / 24;
    return (turns ? motion.angular : motion.linear).dot(along) / impulse;
}

// With n steps a frame by implicit Euler, which take it where they end, (n + 1) / (2 n); half by
// the midpoint rule. It acted in full all through the frame.
TEST(Force, ChangesEvenlyWithinAFrame)
{
    const std::vector<Growing> forces{{"gravity", "gravity.acceleration", {1, -2, 3}},
                                      {"point", "point.force", {0, 400, -800}},
                                      {"torque", "torque.torque", {0, 30, 0}}};
    for (const Growing& force : forces) {
        for (const int n : {1, 2, 8}) {
            const double share = share_of_impulse(force, {"bricks", "implicit_euler", n});
            EXPECT_NEAR(share, (n + 1) / (2.0 * n), 1e-3) << force.kind << n;
        }
        EXPECT_NEAR(share_of_impulse(force, {"bricks", "implicit_midpoint", 1}), 0.5, 1e-3)
            << force.kind;
        if (std::string(force.kind) == "torque") continue;
        EXPECT_NEAR(share_of_impulse(force, {"lattice", "implicit_euler", 4}), 5.0 / 8, 1e-3)
            << force.kind;
    }
}

// What a wind gives a block in a frame of 4 steps, whose number `number` grows from nothing in it,
// or is as at its end all through it.
double impulse_of_wind(const char* number, bool grows)
{
    const Value cubes = block(1e7);
    NodeRun force("Force"), simulate("Simulate");
    force.param("kind").is = std::string("wind");
    force.param("wind.velocity").is = Vector{10, 0, 0};
    if (grows) {
        NodeRun before = force;
        before.param(number).is = 0.0;
        force.previous = {before.run()};
    }
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["forces"] = {force.run()};
    simulate.param("gravity").is = Vector{0, 0, 0};
    simulate.param("step.substeps").is = std::int64_t{4};
    simulate.param("step.tolerance").is = 1e-9;
    simulate.previous = {simulate.run()};
    const auto state = simulate.run().as<physics::State>();
    return fixtures::brick_motion(*cubes.as<geometry::Cubes>(), *state).linear.x();
}

// The block is so heavy that the wind meets it as it does one at rest.
TEST(Force, WindOfAGrowingDensityOrDragGrowsEvenlyWithinAFrame)
{
    for (const char* number : {"wind.air_density", "wind.drag"}) {
        EXPECT_NEAR(impulse_of_wind(number, true) / impulse_of_wind(number, false), 5.0 / 8, 1e-3)
            << number;
    }
}

TEST(Force, RadiusChangesEvenlyWithinAFrame)
{
    NodeRun force("Force");
    force.param("kind").is = std::string("point");
    force.param("point.radius").is = 1.0;
    force.previous = {force.run()};
    force.param("point.radius").is = 3.0;
    const auto changed = force.run().as<physics::Force>();
    EXPECT_EQ(changed->at(0).radius, 1);
    EXPECT_EQ(changed->at(0.5).radius, 2);
    EXPECT_EQ(changed->at(1).radius, 3);
}

// As a Force of that kind does.
// Sizes of then: those of a frame are passed at the means of speeds and sizes at its ends.
TEST(Gusts, PassByTheWindAndTheSizesOfThen)
{
    NodeRun gusts("Gusts");
    gusts.param("velocity").is = Vector{2, 0, 0};
    gusts.param("gusts").is = 1.0;
    gusts.param("size").is = 1.0;
    gusts.previous = {gusts.run()};
    gusts.param("velocity").is = Vector{4, 0, 0};
    gusts.param("gusts").is = 2.0;
    gusts.param("size").is = 3.0;
    const auto value = gusts.run();
    const auto& force = *value.as<physics::Force>();
    EXPECT_DOUBLE_EQ(force.gusts.carried.x(), 3.0 / 2 / 24);
    EXPECT_DOUBLE_EQ(force.gusts.time, 1.5 / 2 / 24);
}

TEST(Simulate, GravityChangesEvenlyWithinAFrame)
{
    const Value cubes = block(1e7);
    for (const char* method : {"bricks", "lattice"}) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {cubes};
        simulate.param("method").is = std::string(method);
        simulate.param("step.substeps").is = std::int64_t{4};
        simulate.param("step.tolerance").is = 1e-9;
        const auto speed_after = [&](double from, double to) {
            simulate.param("gravity").is = Vector{0, -from, 0};
            simulate.previous.assign(1, {});
            simulate.previous = {simulate.run()};
            simulate.param("gravity").is = Vector{0, -to, 0};
            const auto state = simulate.run().as<physics::State>();
            return -mean_velocity(*cubes.as<geometry::Cubes>(), *state).y();
        };
        EXPECT_NEAR(speed_after(8, 8), 8.0 / 24, 1e-3) << method;
        EXPECT_NEAR(speed_after(0, 8), 5.0 / 8 * 8 / 24, 1e-3) << method;
        EXPECT_NEAR(speed_after(8, 0), 3.0 / 8 * 8 / 24, 1e-3) << method;
    }
}

// A bar that is pushed to and fro at its free end, held at the other: how far that is pushed at the
// end. The energy that the midpoint rule is to keep must know of what forces change.
double pushed(int substeps)
{
    const Value cubes = Value::of(fixtures::box(8, 2, 2, 0.1, {.density = 1000, .young = 1e5}));
    NodeRun pin("Pin");
    pin.param("where").is = std::string("ends");
    pin.param("ends.axis").is = std::string("x");
    pin.param("ends.end").is = std::string("low");
    const Value pins = pins_of(pin, cubes);
    NodeRun force("Force"), simulate("Simulate");
    force.param("kind").is = std::string("point");
    force.param("point.position").is = Vector{0.8, 0.1, 0.1};
    force.param("point.force").is = Vector{0, 0, 0};
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = {pins};
    simulate.param("gravity").is = Vector{0, 0, 0};
    simulate.param("step.integrator").is = std::string("implicit_midpoint");
    simulate.param("step.substeps").is = std::int64_t{substeps};
    Value push = force.run();
    simulate.inputs["forces"] = {push};
    simulate.previous = {simulate.run()};
    for (int frame = 1; frame <= 9; ++frame) {
        force.previous = {push};
        force.param("point.force").is = Vector{20 * std::sin(0.7 * frame), 0, 0};
        push = force.run();
        simulate.inputs["forces"] = {push};
        simulate.previous = {simulate.run()};
    }
    const auto state = simulate.previous[0].as<physics::State>();
    double most = 0;
    for (const Vec3& x : state->x) most = std::max(most, x.x());
    return most - 0.8;
}
TEST(Force, ThatChangesConvergesWithSubsteps)
{
    const double fine = pushed(64);
    EXPECT_GT(std::abs(fine), 1e-4);
    EXPECT_NEAR(pushed(16), fine, 0.01 * std::abs(fine));
    EXPECT_NEAR(pushed(32), fine, 0.004 * std::abs(fine));
}

TEST(Force, IsTheSameValueInEachFrameWhileItDoesNotChange)
{
    NodeRun force("Force");
    const Value first = force.run();
    force.previous = {first};
    EXPECT_FALSE(force.run().as<physics::Force>()->before);
    force.param("gravity.acceleration").is = Vector{0, -1, 0};
    const auto changed = force.run().as<physics::Force>();
    ASSERT_TRUE(changed->before);
    EXPECT_EQ(changed->before->acceleration, Vec3(0, -9.81, 0));
}

// Set off at 1 m/s on ice it goes on; with friction mu it stops after v^2 / (2 mu g).
TEST(Ground, SupportsABlockAndSlowsItByFriction)
{
    for (const double friction : {0.0, 0.4}) {
        const Value cubes = block(1e7);
        NodeRun ground("Ground");
        ground.param("height").is = -0.001;
        ground.param("friction").is = friction;
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {cubes};
        simulate.inputs["colliders"] = {ground.run()};
        simulate.param("initial_velocity").is = Vector{1, 0, 0};
        simulate.param("step.substeps").is = std::int64_t{8};
        Value state = simulate.run();
        for (int i = 0; i < 12; ++i) {
            simulate.previous = {state};
            state = simulate.run();
        }
        const auto end = state.as<physics::State>();
        const double gone = mean_of(end->x, *cubes.as<geometry::Cubes>()).x() - 0.5;
        const double way = friction > 0 ? 1 / (2 * friction * 9.81) : 0.5;
        // Steps of 1/192 s, and the landing from a millimetre up.
        EXPECT_NEAR(gone, way, friction > 0 ? 0.06 * way : 1e-6) << friction;
        EXPECT_NEAR(end->x[0].y(), -0.001, 0.002);
        EXPECT_LT(mean_velocity(*cubes.as<geometry::Cubes>(), *end).cwiseAbs().y(), 0.02);
    }
}

// Thrown down at 5 m/s from half a metre above what bounces by 0.6: half a second later it rises.
TEST(Loads, BodiesBounceOffGroundAndColliderByTheirShare)
{
    const Value cubes = block(1e9);
    for (const char* const type : {"Ground", "Collider"}) {
        NodeRun obstacle(type);
        obstacle.param("bounce").is = 0.6;
        if (std::string(type) == "Ground")
            obstacle.param("height").is = -0.5;
        else
            obstacle.param("translate").is = Vector{0, -0.5, 0};
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {cubes};
        simulate.inputs["colliders"] = {obstacle.run()};
        simulate.param("gravity").is = Vector{0, 0, 0};
        simulate.param("initial_velocity").is = Vector{0, -5, 0};
        Value state = simulate.run();
        for (int i = 0; i < 12; ++i) {
            simulate.previous = {state};
            state = simulate.run();
        }
        const auto end = state.as<physics::State>();
        EXPECT_NEAR(mean_velocity(*cubes.as<geometry::Cubes>(), *end).y(), 3, 0.1) << type;
    }
}

TEST(Loads, BounceThatHasNoEffectIsTold)
{
    NodeRun ground("Ground");
    ground.param("bounce").is = 0.6;
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {block()};
    simulate.inputs["colliders"] = {ground.run()};
    simulate.param("method").is = std::string("lattice");
    const Value first = simulate.run();
    simulate.previous = {first};
    simulate.run();
    EXPECT_TRUE(
        std::any_of(simulate.warnings.begin(), simulate.warnings.end(), [](const std::string& w) {
            return w.starts_with("bounce of colliders has no effect");
        }));
}

}  // namespace
