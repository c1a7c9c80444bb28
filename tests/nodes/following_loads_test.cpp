// Pressure, torques and forces that follow the body, against closed forms.

#include "geometry/mesh/mesh.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;
using graph::Value;
using Vector = std::array<double, 3>;

// A box wound outwards, of twelve triangles: two a side, in the order of -x, +x, -y, +y, -z, +z, of
// which the first is of the material "piston".
geometry::TriMesh box_mesh(const Vec3& from, const Vec3& to)
{
    geometry::TriMesh mesh;
    for (unsigned a = 0; a < 8; ++a) {
        mesh.positions.push_back(
            Vec3(a & 1 ? to.x() : from.x(), a & 2 ? to.y() : from.y(), a & 4 ? to.z() : from.z())
                .cast<float>());
    }
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                           {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    topology->materials = {{.name = "rest"}, {.name = "piston"}};
    topology->material = {1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    mesh.topology = std::move(topology);
    return mesh;
}

void turn_face(geometry::TriMesh& mesh, std::size_t face)
{
    auto topology = *mesh.topology;
    std::swap(topology.triangles[face][1], topology.triangles[face][2]);
    mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
}

NodeRun pressure_on(const Value& cubes, geometry::TriMesh mesh, double pascal)
{
    NodeRun pressure("Pressure");
    pressure.inputs["cubes"] = {cubes};
    pressure.inputs["mesh"] = {Value::of(std::move(mesh))};
    pressure.param("pressure").is = pascal;
    return pressure;
}

NodeRun simulation(const Value& cubes, const Value& force)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["forces"] = {force};
    simulate.param("gravity").is = Vector{0, 0, 0};
    simulate.param("step.tolerance").is = 1e-10;
    return simulate;
}

Value after(NodeRun& simulate, int frames)
{
    Value state = simulate.run();
    for (int i = 0; i < frames; ++i) {
        simulate.previous = {state};
        state = simulate.run();
    }
    return state;
}

double measured(const char* what, const Value& state, const Value& cubes, const Vector& direction)
{
    NodeRun measure("Measure");
    measure.inputs["state"] = {state};
    measure.inputs["cubes"] = {cubes};
    measure.param("what").is = std::string(what);
    measure.param("direction").is = direction;
    return *measure.run().as<double>();
}

Value roller(const Value& cubes, const std::string& axis)
{
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {cubes};
    pin.param("where").is = std::string("ends");
    pin.param("ends.axis").is = axis;
    pin.param("ends.end").is = std::string("low");
    pin.param("ends.layers").is = std::int64_t{0};
    pin.param("axes").is = axis;
    return pin.run();
}

// Of a cube under a pressure p: by the side, 3 K e = -p (1 + e)^2, as the area that p acts on
// shrinks with it and K is that of the rest shape. To first order p (1 - 2 nu) / E.
double squeezed(double pressure, double young, double poisson)
{
    double e = 0;
    for (int i = 0; i < 50; ++i) e = -pressure * (1 - 2 * poisson) / young * (1 + e) * (1 + e);
    return e;
}

TEST(Pressure, ShrinksAFreeCubeEvenlyWhereItIs)
{
    const Value cubes = Value::of(
        fixtures::box(4, 4, 4, 0.25, {.young = 1e6, .poisson = 0.3, .stiffness_damping = 0.02}));
    NodeRun pressure = pressure_on(cubes, box_mesh(Vec3::Zero(), Vec3::Ones()), 1e4);
    NodeRun simulate = simulation(cubes, pressure.run());
    const Value state = after(simulate, 24);
    EXPECT_TRUE(pressure.warnings.empty());
    EXPECT_TRUE(simulate.warnings.empty());
    const double e = squeezed(1e4, 1e6, 0.3);
    EXPECT_NEAR(e, -1e4 * 0.4 / 1e6, 5e-5);
    const auto x = state.as<physics::State>()->x;
    const Vec3 middle = Vec3::Constant(0.5);
    for (std::uint32_t k = 0; k < x.size(); ++k) {
        const Vec3 rest = cubes.as<geometry::Cubes>()->corner_position(k);
        EXPECT_LT((x[k] - middle - (1 + e) * (rest - middle)).norm(), 1e-8) << k;
    }
    // 1e-12 of p A = 6e4 N, over a second; the turn, as far as the solver's tolerance leaves it.
    for (const Vector& axis : {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}}) {
        EXPECT_NEAR(measured("momentum", state, cubes, axis), 0, 6e-8);
        EXPECT_NEAR(measured("angular_momentum", state, cubes, axis), 0, 6e-6);
    }
}

TEST(Pressure, AnEquilibriumBetweenPlanesOfSymmetryIsThatOfTheClosedForm)
{
    // The faces with x, y, z = 0 are the planes, and need no pressure.
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 0.5, {.young = 1e6, .poisson = 0.3}));
    NodeRun pressure = pressure_on(cubes, box_mesh(Vec3::Zero(), Vec3::Ones()), 5e4);
    NodeRun simulate = simulation(cubes, pressure.run());
    simulate.inputs["pins"] = {roller(cubes, "x"), roller(cubes, "y"), roller(cubes, "z")};
    simulate.param("initial_shape").is = std::string("equilibrium");
    const auto x = simulate.run().as<physics::State>()->x;
    EXPECT_TRUE(simulate.warnings.empty());
    const double e = squeezed(5e4, 1e6, 0.3);
    for (std::uint32_t k = 0; k < x.size(); ++k) {
        const Vec3 rest = cubes.as<geometry::Cubes>()->corner_position(k);
        EXPECT_LT((x[k] - (1 + e) * rest).norm(), 1e-6) << k;
    }
}

// a = p A / m = 1 m/s^2, turning with the box at w = 2 pi / s for a quarter of a turn:
// v = a / w (sin wt, 1 - cos wt) = a / w (1, 1). Steps of 1/384 s see the way they begin with, half
// a step behind: 2 pi / 768 = 0.8 %.
template <class Force> void pushes_along_the_turned_face(const Value& cubes, const Force& force)
{
    NodeRun simulate = simulation(cubes, force);
    simulate.param("initial_spin_degrees").is = Vector{0, 0, 360};
    simulate.param("step.substeps").is = std::int64_t{16};
    const Value state = after(simulate, 6);
    const double a_over_w = 1 / (2 * std::numbers::pi);
    EXPECT_NEAR(measured("momentum", state, cubes, {1, 0, 0}), 1000 * a_over_w, 10 * a_over_w);
    EXPECT_NEAR(measured("momentum", state, cubes, {0, 1, 0}), 1000 * a_over_w, 10 * a_over_w);
    EXPECT_NEAR(measured("momentum", state, cubes, {0, 0, 1}), 0, 1e-3);
}

TEST(Pressure, OnOneFacePushesABoxAlongAsItTurns)
{
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 0.5, {.young = 1e9}));
    NodeRun pressure = pressure_on(cubes, box_mesh(Vec3::Zero(), Vec3::Ones()), 1000);
    pressure.param("part").is = std::string("piston");
    NodeRun straight = simulation(cubes, pressure.run());
    EXPECT_NEAR(measured("momentum", after(straight, 3), cubes, {1, 0, 0}), 1000 * 3.0 / 24, 0.01);
    pushes_along_the_turned_face(cubes, pressure.run());
}

TEST(Force, ThatFollowsTurnsWithTheBody)
{
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 0.5, {.young = 1e9}));
    NodeRun force("Force");
    force.param("kind").is = std::string("point");
    force.param("point.force").is = Vector{1000, 0, 0};
    force.param("point.position").is = Vector{0.5, 0.5, 0.5};
    force.param("point.radius").is = 1.0;
    force.param("point.follow").is = true;
    pushes_along_the_turned_face(cubes, force.run());
}

TEST(Pressure, TakesFacesTheRightWayRoundAndTellsHowMany)
{
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 0.5, {.young = 1e9}));
    const auto momentum_and_warning = [&](geometry::TriMesh mesh) {
        NodeRun pressure = pressure_on(cubes, std::move(mesh), 1000);
        pressure.param("part").is = std::string("piston");
        NodeRun simulate = simulation(cubes, pressure.run());
        return std::pair(measured("momentum", after(simulate, 1), cubes, {1, 0, 0}),
                         pressure.warnings.empty() ? "" : pressure.warnings[0]);
    };
    const geometry::TriMesh mesh = box_mesh(Vec3::Zero(), Vec3::Ones());
    const double expected = momentum_and_warning(mesh).first;
    geometry::TriMesh one = mesh, all = mesh;
    turn_face(one, 0);
    for (std::size_t i = 0; i < 12; ++i) turn_face(all, i);
    const auto of_one = momentum_and_warning(one), of_all = momentum_and_warning(all);
    EXPECT_EQ(of_one.first, expected);
    EXPECT_EQ(of_all.first, expected);
    EXPECT_EQ(of_one.second.rfind("1 of 12 faces of the mesh are wound inwards", 0), 0u);
    EXPECT_EQ(of_all.second.rfind("12 of 12 faces of the mesh are wound inwards", 0), 0u);
}

// A box a metre wide with a hollow of half that, which is wound towards its middle.
struct Hollow {
    Hollow()
    {
        std::vector<geometry::Vec3i> cells;
        for (const auto& cell : fixtures::box(4, 4, 4, 0.25).cell) {
            if ((cell.array() == 0 || cell.array() == 3).any()) cells.push_back(cell);
        }
        cubes = Value::of(fixtures::cubes_on(cells, 0.25, {.young = 1e6}));
        mesh = box_mesh(Vec3::Zero(), Vec3::Ones());
        const auto inner = box_mesh(Vec3::Constant(0.25), Vec3::Constant(0.75));
        auto topology = *mesh.topology;
        topology.materials.push_back({.name = "hollow"});
        for (const auto& [a, b, c] : inner.triangles()) {
            topology.triangles.push_back({a + 8, c + 8, b + 8});
            topology.material.push_back(2);
        }
        mesh.positions.insert(mesh.positions.end(), inner.positions.begin(), inner.positions.end());
        mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    }
    Value cubes;
    geometry::TriMesh mesh;
};

TEST(Pressure, OfAHollowBlowsItUpAndComesToRest)
{
    // At a twentieth of Young's modulus: the outside bulges, and swings no more after a second.
    const Hollow hollow;
    NodeRun pressure = pressure_on(hollow.cubes, hollow.mesh, 5e4);
    pressure.param("part").is = std::string("hollow");
    NodeRun simulate = simulation(hollow.cubes, pressure.run());
    const Value state = after(simulate, 36);
    EXPECT_TRUE(pressure.warnings.empty());
    EXPECT_TRUE(simulate.warnings.empty());
    EXPECT_LT(measured("speed_max", state, hollow.cubes, {1, 0, 0}), 1e-3);
    const auto x = state.as<physics::State>()->x;
    double lowest = 1, highest = 0;
    for (const Vec3& p : x) lowest = std::min(lowest, p.x()), highest = std::max(highest, p.x());
    EXPECT_GT(highest - lowest, 1.01);
    EXPECT_LT(highest - lowest, 1.2);
    EXPECT_NEAR(highest + lowest, 1, 1e-6);  // both sides alike

    pressure.param("pressure").is = 2e5;
    NodeRun high = simulation(hollow.cubes, pressure.run());
    after(high, 1);
    ASSERT_FALSE(high.warnings.empty());
    EXPECT_EQ(high.warnings[0].rfind("force 1 of 1 is a pressure of more than a tenth", 0), 0u);
}

TEST(Torque, TurnsAFreeBoxByItsInertia)
{
    // T t of angular momentum, and T t / I of spin: I = m (a^2 + b^2) / 12 = 1000 / 6 kg m^2, which
    // four bricks across have within half a percent.
    const Value cubes = Value::of(fixtures::box(4, 4, 4, 0.25, {.young = 1e9}));
    NodeRun torque("Force");
    torque.param("kind").is = std::string("torque");
    torque.param("torque.torque").is = Vector{0, 0, 50};
    torque.param("torque.position").is = Vector{0.5, 0.5, 0.5};
    torque.param("torque.radius").is = 1.0;
    NodeRun simulate = simulation(cubes, torque.run());
    const Value state = after(simulate, 6);
    EXPECT_NEAR(measured("angular_momentum", state, cubes, {0, 0, 1}), 50 * 0.25, 1e-3);
    for (const Vector& axis : {Vector{1, 0, 0}, Vector{0, 1, 0}, Vector{0, 0, 1}}) {
        EXPECT_NEAR(measured("momentum", state, cubes, axis), 0, 1e-9);
    }
    // The last corner is half a metre off along each axis: v = w cross r.
    const auto moved = state.as<physics::State>();
    const double spin = (moved->v.back() - moved->v.front()).head<2>().norm() / std::sqrt(2);
    const double expected = 50 * 0.25 * 6 / 1000;
    EXPECT_NEAR(spin, expected, 0.02 * expected);
}

TEST(Torque, AtTheEndOfACantileverBendsItIntoACircle)
{
    // Of radius E I / M = 1e7 * 0.1^4 / 12 / M = 2 m: one radian of a beam 2 m long.
    const Value cubes = Value::of(fixtures::box(40, 2, 2, 0.05, {.young = 1e7, .poisson = 0}));
    NodeRun torque("Force");
    torque.param("kind").is = std::string("torque");
    torque.param("torque.torque").is = Vector{0, 0, 1e7 * 1e-4 / 12 / 2};
    torque.param("torque.position").is = Vector{2, 0.05, 0.05};
    torque.param("torque.radius").is = 0.1;
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {cubes};
    pin.param("where").is = std::string("ends");
    pin.param("ends.end").is = std::string("low");
    pin.param("ends.layers").is = std::int64_t{0};
    NodeRun simulate = simulation(cubes, torque.run());
    simulate.inputs["pins"] = {pin.run()};
    simulate.param("initial_shape").is = std::string("equilibrium");
    simulate.param("step.tolerance").is = 1e-6;
    const auto x = simulate.run().as<physics::State>()->x;
    EXPECT_TRUE(simulate.warnings.empty());
    Vec3 tip = Vec3::Zero();
    for (std::uint32_t k = 0; k < x.size(); ++k) {
        if (cubes.as<geometry::Cubes>()->corner[k].x() == 40) tip += x[k] / 9;
    }
    EXPECT_NEAR(tip.x(), 2 * std::sin(1.0), 0.03 * 2);
    EXPECT_NEAR(tip.y() - 0.05, 2 * (1 - std::cos(1.0)), 0.03 * 2);
    EXPECT_NEAR(tip.z(), 0.05, 1e-6);
}

TEST(FollowingLoads, AreRefusedByMethodsThatDoNotTakeThem)
{
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 0.5));
    const Value pressure = pressure_on(cubes, box_mesh(Vec3::Zero(), Vec3::Ones()), 1e3).run();
    NodeRun simulate = simulation(cubes, pressure);
    simulate.param("method").is = std::string("lattice");
    try {
        simulate.run();
        ADD_FAILURE() << "the lattice took it";
    } catch (const std::invalid_argument& error) {
        EXPECT_EQ(std::string(error.what()), "method lattice does not take torques, pressure or "
                                             "forces that follow: unlink the force, "
                                             "or use Simulate with method bricks or springs");
    }
}

TEST(FollowingLoads, AreRefusedWhereTheyWouldActElsewhere)
{
    const auto error_of = [](NodeRun& simulate) -> std::string {
        try {
            after(simulate, 1);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "";
    };
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 0.5));
    const Value finer = Value::of(fixtures::box(4, 4, 4, 0.25));
    NodeRun simulate =
        simulation(finer, pressure_on(cubes, box_mesh(Vec3::Zero(), Vec3::Ones()), 1e3).run());
    EXPECT_EQ(error_of(simulate),
              "a pressure is on other cubes than those that are simulated: link input `cubes` of "
              "Pressure to the same node, as in Simulate");
    // A torque far off, on the nearest corner; of 0 N m, as where it begins to rise, it acts on
    // nothing.
    for (const double torque : {5.0, 0.0}) {
        NodeRun force("Force");
        force.param("kind").is = std::string("torque");
        force.param("torque.torque").is = Vector{0, 0, torque};
        force.param("torque.position").is = Vector{5, 5, 5};
        force.param("torque.radius").is = 0.01;
        NodeRun turned = simulation(cubes, force.run());
        EXPECT_EQ(error_of(turned),
                  torque == 0 ? ""
                              : "a torque at (5, 5, 5) of radius 0.01 m reaches only a point or a "
                                "line of the body at rest, which it cannot turn: move it to the "
                                "body, or raise its radius");
    }
}

}  // namespace
