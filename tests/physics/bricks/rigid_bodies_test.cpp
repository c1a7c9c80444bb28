// Parts that keep their shape, in the same steps as parts that do not.

#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/mass_properties.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/elasticity.hpp"
#include "physics/bricks/rigid_part.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/hinged_bar.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace physics {
namespace {

using geometry::Cubes;

constexpr double frame_seconds = 1.0 / 24;

Cubes box_at(const Vec3& origin, int nx, int ny, int nz, double h,
             const fixtures::Stuff& stuff = {.young = 1e10})
{
    Cubes out = fixtures::box(nx, ny, nz, h, stuff);
    out.origin = origin;
    return out;
}

BricksBody rigid_body(const std::vector<Cubes>& of, std::vector<std::uint8_t> rigid,
                      PartContactOptions contact = {})
{
    std::vector<BodyModel> models;
    for (const Cubes& cubes : of) models.push_back({&cubes});
    return make_bricks(BodyModels(models), {.contact = contact, .rigid = std::move(rigid)});
}

Loads on_the_floor(double bounce = 0)
{
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    loads.colliders.back().bounce = bounce;
    return loads;
}

void turn(const Vec3& by, State& state)
{
    Vec3 centre = Vec3::Zero();
    for (const Vec3& x : state.x) centre += x / static_cast<double>(state.x.size());
    const Eigen::AngleAxisd turn(by.norm(), by.normalized());
    for (Vec3& x : state.x) x = centre + turn * (x - centre);
}

// At two turns a second, one step a frame: momenta to the solver's rounding, shape to that of
// numbers, energy to what the midpoint rule on rotations makes of it.
TEST(RigidBodies, TumbleWithTheirMomentaAndTheirShape)
{
    const Cubes cubes = fixtures::box(1, 4, 2, 0.1, {.young = 1e9});
    const BricksBody body = rigid_body({cubes}, {1});
    State state = rest_state(body);
    const Vec3 centre(0.05, 0.2, 0.1), spin(3, 4, 11);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        state.v[k] = Vec3(1, 2, 3) + spin.cross(state.x[k] - centre);
    }
    const auto first = fixtures::brick_motion(cubes, state);
    for (int frame = 0; frame < 240; ++frame) {
        state = advance(body, state, {}, frame_seconds);
        ASSERT_TRUE(state.report.converged);
    }
    const auto last = fixtures::brick_motion(cubes, state);
    EXPECT_LT((last.linear - first.linear).norm(), 1e-9 * first.linear.norm());
    EXPECT_LT((last.angular - first.angular).norm(), 1e-9 * first.angular.norm());
    EXPECT_NEAR(last.energy, first.energy, 0.01 * first.energy);
    EXPECT_LT(fixtures::shape_error(cubes, state), 1e-12);
}

TEST(RigidBodies, SwingOnAHingeOfTwoPinnedCorners)
{
    const fixtures::HingedBar bar({});
    const BricksBody body = rigid_body({bar.cubes}, {1});
    State state = rest_state(body);
    const auto turns = bar.turns(body, state, 1.0 / 240, 700);
    ASSERT_EQ(turns.size(), 4u);
    EXPECT_NEAR(turns[3] / 2, bar.period, 0.01 * bar.period);
    const Pins& pins = bar.loads.pins;
    for (std::size_t p = 0; p < 2; ++p) {
        EXPECT_LT((state.x[pins.corner[p]] - pins.target[p]).norm(), 1e-4);
    }
    EXPECT_LT(fixtures::shape_error(bar.cubes, state), 1e-12);
}

TEST(RigidBodies, GoWhereThreePinnedCornersTakeThem)
{
    const Cubes cubes = fixtures::box(2, 2, 2, 0.1);
    const BricksBody body = rigid_body({cubes}, {1});
    State state = rest_state(body);
    const Eigen::AngleAxisd turn(0.3, Vec3(1, 2, 3).normalized());
    Loads loads;
    loads.forces.push_back({});
    for (const std::uint32_t k : {0u, 2u, 26u}) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(turn * cubes.corner_position(k) + Vec3(0.1, 0, 0));
    }
    for (int frame = 0; frame < 12; ++frame) state = advance(body, state, loads, frame_seconds);
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        const Vec3 wanted = turn * cubes.corner_position(k) + Vec3(0.1, 0, 0);
        EXPECT_LT((state.x[k] - wanted).norm(), 1e-5);
    }
}

TEST(RigidBodies, StandInAStackOfTen)
{
    std::vector<Cubes> boxes;
    for (int i = 0; i < 10; ++i) boxes.push_back(box_at({0, 0.2 * i, 0}, 2, 2, 2, 0.1));
    const BricksBody body = rigid_body(boxes, std::vector<std::uint8_t>(10, 1));
    State state = rest_state(body);
    const State start = state;
    int iterations = 0;
    for (int frame = 0; frame < 48; ++frame) {
        state = advance(body, state, on_the_floor(), frame_seconds);
        iterations += state.report.iterations;
        ASSERT_TRUE(state.report.converged) << frame;
        ASSERT_EQ(state.report.steps, state.report.slept ? 0 : 1) << frame;
    }
    EXPECT_TRUE(state.report.slept);
    EXPECT_LT(iterations,
              100);  // one for each round, since contacts between them are in the factor
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        EXPECT_LT((state.x[k] - start.x[k]).norm(), 0.01 * 0.1);
    }
}

// Faces meet where the rim of neither lies on the other but for where they cross, and in the middle
// of a face.
TEST(RigidBodies, RestOnFacesThatTheirEdgesCross)
{
    const double h = 0.05;
    const std::vector<Cubes> boxes{box_at({-0.4, 0, -0.1}, 16, 2, 4, h),
                                   box_at({-0.1, 0.102, -0.4}, 4, 2, 16, h),
                                   box_at({-0.05, 0.204, -0.05}, 2, 2, 2, h)};
    const BricksBody body = rigid_body(boxes, {1, 1, 1});
    State state = rest_state(body);
    for (int frame = 0; frame < 36; ++frame) {
        state = advance(body, state, on_the_floor(), frame_seconds);
    }
    EXPECT_TRUE(state.report.slept);
    std::size_t k = 0;
    for (std::size_t b = 0; b < boxes.size(); ++b) {
        const double fell = 0.002 * static_cast<double>(b);
        for (std::size_t i = 0; i < boxes[b].corner_count(); ++i, ++k) {
            const Vec3 wanted = boxes[b].corner_position(i) - fell * Vec3::UnitY();
            EXPECT_LT((state.x[k] - wanted).norm(), 0.01 * h);
        }
    }
}

// mu = 0.5 holds up to 26.57 degrees. At 27, a = g (sin - 0.5 cos) = 0.0833 m/s^2.
// A post that tips over its lower edge: what the floor pushes it with at the end of a step is what
// it gains in the step, F = m (g + dv / dt).
TEST(RigidBodies, ArePushedAsTheyMove)
{
    const Cubes cubes = box_at({0, 0, 0}, 2, 8, 2, 0.05);
    const BricksBody body = rigid_body({cubes}, {1});
    const double mass = geometry::total_mass(cubes);
    State state = rest_state(body);
    turn(Vec3(0, 0, 0.35), state);
    double low = state.x[0].y();
    for (const Vec3& x : state.x) low = std::min(low, x.y());
    for (Vec3& x : state.x) x.y() -= low;
    int compared = 0;
    double most = 0;
    for (int frame = 0; frame < 8; ++frame) {
        const Vec3 before = fixtures::brick_motion(cubes, state).linear;
        state = advance(body, state, on_the_floor(), frame_seconds);
        if (frame < 2 || state.report.steps > 1) continue;
        Vec3 force = (fixtures::brick_motion(cubes, state).linear - before) / frame_seconds;
        force.y() += 9.81 * mass;
        Vec3 pushed = Vec3::Zero();
        for (const Grip& grip : state.holds) pushed += grip.force.cast<double>();
        most = std::max(most, (pushed - force).norm());
        ++compared;
    }
    EXPECT_GE(compared, 4);
    EXPECT_LT(most, 1e-5 * 9.81 * mass);
}

TEST(RigidBodies, SlideWhereFrictionDoesNotHoldThem)
{
    const Cubes cubes = box_at(Vec3::Zero(), 3, 3, 3, 0.1);
    const BricksBody body = rigid_body({cubes}, {1});
    const auto slid = [&](double degrees) {
        const double angle = degrees * std::numbers::pi / 180;
        Loads loads = on_the_floor();
        loads.forces.front().acceleration = 9.81 * Vec3(std::sin(angle), -std::cos(angle), 0);
        State state = rest_state(body);
        for (int frame = 0; frame < 48; ++frame) {
            state = advance(body, state, loads, frame_seconds);
        }
        return state.x[0].x();
    };
    EXPECT_LT(std::abs(slid(26)), 1e-3);
    EXPECT_NEAR(slid(27), 0.5 * 9.81 * (0.45399 - 0.5 * 0.89101) * 4, 0.015);
}

TEST(RigidBodies, PartByNewtonsLaw)
{
    constexpr double e = 0.8;
    const std::vector<Cubes> two{box_at(Vec3::Zero(), 3, 3, 3, 0.1),
                                 box_at({0, 0.6, 0}, 3, 3, 3, 0.1)};
    const BricksBody body = rigid_body(two, {1, 1}, {.bounce = e});
    State state = rest_state(body);
    const std::size_t half = state.x.size() / 2;
    for (std::size_t k = half; k < state.x.size(); ++k) state.v[k].y() = -4;
    for (int frame = 0; frame < 8; ++frame) state = advance(body, state, {}, frame_seconds);
    EXPECT_NEAR(state.v.front().y(), -4 * (1 + e) / 2, 0.03 * 4);
    EXPECT_NEAR(state.v.back().y(), -4 * (1 - e) / 2, 0.03 * 4);
    EXPECT_NEAR(state.v.front().y() + state.v.back().y(), -4, 1e-3);
}

// A heavy cube flies down and into the face of a slab that stands on the floor, so that the floor
// and the cube push the slab at once: what the cube gets along the face is at most mu times what it
// gets across, in each step.
TEST(RigidBodies, RubInAnImpactByNoMoreThanFrictionAllows)
{
    constexpr double mu = 0.3;
    const std::vector<Cubes> two{
        box_at(Vec3::Zero(), 1, 6, 3, 0.02, {.density = 700, .young = 1e10}),
        box_at({-0.05, 0.07, 0.01}, 2, 2, 1, 0.02, {.density = 8000, .young = 1e10})};
    const BricksBody body = rigid_body(two, {1, 1}, {.friction = mu});
    State state = rest_state(body);
    const std::size_t slab = two[0].corner_count();
    for (std::size_t k = slab; k < state.x.size(); ++k) state.v[k] = Vec3(0.8, -0.9, 0);
    const auto momentum = [&] {
        Vec3 sum = Vec3::Zero();
        for (std::size_t k = slab; k < state.x.size(); ++k) {
            sum += body.base.mass[body.base.slot_of(k)] * state.v[k];
        }
        return sum;
    };
    double mass = 0, across = 0;
    for (std::size_t k = slab; k < state.x.size(); ++k) {
        mass += body.base.mass[body.base.slot_of(k)];
    }
    constexpr double dt = 1.0 / 2304;
    for (int step = 0; step < 40; ++step) {
        const Vec3 before = momentum();
        state = advance(body, state, on_the_floor(), dt);
        ASSERT_TRUE(state.report.converged) << step;
        const Vec3 up = (state.x[2] - state.x[0]).normalized();  // along the slab
        const Vec3 normal(up.y(), -up.x(), 0);
        const Vec3 got = momentum() - before + mass * dt * 9.81 * Vec3::UnitY();
        across -= got.dot(normal);
        EXPECT_LE((got - got.dot(normal) * normal).norm(),
                  1.05 * mu * -got.dot(normal) + 1e-4 * mass)
            << step;
    }
    EXPECT_GT(across, 0.1 * mass);  // it hit
}

// At 20 m/s, ten times the speed of sound in the block: its cubes are crushed and turned inside out
// around what bores in, so that points are found far inside it at once.
TEST(RigidBodies, ShotIntoASoftBlockGainNoEnergy)
{
    const std::vector<Cubes> two{
        box_at({-0.28, 0, -0.28}, 7, 4, 7, 0.08, {.young = 3000, .poisson = 0.45}),
        box_at({-0.08, 0.36, -0.09}, 2, 2, 2, 0.08, {.density = 2000, .young = 1e9})};
    const BricksBody body = rigid_body(two, {0, 1});
    State state = rest_state(body);
    const std::size_t block = two[0].corner_count();
    for (std::size_t k = block; k < state.x.size(); ++k) state.v[k] = Vec3(0, -20, 0);
    const auto moving = [&] {
        double sum = 0;
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            sum += 0.5 * body.base.mass[body.base.slot_of(k)] * state.v[k].squaredNorm();
        }
        return sum;
    };
    const double first = moving();
    for (int step = 0; step < 30; ++step) {
        state = advance(body, state, on_the_floor(), 1.0 / 480);
        ASSERT_LT(moving(), 1.25 * first) << step;  // of lumped masses, which overtell it
        for (const Vec3& v : state.v) ASSERT_LT(v.norm(), 60) << step;
    }
    EXPECT_LT(moving(), 0.7 * first);
}

// Contacts are springs: those of a body that weighs many times the cubes that touch must not throw
// it back, however short the steps.
TEST(RigidBodies, StayWhereTheyLandInShortSteps)
{
    const Cubes cubes = box_at({0, 0.001, 0}, 2, 10, 2, 0.02, {.density = 8000, .young = 1e10});
    const BricksBody body = rigid_body({cubes}, {1});
    State state = rest_state(body);
    for (Vec3& v : state.v) v = Vec3(0, -1, 0);
    double fastest = 0;
    for (int step = 0; step < 40; ++step) {
        state = advance(body, state, on_the_floor(), 1.0 / 9216);
        fastest = std::max(fastest, state.v.front().y());
    }
    EXPECT_LT(fastest, 0.05);
}

// A box that is tilted lands on an edge at 3 m/s: it loses energy in every frame, keeps its shape,
// and rests on a face in the end, a hundredth of a cube deep at most.
TEST(RigidBodies, LandOnAnEdgeWithoutGainingEnergy)
{
    const Cubes cubes = box_at({0, 0.3, 0}, 4, 2, 2, 0.05, {.density = 600, .young = 1e10});
    const BricksBody body = rigid_body({cubes}, {1});
    State state = rest_state(body);
    turn(Vec3(0.3, 0.2, 0.5), state);
    for (Vec3& v : state.v) v.y() = -3;
    const auto energy = [&] {
        double sum = fixtures::brick_motion(cubes, state).energy;
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            sum += 9.81 * body.base.mass[body.base.slot_of(k)] * state.x[k].y();
        }
        return sum;
    };
    const double first = energy();
    double before = first;
    int steps = 0;
    for (int frame = 0; frame < 72; ++frame) {
        state = advance(body, state, on_the_floor(), frame_seconds);
        const double now = energy();
        EXPECT_LT(now, before + 0.02 * first) << frame;
        before = now;
        steps += state.report.steps;
        ASSERT_LT(fixtures::shape_error(cubes, state), 1e-12) << frame;
    }
    double low = 1;
    for (const Vec3& x : state.x) low = std::min(low, x.y());
    EXPECT_NEAR(low, 0, 0.01 * 0.05);
    EXPECT_LT(steps, 2 * 72);
    double speed = 0;
    for (const Vec3& v : state.v) speed = std::max(speed, v.norm());
    EXPECT_LT(speed, 1e-3);
}

// A rigid block on a soft one presses it as a block does that is stiff, in one solve with it.
TEST(RigidBodies, PressSoftOnesAsStiffOnesDo)
{
    const fixtures::Stuff soft{.young = 2e5, .stiffness_damping = 0.01};
    const std::vector<Cubes> two{box_at(Vec3::Zero(), 3, 3, 3, 0.1, soft),
                                 box_at({0.05, 0.3, 0.05}, 2, 2, 2, 0.1)};
    const auto settled = [&](std::vector<std::uint8_t> rigid) {
        const BricksBody body = rigid_body(two, std::move(rigid));
        State state = rest_state(body);
        for (int frame = 0; frame < 48; ++frame) {
            state = advance(body, state, on_the_floor(), frame_seconds);
        }
        EXPECT_TRUE(state.report.converged);
        return state.x.back().y();
    };
    const double elastic = settled({0, 0}), rigid = settled({0, 1});
    EXPECT_LT(elastic, 0.5 - 1e-3);  // 78 N on 0.04 m^2 of 2e5 Pa, over 0.3 m: 3 mm
    EXPECT_NEAR(0.5 - rigid, 0.5 - elastic, 0.02 * (0.5 - elastic));
}

// Two rigid boxes fall on a stiff board that lies on blocks at its ends: 900 iterations. Solved
// beside the board and not with it, they take up to hundreds a round, 2400 in all.
TEST(RigidBodies, TakeFewIterationsOnAStiffBoard)
{
    const fixtures::Stuff wood{.density = 500, .young = 4e8, .stiffness_damping = 0.004};
    const BricksBody body = rigid_body({box_at(Vec3::Zero(), 16, 1, 4, 0.05, wood),
                                        box_at({0.15, 0.052, 0.05}, 2, 3, 2, 0.05),
                                        box_at({0.5, 0.06, 0.05}, 2, 3, 2, 0.05)},
                                       {0, 1, 1});
    Loads loads;
    loads.forces.push_back({});
    for (const double x : {-0.05, 0.75}) {
        Collider block;
        block.kind = Collider::Kind::box;
        block.half_size = {0.05, 0.05, 0.15};
        block.pose.translation() = Vec3(x + 0.05, -0.05, 0.1);
        block.before = block.pose;
        loads.colliders.push_back(block);
    }
    State state = rest_state(body);
    int iterations = 0;
    for (int frame = 0; frame < 6; ++frame) {
        state = advance(body, state, loads, frame_seconds);
        iterations += state.report.iterations;
    }
    EXPECT_LT(iterations, 1500);
}

// Boxes on each other half a metre from the axis of a plane that turns at 2 rad/s, which takes half
// of the friction there is.
TEST(RigidBodies, StayWhereTheyAreOnATurningPlane)
{
    const Vec3 spin(0, 2, 0);
    const BricksBody body = rigid_body(
        {box_at({0.45, 0, -0.05}, 2, 2, 2, 0.05), box_at({0.45, 0.1, -0.05}, 2, 2, 2, 0.05)},
        {1, 1}, {.friction = 0.4});
    Loads loads;
    loads.forces.push_back({});
    Collider& plane = loads.colliders.emplace_back();
    plane.friction = 0.4;
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.x.size(); ++k) state.v[k] = spin.cross(state.x[k]);
    for (int frame = 1; frame <= 96; ++frame) {
        plane.before = plane.pose;
        plane.pose = Eigen::AngleAxisd(2 * frame * frame_seconds, Vec3::UnitY());
        state = advance(body, state, loads, frame_seconds);
    }
    const std::size_t half = state.x.size() / 2;
    for (const std::size_t first : {std::size_t{0}, half}) {
        Vec3 centre = Vec3::Zero();
        for (std::size_t k = first; k < first + half; ++k) {
            centre += state.x[k] / static_cast<double>(half);
        }
        EXPECT_NEAR(std::hypot(centre.x(), centre.z()), 0.5, 1e-3);
    }
}

// By its corners' masses and what bricks have between them.
geometry::MassProperties mass_of(const BricksBody& body)
{
    geometry::MassProperties out;
    const auto& base = body.base;
    Aligned<double> less(std::max<std::size_t>(base.numbers, 4 * body.layout.slots), 0);
    elasticity_of(body, {})->excess(Lumped::mass, base.rest.data(), less.data());
    const auto at = [](const Aligned<double>& v, std::size_t k) {
        return Vec3(Eigen::Map<const Vec3>(&v[4 * k]));
    };
    for (std::size_t k = 0; k < base.corners; ++k) {
        out.mass += base.mass[k];
        out.centre += base.mass[k] * at(base.rest, k);
    }
    out.centre /= out.mass;
    Mat3 second = Mat3::Zero();
    for (std::size_t k = 0; k < base.corners; ++k) {
        const Vec3 arm = at(base.rest, k) - out.centre;
        second += (base.mass[k] * arm - at(less, k)) * arm.transpose();
    }
    out.inertia = second.trace() * Mat3::Identity() - 0.5 * (second + second.transpose());
    return out;
}

// A box that is turned, in cubes as large as its thickness: elastic, it is 5 % and more
// too hard to turn; rigid, it has the mass and the inertia of its mesh.
TEST(RigidBodies, HaveTheMassAndInertiaOfTheirMesh)
{
    geometry::TriMesh mesh = geometry::box({0.3, 0.1, 0.1}, {1, 1, 1});
    const Eigen::AngleAxisf turn(0.5f, Eigen::Vector3f(1, 2, 3).normalized());
    for (auto& p : mesh.positions) p = turn * p + geometry::Vec3f(0.1f, 0.7f, -0.3f);
    const geometry::VoxelGrid grid{0.1, Vec3::Zero(), geometry::Vec3i::Zero()};
    const Cubes cubes =
        voxelize_solid(mesh, {{}, {{}}, {}}, geometry::Inside::winding, 0, grid, {});
    const std::vector<BodyModel> models{{&cubes, &mesh}};
    const auto weighed = [&](std::uint8_t rigid) {
        return mass_of(make_bricks(BodyModels(models), {.rigid = {rigid}}));
    };
    const auto wanted = geometry::mass_properties(mesh);
    const auto elastic = weighed(0), rigid = weighed(1);
    EXPECT_GT((elastic.inertia - 1000 * wanted.inertia).norm(),
              0.05 * (1000 * wanted.inertia).norm());
    EXPECT_NEAR(rigid.mass, 1000 * wanted.mass, 1e-4 * rigid.mass);
    EXPECT_LT((rigid.centre - wanted.centre).norm(), 1e-5);
    EXPECT_LT((rigid.inertia - 1000 * wanted.inertia).norm(), 1e-4 * rigid.inertia.norm());
    const auto wrong = geometry::box({0.05, 0.05, 0.05}, {1, 1, 1});  // far too small: not believed
    const std::vector<BodyModel> others{{&cubes, &wrong}};
    const auto kept = mass_of(make_bricks(BodyModels(others), {.rigid = {1}}));
    EXPECT_NEAR(kept.mass, elastic.mass, 1e-9 * kept.mass);
}

// One of a single cube, which has eight masses, and one of finer cubes land turned, and come to
// rest.
TEST(RigidBodies, OfOneCubeLandBesideOneOfAnotherSize)
{
    const std::vector<Cubes> two{box_at({0, 0.3, 0}, 1, 1, 1, 0.2),
                                 box_at({1, 0.2, 0}, 2, 3, 2, 0.05)};
    const BricksBody body = rigid_body(two, {1, 1});
    State state = rest_state(body);
    turn(Vec3(0.1, 0.3, 0.2), state);
    for (int frame = 0; frame < 60; ++frame) {
        state = advance(body, state, on_the_floor(), frame_seconds);
        ASSERT_TRUE(state.report.warnings.empty()) << state.report.warnings[0];
    }
    double low = 1, speed = 0;
    for (const Vec3& x : state.x) low = std::min(low, x.y());
    for (const Vec3& v : state.v) speed = std::max(speed, v.norm());
    EXPECT_NEAR(low, 0, 0.01 * 0.05);
    EXPECT_LT(speed, 1e-3);
}

// A state is all that the next frame starts from: one that was stored and read has the same bytes.
TEST(RigidBodies, GoOnFromAStoredStateAsFromTheirOwn)
{
    const std::vector<Cubes> two{box_at(Vec3::Zero(), 2, 2, 2, 0.1),
                                 box_at({0.07, 0.3, 0.03}, 2, 2, 2, 0.1)};
    const BricksBody body = rigid_body(two, {1, 1});
    State state = rest_state(body);
    for (int frame = 0; frame < 8; ++frame) {
        state = advance(body, state, on_the_floor(), frame_seconds);
    }
    const BricksBody other = rigid_body(two, {1, 1});
    const State a = advance(body, state, on_the_floor(), frame_seconds);
    const State b = advance(other, state, on_the_floor(), frame_seconds);
    for (std::size_t k = 0; k < a.x.size(); ++k) EXPECT_EQ(a.x[k], b.x[k]);
}

// One of two pins in a cube is released: the other holds its corner where it was.
TEST(RigidBodies, KeepAPinWhereAnotherIsReleased)
{
    const Cubes cubes = fixtures::box(1, 1, 1, 0.2);
    const BricksBody body = rigid_body({cubes}, {1});
    Loads both, one;
    both.forces.push_back({}), one.forces.push_back({});
    for (const std::uint32_t k : {4u, 6u}) {
        both.pins.corner.push_back(k);
        both.pins.target.push_back(cubes.corner_position(k));
    }
    one.pins.corner = {6u}, one.pins.target = {cubes.corner_position(6)};
    State state = rest_state(body);
    for (int frame = 0; frame < 4; ++frame) {
        state = advance(body, state, both, frame_seconds, {.substeps = 4});
    }
    for (int frame = 0; frame < 4; ++frame) {
        state = advance(body, state, one, frame_seconds, {.substeps = 4});
        EXPECT_LT((state.x[6] - cubes.corner_position(6)).norm(), 1e-3) << frame;
    }
}

TEST(RigidBodies, AreRefusedByOtherIntegrators)
{
    const BricksBody body = rigid_body({fixtures::box(1, 1, 1, 0.1)}, {1});
    EXPECT_THROW(advance(body, rest_state(body), {}, frame_seconds,
                         {.integrator = Integrator::implicit_midpoint}),
                 std::invalid_argument);
    EXPECT_THROW(rigid_body({fixtures::box(1, 1, 1, 0.1)}, {1, 1}), std::invalid_argument);
}

// Of a body with three moments of inertia that turns by 4 rad, against R' = w x R in 10,000 steps
// of the classical rule of Runge and Kutta.
TEST(RigidPart, TurnsFarWithItsMomentum)
{
    RigidPart part;
    part.mass = 1;
    part.inertia = Vec3(1, 2, 3).asDiagonal();
    part.spin = Vec3(0.1, 40, 0.2);
    part.momentum = part.inertia * part.spin;
    const Turn turn = turn_freely(part, 0.1);
    EXPECT_LT((turn.by * turn.by.transpose() - Mat3::Identity()).norm(), 1e-12);
    const Mat3 inertia = turn.by * part.inertia * turn.by.transpose();
    EXPECT_LT((inertia * turn.spin - part.momentum).norm(), 1e-9);
    RigidPart wild = part;
    wild.spin.x() = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(turn_freely(wild, 0.1).spin.allFinite());
    const auto rate = [&](const Mat3& r) {
        const Vec3 w = r * part.inertia.inverse() * r.transpose() * part.momentum;
        Mat3 out;
        for (int i = 0; i < 3; ++i) out.col(i) = w.cross(r.col(i));
        return out;
    };
    Mat3 fine = Mat3::Identity();
    constexpr double h = 1e-5;
    for (int i = 0; i < 10'000; ++i) {
        const Mat3 a = rate(fine), b = rate(fine + h / 2 * a), c = rate(fine + h / 2 * b);
        const Mat3 d = rate(fine + h * c);
        fine += h / 6 * (a + 2 * b + 2 * c + d);
    }
    EXPECT_LT((turn.by - fine).norm(), 1e-4);
}

// Bars that spin about their axis of most inertia, a bit off it, by 75 degrees a step: nothing lets
// them turn over to an axis of less, where they would have up to 450 times the energy.
TEST(RigidPart, KeepsItsEnergyHoweverThinAndFar)
{
    for (const Vec3& size : {Vec3(0.4, 0.1, 0.04), Vec3(0.04, 1, 0.04), Vec3(1, 0.9, 0.01)}) {
        RigidPart part;
        part.mass = 1;
        const Vec3 square = size.cwiseProduct(size);
        part.inertia = Vec3((Vec3::Constant(square.sum()) - square) / 12).asDiagonal();
        part.spin = Vec3(1e-4, 2e-4, 31.4);
        part.momentum = part.inertia * part.spin;
        const double energy = part.spin.dot(part.momentum);
        const Vec3 momentum = part.momentum;
        for (int i = 0; i < 500; ++i) {
            const Turn turn = turn_freely(part, 1.0 / 24);
            part.inertia = turn.by * part.inertia * turn.by.transpose();
            part.spin = turn.spin;
            part.momentum = part.inertia * part.spin;
            ASSERT_NEAR(part.spin.dot(part.momentum), energy, 1e-6 * energy) << i;
        }
        EXPECT_LT((part.momentum - momentum).norm(), 1e-9 * momentum.norm());
    }
}

}  // namespace
}  // namespace physics
