// What is at rest is not stepped, and wakes when something changes.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/sleep.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/state/measure.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

using geometry::Vec3i;

constexpr double frame = 1.0 / 24;
constexpr double h = 0.1;

Loads ground_and_gravity()
{
    Loads loads;
    loads.forces.emplace_back();
    loads.colliders.emplace_back();
    return loads;
}

geometry::Cubes block()
{
    return fixtures::box(4, 2, 4, h, {.young = 1e5, .stiffness_damping = 0.01});
}

// On the ground until it sleeps, two thirds of a second after it lies still.
template <class Body> State asleep(const Body& body, const Loads& loads)
{
    State state = rest_state(body);
    for (int i = 0; i < 150 && !state.report.slept; ++i) {
        state = advance(body, std::move(state), loads, frame, {});
    }
    EXPECT_TRUE(state.report.slept);
    return state;
}

template <class Body> void expect_sleep_to_keep_the_state(const Body& body)
{
    const Loads loads = ground_and_gravity();
    const State before = asleep(body, loads);
    EXPECT_EQ(largest_speed(before), 0);
    EXPECT_TRUE(before.report.converged);
    EXPECT_LE(before.report.residual, 2e-4);
    State on = before, stepped = before;
    for (int i = 0; i < 50; ++i) {
        on = advance(body, std::move(on), loads, frame, {});
        ASSERT_TRUE(on.report.slept);
        stepped = advance(body, std::move(stepped), loads, frame, {.sleep = false});
        ASSERT_FALSE(stepped.report.slept);
    }
    EXPECT_NEAR(on.time, before.time + 50 * frame, 1e-9);
    EXPECT_EQ(on.x, before.x);
    EXPECT_EQ(on.holds.size(), before.holds.size());
    EXPECT_EQ(on.stress, before.stress);
    for (std::size_t k = 0; k < on.x.size(); ++k) {
        EXPECT_LT((on.x[k] - stepped.x[k]).norm(), 1e-3 * h);
    }
}

TEST(Sleep, KeepsTheStateOfWhatLiesStill)
{
    expect_sleep_to_keep_the_state(make_bricks(block()));
    expect_sleep_to_keep_the_state(make_springs(block()));
}

TEST(Sleep, EndsWhereALoadAColliderOrAPinChanges)
{
    const BricksBody body = make_bricks(block());
    const Loads loads = ground_and_gravity();
    const State still = asleep(body, loads);

    Loads tilted = loads;
    tilted.forces[0].acceleration = {8, -9.81, 0};  // 39 degrees: friction of 0.5 lets it slide
    EXPECT_GT(largest_speed(advance(body, still, tilted, frame, {})), 0.01);

    Loads lifted = loads;
    lifted.colliders[0].pose.translation().y() = 0.01;
    const State up = advance(body, still, lifted, frame, {});
    EXPECT_FALSE(up.report.slept);
    EXPECT_GT(largest_speed(up), 0.1);  // 0.01 m in a frame: 0.24 m/s

    Loads pinned = loads;
    pinned.pins = {{0}, {still.x[0]}};
    EXPECT_TRUE(advance(body, still, pinned, frame, {}).report.slept);
    pinned.pins.target[0].x() -= 0.001;
    const State pulled = advance(body, still, pinned, frame, {});
    EXPECT_FALSE(pulled.report.slept);
    EXPECT_NEAR(pulled.x[0].x(), still.x[0].x() - 0.001, 1e-12);
}

TEST(Sleep, EndsWhereABodyIsGivenAVelocity)
{
    const BricksBody body = make_bricks(block());
    const Loads loads = ground_and_gravity();
    State state = asleep(body, loads);
    for (Vec3& v : state.v) v.x() = 0.5;
    EXPECT_GT(largest_speed(advance(body, std::move(state), loads, frame, {})), 0.1);
}

// 100 N on what pins hold move nothing.
TEST(Sleep, TellsWhatPinsHoldNow)
{
    const geometry::Cubes cubes = fixtures::box(1, 1, 1, h);
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    for (std::uint32_t k = 0; k < 8; ++k) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(corner_positions(cubes)[k]);
    }
    const State before = asleep(body, loads);
    Force push;
    push.kind = Force::Kind::point;
    push.force = {100, 0, 0};
    push.position = {h, h, h};
    push.radius = 3 * h;
    loads.forces.push_back(push);
    const State after = advance(body, before, loads, frame, {});
    EXPECT_TRUE(after.report.slept);
    EXPECT_NEAR(pin_force(after, nullptr, Vec3::Zero()).force.x(), -100, 1e-4);
}

// A cook that makes a mesh anew for each frame rests as one that makes it once.
TEST(Sleep, KnowsAColliderThatStaysByItsMesh)
{
    const auto floor = [](float top) {
        geometry::TriMesh mesh = geometry::box({2, 0.2, 2}, {1, 1, 1});
        for (auto& p : mesh.positions) p.y() += top - 0.1f;
        return std::make_shared<const geometry::TriMesh>(std::move(mesh));
    };
    Loads loads = ground_and_gravity();
    loads.colliders[0].kind = Collider::Kind::mesh;
    loads.colliders[0].mesh = floor(0);
    const BricksBody body = make_bricks(block());
    const State before = asleep(body, loads);
    loads.colliders[0].mesh_before = floor(0);
    EXPECT_TRUE(advance(body, before, loads, frame, {}).report.slept);
    loads.colliders[0].mesh_before = floor(-0.01f);
    EXPECT_FALSE(advance(body, before, loads, frame, {}).report.slept);
}

// Frames so short that nothing moves visibly for many of them: forces that do not balance count,
// and those of the lightest part, here a cube of 1e-10 times the mass of a block that hangs at a
// wall.
TEST(Sleep, DoesNotStopWhatBeginsToMove)
{
    constexpr double moment = 1e-5;
    constexpr int frames = 60;
    std::vector<Vec3i> cells{{9, 9, 9}};
    for (int k = 0; k < 8; ++k) cells.emplace_back(k & 1, k >> 1 & 1, k >> 2);
    geometry::Cubes cubes = fixtures::cubes_on(cells, h, {.young = 1e5, .stiffness_damping = 0.01});
    const std::size_t light = 8;  // the last in order
    ASSERT_EQ(cubes.cell[light], Vec3i(9, 9, 9));
    cubes.mass[light] *= 1e-9;
    cubes.young[light] *= 1e-9;
    const BricksBody body = make_bricks(cubes);
    Loads loads, held;
    loads.forces.emplace_back();
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        const int x = cubes.corner[k].x();
        if (x > 0 && x < 9) continue;
        Pins& pins = x == 0 ? loads.pins : held.pins;
        pins.corner.push_back(k);
        pins.target.push_back(corner_positions(cubes)[k]);
    }
    const Pins first = loads.pins;
    loads.pins.corner.insert(loads.pins.corner.end(), held.pins.corner.begin(),
                             held.pins.corner.end());
    loads.pins.target.insert(loads.pins.target.end(), held.pins.target.begin(),
                             held.pins.target.end());
    State state = rest_state(body);
    for (int i = 0; i < 100 && !state.report.slept; ++i) {
        state = advance(body, std::move(state), loads, frame, {});
    }
    ASSERT_TRUE(state.report.slept);
    ASSERT_GE(state.still_frames, frames_at_rest);
    loads.pins = first;
    for (int i = 0; i < frames; ++i) state = advance(body, std::move(state), loads, moment, {});
    EXPECT_FALSE(state.report.slept);
    const double expected = -9.81 * frames * moment;
    EXPECT_NEAR(state.v[cubes.corners[light][0]].y(), expected, 1e-3 * -expected);
}

// In slow motion, 1 ms a frame: a rigid or an elastic body that begins to fall under a fiftieth of
// weight, and one that drifts at 2.5 mm/s, go on.
TEST(Sleep, DoesNotStopSlowMotion)
{
    constexpr double moment = 1e-3;
    constexpr int frames = 100;
    for (const bool rigid : {false, true}) {
        const geometry::Cubes cubes = fixtures::box(2, 2, 2, h, {.young = 1e6});
        const BodyModel models[] = {{&cubes}};
        const BricksBody body =
            make_bricks(BodyModels(models), {.rigid = {std::uint8_t(rigid ? 1 : 0)}});
        Loads loads;
        loads.forces.emplace_back();
        loads.forces[0].acceleration = {0, -0.2, 0};
        State falls = rest_state(body), drifts = falls;
        for (Vec3& v : drifts.v) v.x() = 0.0025;
        for (int i = 0; i < frames; ++i) {
            falls = advance(body, std::move(falls), loads, moment, {});
            drifts = advance(body, std::move(drifts), {}, moment, {});
        }
        EXPECT_NEAR(falls.v[0].y(), -0.2 * frames * moment, 1e-6) << rigid;
        EXPECT_NEAR(drifts.v[0].x(), 0.0025, 1e-9) << rigid;
        EXPECT_NEAR(drifts.x[0].x(), 0.0025 * frames * moment, 1e-8) << rigid;
    }
}

struct Leaning {
    double by;  // radians
    int planks;
    int substeps;
};

class SleepOfPlanks : public testing::TestWithParam<Leaning> {};

// Contacts that stop a rigid part within a step are so stiff that planks which lean on a block are
// out of balance by a tenth of their weight for a nanometre.
TEST_P(SleepOfPlanks, ThatAreRigidAndLean)
{
    const auto [by, planks, substeps] = GetParam();
    const auto plank = [](int i) {
        auto cubes = fixtures::box(1, 12, 6, 0.02, {.density = 700, .young = 1e9});
        cubes.origin = {1.0 + i, 0, 0};  // at rest none lies in another
        return cubes;
    };
    std::vector<geometry::Cubes> boxes{
        fixtures::box(6, 6, 6, 0.04, {.density = 700, .young = 1e9})};
    for (int i = 0; i < planks; ++i) boxes.push_back(plank(i));
    std::vector<BodyModel> models;
    for (const auto& cubes : boxes) models.push_back({&cubes});
    const std::vector<std::uint8_t> rigid(boxes.size(), 1);
    const BricksBody body =
        make_bricks(BodyModels(models), {.contact = {.friction = 0.3}, .rigid = rigid});
    State state = rest_state(body);
    const Eigen::AngleAxisd turn(by, Vec3::UnitZ());
    std::size_t k = boxes[0].corner_count();
    for (int i = 0; i < planks; ++i) {
        const auto& cubes = boxes[static_cast<std::size_t>(i) + 1];
        const Vec3 foot(0.245 + 0.24 * std::sin(by) + i * 0.0202 / std::cos(by), 0.001, 0.05);
        for (std::size_t j = 0; j < cubes.corner_count(); ++j, ++k) {
            state.x[k] = turn * (state.x[k] - cubes.origin) + foot;
        }
    }
    for (int i = 0; i < 36 && !state.report.slept; ++i) {
        state =
            advance(body, std::move(state), ground_and_gravity(), frame, {.substeps = substeps});
    }
    EXPECT_TRUE(state.report.slept);
    EXPECT_NEAR(state.x.back().y(), 0.24 * std::cos(by) + 0.02 * std::sin(by), 0.005) << "it leans";
}
INSTANTIATE_TEST_SUITE_P(Planks, SleepOfPlanks,
                         testing::Values(Leaning{0.1, 6, 1}, Leaning{0.3, 1, 4},
                                         Leaning{0.2, 2, 1}));

}  // namespace
}  // namespace physics
