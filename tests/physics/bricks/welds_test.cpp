// Bars of finer cubes than the block that they are joined to.

#include "physics/bricks/bricks.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/state/part_joint.hpp"
#include "physics/state/state_models.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace physics {
namespace {

using geometry::Cubes;
using SomeCubes = std::vector<std::shared_ptr<const Cubes>>;

constexpr double length = 0.4, thickness = 0.1;               // m, of the bar
constexpr double density = 1000, young = 5e5, weight = 9.81;  // kg/m^3, Pa, m/s^2

// A pinned block of one cube, eight times as large as those of a bar that begins at its face.
struct OnBlock {
    SomeCubes cubes;
    Loads loads;

    OnBlock(PartJointKind kind, const Vec3& acceleration)
    {
        Cubes block = fixtures::box(1, 1, 1, 2 * thickness, {.density = 8000, .young = 2e11});
        block.origin = {-2 * thickness, -thickness, -thickness};
        Cubes bar = fixtures::box(16, 4, 4, thickness / 4,
                                  {.density = density, .young = young, .poisson = 0});
        bar.origin = {0, -thickness / 2, -thickness / 2};
        cubes = {std::make_shared<const Cubes>(block), std::make_shared<const Cubes>(bar)};
        loads.joints = points_of_all(make_joint(cubes, {.kind = kind, .axis = {0, 0, 1}}), cubes,
                                     number_models(cubes));
        for (std::uint32_t k = 0; k < block.corner_count(); ++k) {
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(block.corner_position(k));
        }
        loads.forces.push_back({});
        loads.forces.back().acceleration = acceleration;
    }
    std::vector<BodyModel> models() const { return {{cubes[0].get()}, {cubes[1].get()}}; }

    State bricks_at_rest() const
    {
        const BricksBody body = make_bricks(BodyModels(models()));
        return settle(body, rest_state(body), loads, {});
    }
    // By steps so long that inertia is nothing, each from rest.
    State springs_at_rest() const
    {
        const SpringsBody body = make_springs(BodyModels(models()));
        State state = rest_state(body);
        for (int step = 0; step < 20; ++step) {
            state = advance(body, std::move(state), loads, 1);
            for (Vec3& v : state.v) v.setZero();
        }
        return state;
    }
    // Mean displacement of the bar's corners at a distance from the block, m.
    Vec3 moved(const State& state, double x) const
    {
        Vec3 sum = Vec3::Zero();
        double count = 0;
        for (std::uint32_t k = 0; k < cubes[1]->corner_count(); ++k) {
            const Vec3 at = cubes[1]->corner_position(k);
            if (std::abs(at.x() - x) > 1e-9) continue;
            sum += state.x[cubes[0]->corner_count() + k] - at;
            ++count;
        }
        return sum / count;
    }
};

// w L^4 / 8 E I of bending and w L^2 / 2 k G A of shear, with G = E / 2.
double sag_of_cantilever(double free_length)
{
    const double area = thickness * thickness, w = density * weight * area;
    const double inertia = area * area / 12, shear = 5.0 / 6 * young / 2;
    return w * std::pow(free_length, 4) / (8 * young * inertia) +
           w * free_length * free_length / (2 * shear * area);
}

// What the weld holds goes into the bar by half an edge of its cube of points: the bar sags less
// than one that begins at the block, and more than one that begins there. With points four edges
// of the block's cube apart it fell 14 m.
TEST(Welds, HoldABarOfFinerCubesAsACantilever)
{
    const OnBlock scene(PartJointKind::weld, {0, -weight, 0});
    const double held = thickness / (2 * std::sqrt(3.0));
    for (const bool springs : {false, true}) {
        const State state = springs ? scene.springs_at_rest() : scene.bricks_at_rest();
        EXPECT_NEAR(scene.moved(state, 0).norm(), 0, thickness / 40) << springs;
        const double sag = -scene.moved(state, length).y();
        EXPECT_LT(sag, sag_of_cantilever(length)) << springs;
        EXPECT_GT(sag, sag_of_cantilever(length - held)) << springs;
    }
}

// The weight of 39 N pulls on one cube or two of E h = 12.5 kN/m: F / E h is 3 mm, an eighth of an
// edge, and half an edge is beyond what they yield.
TEST(Welds, HingesAndBallJointsHoldABarOfFinerCubes)
{
    for (const auto kind : {PartJointKind::hinge, PartJointKind::ball}) {
        const OnBlock scene(kind, {weight, 0, 0});
        EXPECT_NEAR(scene.moved(scene.bricks_at_rest(), 0).x(), 0, thickness / 8) << int(kind);
        EXPECT_NEAR(scene.moved(scene.springs_at_rest(), 0).x(), 0, thickness / 8) << int(kind);
    }
}

TEST(Welds, TellHowFarTheirPointsLieOutsideAPart)
{
    const OnBlock scene(PartJointKind::weld, {0, -weight, 0});
    JointDoubts doubts;
    make_joint(scene.cubes, {.kind = PartJointKind::weld}, &doubts);
    EXPECT_FALSE(doubts.too_wide(0) || doubts.too_wide(1));
    make_joint(scene.cubes, {.kind = PartJointKind::weld, .size = 0.4}, &doubts);
    EXPECT_FALSE(doubts.too_wide(0));
    EXPECT_TRUE(doubts.too_wide(1));
    // The corner of a cube of 0.4 m diagonal at (-0.115, 0.115, 0.115) m.
    const double out = 0.2 / std::sqrt(3.0), beside = out - thickness / 2;
    EXPECT_NEAR(doubts.outside[1] * thickness / 4, std::hypot(out, beside, beside), 1e-9);
}

}  // namespace
}  // namespace physics
