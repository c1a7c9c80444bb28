// What Render draws of forces.

#include "geometry/mesh/primitive.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;
using geometry::Vec3f;

// A picture on black.
NodeRun picture_of(const physics::Force& force)
{
    NodeRun render("Render");
    render.param("width").is = std::int64_t{192};
    render.param("height").is = std::int64_t{96};
    render.param("look").is = std::string("plain");
    render.param("ground.kind").is = std::string("none");
    render.param("backdrop.top").is = std::array<double, 3>{0, 0, 0};
    render.param("backdrop.horizon").is = std::array<double, 3>{0, 0, 0};
    render.inputs["forces"] = {graph::Value::of(force)};
    return render;
}

struct Blue {
    int count = 0;
    double from_middle = 0;  // pixels to the right, their mean
};

// The pixels of arrows.
Blue blue_in(NodeRun& render)
{
    const auto image = render.run().as<::render::Image>();
    Blue out;
    double sum = 0;
    for (std::size_t i = 0; i < image->rgba.size(); i += 4) {
        if (int(image->rgba[i + 2]) - int(image->rgba[i]) < 30) continue;
        sum += double(i / 4 % 192) - 95.5, ++out.count;
    }
    out.from_middle = out.count > 0 ? sum / out.count : 0;
    return out;
}

// Right of the middle: the body has moved there, and its force with it.
TEST(RenderForces, TheArrowOfAForceIsWhereTheMaterialIs)
{
    physics::Force force;
    force.kind = physics::Force::Kind::point;
    force.force = {0, -1e6, 0};
    force.position = {0.5, 1, 0.5};
    NodeRun render = picture_of(force);
    render.param("camera.kind").is = std::string("look_at");
    render.param("camera.eye").is = std::array<double, 3>{1.5, 1, 9};
    render.param("camera.target").is = std::array<double, 3>{1.5, 1, 0};
    render.param("cube.draw").is = std::string("none");
    const geometry::Cubes cubes = fixtures::box(2, 2, 2, 0.5);
    render.inputs["cubes"] = {graph::Value::of(cubes)};
    EXPECT_LT(blue_in(render).from_middle, -5);
    physics::State state;
    for (const Vec3& p : geometry::corner_positions(cubes)) state.x.push_back(p + Vec3(2, 0, 0));
    state.v.resize(state.x.size(), Vec3::Zero());
    render.inputs["state"] = {graph::Value::of(state)};
    EXPECT_GT(blue_in(render).from_middle, 5);
    // Without cubes a mesh tells.
    render.inputs["cubes"].clear(), render.inputs["state"].clear();
    const geometry::TriMesh rest = geometry::box({1, 1, 1}, {1, 1, 1});
    geometry::TriMesh moved = rest;
    for (Vec3f& p : moved.positions) p.x() += 2;
    render.inputs["rest"] = {graph::Value::of(rest)};
    render.inputs["mesh"] = {graph::Value::of(rest)};
    EXPECT_LT(blue_in(render).from_middle, -5);
    render.inputs["mesh"] = {graph::Value::of(moved)};
    EXPECT_GT(blue_in(render).from_middle, 5);
}

// With nothing else to set the stage.
TEST(RenderForces, EachKindIsSeenAlone)
{
    using Kind = physics::Force::Kind;
    physics::Force force;
    force.force = force.torque = force.velocity = {0, 8, 0};
    force.outward = 3;
    force.position = {3, 1, 0};
    for (const Kind kind : {Kind::gravity, Kind::wind, Kind::point, Kind::torque, Kind::radial}) {
        force.kind = kind;
        NodeRun render = picture_of(force);
        render.param("camera.margin").is = 0.3;
        EXPECT_GT(blue_in(render).count, 5) << int(kind);
    }
}

}  // namespace
