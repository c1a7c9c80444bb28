// Joint, through the nodes.

#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using fixtures::NodeRun;
using geometry::Cubes;
using geometry::Vec3;
using graph::Value;
using Vector = std::array<double, 3>;

Cubes bar_at(double x)
{
    Cubes out = fixtures::box(4, 1, 1, 0.1);
    out.origin = Vec3(x, 0, 0);
    return out;
}

NodeRun joint_at(double x, const std::vector<Value>& cubes)
{
    NodeRun out("Joint");
    out.inputs["cubes"] = cubes;
    out.param("position").is = Vector{x, 0.05, 0.05};
    return out;
}

TEST(Joint, LinksBodiesOfSimulate)
{
    const Value left = Value::of(bar_at(0)), right = Value::of(bar_at(0.42));
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {left};
    pin.param("where").is = std::string("below");
    pin.param("below.height").is = 1.0;
    const Value held = pin.run();
    const auto fallen = [&](bool joined) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {left, right};
        simulate.inputs["pins"] = {held};
        if (joined) simulate.inputs["joints"] = {joint_at(0.41, {left, right}).run()};
        simulate.previous = {simulate.run()};
        Vec3 lowest = Vec3::Zero();
        for (int frame = 2; frame < 12; ++frame) simulate.previous = {simulate.run(frame)};
        const auto state = simulate.previous[0].as<physics::State>();
        for (std::size_t k = 20; k < 40; ++k) lowest = lowest.cwiseMin(state->x[k]);
        return lowest.y();
    };
    EXPECT_LT(fallen(false), -0.8);  // of 0.86 m
    EXPECT_GT(fallen(true), -0.5);   // it hangs by its end
}

TEST(Joint, OfOneModelTakesItsTwoNearestParts)
{
    // Three bars in a row as parts of one model.
    Cubes all = fixtures::box(14, 1, 1, 0.1);
    std::vector<std::uint8_t> keep(14, 1);
    keep[4] = keep[9] = 0;
    const Value cubes = Value::of(geometry::kept(all, keep));
    NodeRun joint = joint_at(0.45, {cubes});
    const auto made = joint.run().as<physics::PartJoint>();
    ASSERT_EQ(made->points.size(), 1u);
    EXPECT_TRUE(joint.warnings.empty());
    NodeRun far = joint_at(3, {cubes});
    EXPECT_THROW(far.run(), std::invalid_argument);
}

TEST(Joint, WarnsOfAThirdPartThatItLeavesOut)
{
    const Cubes bar = bar_at(0);
    Cubes three = bar;
    for (int copy = 1; copy < 3; ++copy) {  // which share their cells and no corners
        const auto first = static_cast<std::uint32_t>(three.corner_count());
        three.corner.insert(three.corner.end(), bar.corner.begin(), bar.corner.end());
        for (std::size_t c = 0; c < bar.count(); ++c) {
            three.cell.push_back(bar.cell[c]);
            three.corners.push_back(bar.corners[c]);
            for (auto& k : three.corners.back()) k += first;
        }
        const auto twice = [&](auto& to, const auto& from) {
            to.insert(to.end(), from.begin(), from.end());
        };
        twice(three.mass, bar.mass), twice(three.fill, bar.fill), twice(three.young, bar.young);
        twice(three.poisson, bar.poisson), twice(three.mass_damping, bar.mass_damping);
        twice(three.stiffness_damping, bar.stiffness_damping), twice(three.matter, bar.matter);
    }
    NodeRun joint = joint_at(0.25, {Value::of(three)});
    joint.run();
    ASSERT_EQ(joint.warnings.size(), 1u);
    EXPECT_NE(joint.warnings[0].find("one more part"), std::string::npos) << joint.warnings[0];
}

TEST(Joint, WarnsOfAWidthBeyondAPart)
{
    const Value block = Value::of(bar_at(0)), bar = [] {
        Cubes out = fixtures::box(16, 4, 4, 0.025);
        out.origin = Vec3(0.42, 0, 0);
        return Value::of(out);
    }();
    NodeRun joint = joint_at(0.41, {block, bar});
    joint.param("kind").is = std::string("weld");
    joint.run();
    EXPECT_TRUE(joint.warnings.empty());
    joint.param("size").is = 0.4;
    joint.run();
    ASSERT_EQ(joint.warnings.size(), 1u);
    EXPECT_NE(joint.warnings[0].find("beyond part 2, whose cubes have edges of 0.025 m"),
              std::string::npos)
        << joint.warnings[0];
}

TEST(Joint, GluesPartsThatTouchAndWarnsOfOneThatTouchesNone)
{
    Cubes far = fixtures::box(5, 1, 1, 0.1);
    std::vector<std::uint8_t> keep(5, 1);
    keep[1] = 0;  // a cube that touches the bar, and three beyond a gap
    far.origin = Vec3(0.4, 0, 0);
    NodeRun joint("Joint");
    joint.inputs["cubes"] = {Value::of(bar_at(0)), Value::of(geometry::kept(far, keep))};
    joint.param("kind").is = std::string("glue");
    const Value made = joint.run();
    EXPECT_EQ(made.as<physics::PartJoint>()->points.size(), 4u);
    ASSERT_EQ(joint.warnings.size(), 1u);
    EXPECT_EQ(joint.warnings[0],
              "1 of 3 parts of `cubes` is glued to none, as no other comes within reach: raise "
              "reach, or leave it out of `cubes`");
}

TEST(Joint, OfOtherCubesIsRefused)
{
    const Value left = Value::of(bar_at(0)), right = Value::of(bar_at(0.42));
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {left, Value::of(bar_at(0.43))};
    simulate.inputs["joints"] = {joint_at(0.41, {left, right}).run()};
    EXPECT_THROW(simulate.run(), std::invalid_argument);
}

}  // namespace
