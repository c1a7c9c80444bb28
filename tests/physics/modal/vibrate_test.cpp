#include "geometry/mesh/mesh.hpp"
#include "physics/modal/vibrate.hpp"

#include "geometry/embed/embed.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <numbers>

using namespace physics;
using geometry::TriMesh;

namespace {

using std::numbers::pi;

// Two vertices and two modes: 1 Hz along x at the first, 3 Hz along y at both.
ModalModel two_modes()
{
    TriMesh mesh;
    mesh.positions = {Vec3f(0, 0, 0), Vec3f(1, 0, 0)};
    ModalModel model;
    model.rest = std::make_shared<const TriMesh>(mesh);
    model.omega_sq = {4 * pi * pi, 36 * pi * pi};
    model.damping = {0, 0};
    model.participation = {Vec3(1, 0, 0), Vec3(0, 2, 0)};
    model.shape = {{Vec3f(1, 0, 0), Vec3f(0, 0, 0)}, {Vec3f(0, 1, 0), Vec3f(0, 1, 0)}};
    model.normal_change = {{}, {}};
    return model;
}

}  // namespace

TEST(Vibrate, AKickedModeSwingsAsASine)
{
    // An impulse of 0.5 N s on the first vertex: q' = 0.5, q = 0.5 / omega sin(omega t), at any
    // frame rate.
    const ModalModel model = two_modes();
    const Kick kick{{0, 0, 0}, {0.5, 0, 0}, 0.01};
    for (const double dt : {1.0 / 24, 0.4}) {
        ModalState state = struck(model, rest_state(model), kick);
        for (int frame = 0; frame < 20; ++frame) {
            state = advance(model, state, {}, Vec3::Zero(), {}, dt);
            EXPECT_NEAR(state.q[0], 0.5 / (2 * pi) * std::sin(2 * pi * state.time), 1e-12);
            EXPECT_NEAR(energy(model, state), 0.125, 1e-12);
        }
        EXPECT_EQ(state.q[1], 0);
    }
}

TEST(Vibrate, DampingIsThatOfItsKind)
{
    // A kicked mode is q = q' / w sin(w t) e^(-d t), w^2 = omega^2 - d^2, with d = ratio * omega,
    // (a + b omega^2) / 2, or half of what the material gave.
    ModalModel model = two_modes();
    model.damping = {0.6, 0};
    const double omega = 2 * pi;
    using Kind = ModalDamping::Kind;
    for (const auto& [damping, d] :
         {std::pair(ModalDamping{.kind = Kind::ratio, .ratio = 0.1}, 0.1 * omega),
          {ModalDamping{.kind = Kind::rayleigh, .mass_damping = 0.2, .stiffness_damping = 0.01},
           (0.2 + 0.01 * omega * omega) / 2},
          {ModalDamping{.kind = Kind::material}, 0.3}}) {
        ModalState state = rest_state(model);
        state.q_dot[0] = 0.5;
        for (int i = 0; i < 7; ++i) state = advance(model, state, {}, Vec3::Zero(), damping, 0.1);
        const double w = std::sqrt(omega * omega - d * d);
        EXPECT_NEAR(state.q[0], 0.5 / w * std::sin(w * 0.7) * std::exp(-d * 0.7), 1e-12);
    }
}

TEST(Vibrate, AConstantForceSagsToItsStaticAnswer)
{
    // q = phi . F / omega^2 once damping has had its time; gravity acts through participation.
    const ModalModel model = two_modes();
    Force push{
        .kind = Force::Kind::point, .force = {3, 0, 0}, .position = {0, 0, 0}, .radius = 0.1};
    Force gravity{.acceleration = {0, -9, 0}};
    const ModalDamping damping{.kind = ModalDamping::Kind::ratio, .ratio = 0.5};
    const std::vector<Force> forces{push, gravity};
    ModalState state = advance(model, rest_state(model), forces, Vec3::Zero(), damping, 100);
    EXPECT_NEAR(state.q[0], 3 / model.omega_sq[0], 1e-12);
    EXPECT_NEAR(state.q[1], -18 / model.omega_sq[1], 1e-12);
}

TEST(Vibrate, AMovedBaseJerksTheBody)
{
    // The base sets off at 2 m/s and stops after a second, a whole period of the first mode: it is
    // jerked by -2 and back by +2 with q where it was, so it comes to rest again.
    const ModalModel model = two_modes();
    ModalState state = rest_state(model);
    state = advance(model, state, {}, Vec3(1, 0, 0), {}, 0.5);
    EXPECT_NEAR(state.q_dot[0], 2, 1e-12);  // half a period after -2
    state = advance(model, state, {}, Vec3(2, 0, 0), {}, 0.5);
    state = advance(model, state, {}, Vec3(2, 0, 0), {}, 0.25);
    EXPECT_NEAR(energy(model, state), 0, 1e-20);
    const TriMesh mesh = deformed(model, state);
    EXPECT_NEAR(mesh.positions[0].x(), 2, 1e-6);
}

TEST(Vibrate, DrawsDisplacementSpeedAndAmplitude)
{
    const ModalModel model = two_modes();
    ModalState state = rest_state(model);
    state.q = {0.25, 0.5};
    state.q_dot = {0, 2};
    const TriMesh mesh = deformed(model, state, 2);
    EXPECT_LT((mesh.positions[0] - Vec3f(0.5f, 1, 0)).norm(), 1e-6f);
    EXPECT_LT((mesh.positions[1] - Vec3f(1, 1, 0)).norm(), 1e-6f);
    ASSERT_EQ(mesh.attributes.size(), 2u);
    EXPECT_FLOAT_EQ(mesh.attributes[0].values[1], 1);
    EXPECT_FLOAT_EQ(mesh.attributes[1].values[1], 4);
    EXPECT_EQ(mesh.topology, model.rest->topology);
}

TEST(Vibrate, AMeshOnCubesFollowsTheirCorners)
{
    // A mesh that is the cubes' corners: shapes are the modes themselves, and the sum of mass times
    // shape the participation. Normals turn with the faces: of unit length, and for a small swing
    // those that embedding finds.
    const geometry::Cubes cubes = fixtures::box(6, 1, 1, 0.1, {});
    TriMesh mesh = geometry::box({0.6, 0.1, 0.1}, {6, 1, 1});
    for (Vec3f& p : mesh.positions) p += Vec3f(0.3f, 0.05f, 0.05f);
    const Modes modes = lowest_modes(cubes, {0, 7, 14, 21}, {.count = 4});
    const auto rest = std::make_shared<const TriMesh>(mesh);
    const ModalModel model = make_modal_model(modes, cubes, rest);
    ASSERT_EQ(model.count(), 4u);
    EXPECT_EQ(model.shape[0].size(), mesh.positions.size());
    ModalState state = rest_state(model);
    state.q[0] = 1e-3;
    const TriMesh moved = deformed(model, state);
    EXPECT_EQ(moved.normals.size(), mesh.normals.size());
    for (const Vec3f& n : moved.normals) EXPECT_NEAR(n.norm(), 1, 1e-6);
    std::vector<Vec3> corners = corner_positions(cubes);
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] += 1e-3 * modes.shape[0][i];
    const TriMesh embedded = embed(geometry::bind(mesh, cubes), mesh, cubes, corners);
    double turned = 0;
    for (std::size_t i = 0; i < moved.normals.size(); ++i) {
        turned = std::max(turned, double((embedded.normals[i] - mesh.normals[i]).norm()));
        EXPECT_LT((moved.normals[i] - embedded.normals[i]).norm(), 1e-4);
    }
    EXPECT_GT(turned, 1.5e-3) << "far more than what is allowed";
    EXPECT_GT(
        *std::max_element(moved.attributes[0].values.begin(), moved.attributes[0].values.end()), 0);
}

TEST(Vibrate, AMeshThatStandsOutOfItsCubesMovesAsEmbedCarriesIt)
{
    // The rod is twice as long as the beam of cubes that carries it.
    const geometry::Cubes cubes = fixtures::box(6, 1, 1, 0.1, {});
    TriMesh mesh = geometry::box({1.2, 0.05, 0.05}, {12, 1, 1});
    for (Vec3f& p : mesh.positions) p += Vec3f(0.6f, 0.05f, 0.05f);
    const Modes modes = lowest_modes(cubes, {0, 7, 14, 21}, {.count = 2});
    const ModalModel model = make_modal_model(modes, cubes, std::make_shared<const TriMesh>(mesh));
    ASSERT_EQ(model.warnings.size(), 1u);
    EXPECT_NE(model.warnings[0].find("vertices lie in no cube of their body"), std::string::npos);
    ModalState state = rest_state(model);
    state.q[0] = 1e-2;
    const TriMesh moved = deformed(model, state);
    std::vector<Vec3> corners = corner_positions(cubes);
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] += 1e-2 * modes.shape[0][i];
    const TriMesh embedded = embed(geometry::bind(mesh, cubes), mesh, cubes, corners);
    double most = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        most = std::max(most, double((embedded.positions[v] - mesh.positions[v]).norm()));
        EXPECT_LT((moved.positions[v] - embedded.positions[v]).norm(), 1e-6) << v;
    }
    EXPECT_GT(most, 1e-3) << "far more than what is allowed";
}

// A sheet of 1 m^2 across x that moves as a whole along x, of `mass` kg on springs of `stiffness`
// N/m.
ModalModel sliding_sheet(double mass, double stiffness)
{
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
    auto faces = std::make_shared<geometry::MeshTopology>();
    faces->triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.topology = faces;
    ModalModel model;
    model.rest = std::make_shared<const TriMesh>(mesh);
    model.omega_sq = {stiffness / mass};
    model.damping = {0};
    model.participation = {Vec3(std::sqrt(mass), 0, 0)};
    model.shape.emplace_back(4, Vec3f(float(1 / std::sqrt(mass)), 0, 0));
    model.normal_change.emplace_back();
    return model;
}

// Air of 1.2 kg/m^3 and drag 2 on one side's half: F = 0.6 u^2 N.
std::vector<Force> wind_along_x(double speed)
{
    return {
        {.kind = Force::Kind::wind, .velocity = Vec3(speed, 3, 0), .air_density = 1.2, .drag = 2}};
}

TEST(Vibrate, WindHoldsASheetAgainstItsSprings)
{
    const ModalModel model = sliding_sheet(2, 500);
    ModalState state = rest_state(model);
    const ModalDamping damping{.kind = ModalDamping::Kind::ratio, .ratio = 0.7};
    for (int i = 0; i < 120; ++i) {
        state = advance(model, state, wind_along_x(-10), Vec3::Zero(), damping, 1.0 / 24);
    }
    // K x = 0.6 u |u_x| along x.
    EXPECT_NEAR(deformed(model, state).positions[0].x(), -0.6 * 100 / 500, 1e-4);
}

// Without springs, v' = -c v |v|: v = v0 / (1 + c v0 t), c = 0.6 / m.
TEST(Vibrate, StillAirSlowsASheetByTheSquareOfItsSpeed)
{
    for (const double mass : {2.0, 0.02}) {
        const ModalModel model = sliding_sheet(mass, 0);
        ModalState state = rest_state(model);
        state.q_dot[0] = 5 * std::sqrt(mass);
        const std::vector<Force> still{
            {.kind = Force::Kind::wind, .velocity = Vec3::Zero(), .air_density = 1.2, .drag = 2}};
        for (int i = 0; i < 24; ++i) {
            state = advance(model, state, still, Vec3::Zero(), {}, 1.0 / 24);
            const double v = 5 / (1 + 0.6 / mass * 5 * (i + 1) / 24);
            EXPECT_NEAR(state.q_dot[0] / std::sqrt(mass), v, (mass > 1 ? 0.03 : 0.1) * v) << i;
        }
    }
    // What its base leaves behind stands still in the air.
    const ModalModel model = sliding_sheet(2, 0);
    const ModalState left =
        advance(model, rest_state(model), wind_along_x(0), Vec3(0.5, 0, 0), {}, 0.1);
    EXPECT_NEAR(left.q_dot[0], -5 * std::sqrt(2.0), 1e-6);
}

TEST(Vibrate, RefusesBadInputAndSaysWhatWasExpected)
{
    const ModalModel feather = sliding_sheet(1e-9, 1);
    EXPECT_THROW(advance(feather, rest_state(feather), wind_along_x(10), Vec3::Zero(), {}, 0.1),
                 std::invalid_argument);
    const ModalModel model = two_modes();
    EXPECT_THROW(advance(model, {}, {}, Vec3::Zero(), {}, 0.1), std::invalid_argument);
    std::vector<Force> radial(1);
    radial[0].kind = Force::Kind::radial;
    EXPECT_THROW(advance(model, rest_state(model), radial, Vec3::Zero(), {}, 0.1),
                 std::invalid_argument);
    EXPECT_THROW(advance(model, rest_state(model), {}, Vec3::Zero(), {}, 0), std::invalid_argument);
    EXPECT_THROW(deformed(model, {}), std::invalid_argument);
}
