// Sheets whose rest shape gives way for good.

#include "physics/shell/triangle_flow.hpp"

#include "geometry/base/random.hpp"
#include "physics/shell/triangle_elasticity.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace physics;
using namespace fixtures;
using Eigen::Index;

// A sheet whose rest shape has flowed as chance has it, and corners moved likewise.
struct FlowedSheet {
    Cubes cubes = sheet_of(squares({.ni = 4, .nj = 3}), 0.02);
    ShellBody body = make_shell(cubes);
    TriangleElasticity elasticity{body, {}};
    Aligned<double> x = body.base.rest;

    FlowedSheet()
    {
        const geometry::Random random(3);
        std::vector<float> plastic(triangle_plastic_rows * cubes.count());
        for (std::size_t i = 0; i < plastic.size(); ++i) {
            const double most = i % 6 < 3 ? 0.2 : 10;
            plastic[i] = static_cast<float>(most * (random.unit(i) - 0.5));
        }
        elasticity.load_plastic(plastic);
        for (std::size_t i = 0; i < 4 * body.base.corners; ++i) {
            if (i % 4 != 3) x[i] += 0.04 * (random.unit(9000 + i) - 0.5);
        }
    }
};

TEST(TriangleFlow, ForcesAreTheSlopeOfTheEnergyAndHaveNoNetTorque)
{
    FlowedSheet sheet;
    Aligned<double> f(sheet.elasticity.room(), 0);
    sheet.elasticity.forces(sheet.x.data(), f.data());
    double most = 0, wrong = 0;
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t k = 0; k < sheet.body.base.corners; ++k) {
        const Eigen::Map<const Vec3> at(&sheet.x[4 * k]), own(&f[4 * k]);
        force += own, torque += Vec3(at).cross(own);
        for (std::size_t i = 4 * k; i < 4 * k + 3; ++i) {
            constexpr double step = 1e-6;
            const double before = sheet.x[i];
            sheet.x[i] = before + step;
            const double up = sheet.elasticity.energy(sheet.x.data());
            sheet.x[i] = before - step;
            const double down = sheet.elasticity.energy(sheet.x.data());
            sheet.x[i] = before;
            most = std::max(most, std::abs(f[i]));
            wrong = std::max(wrong, std::abs(f[i] + (up - down) / (2 * step)));
        }
    }
    EXPECT_LT(wrong, 1e-6 * most);
    EXPECT_LT(force.norm(), 1e-9 * most);
    EXPECT_LT(torque.norm(), 1e-9 * most);
}

TEST(TriangleFlow, TheRestShapeStopsAtTheYieldStrain)
{
    FlowedSheet sheet;
    const ShellTriangle& own = sheet.body.triangles->triangle[2];
    const PlasticOptions options{.yield = 0.03, .flow = 1e6, .limit = 0.9};
    Eigen::Matrix3d places;
    for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Map<const Vec3> at(&sheet.body.base.rest[4 * std::size_t{own.corner[i]}]);
        places.col(Index(i)) = Vec3(1.2 * at.x() + 0.1 * at.z(), at.y(), 0.9 * at.z());
    }
    const Eigen::Vector3d curvature(5, -2, 1);
    TriangleStrain rest;
    for (int i = 0; i < 100; ++i) {
        rest = flowed(own, rest, places, curvature - rest.curvature, options, 0.01);
    }
    // What is left of it: as a further step has it with a yield strain of all but nothing.
    const TriangleStrain all =
        flowed(own, rest, places, curvature - rest.curvature, {1e-9, 1e9, 0.9}, 1);
    EXPECT_NEAR(size_of({all.stretch - rest.stretch, all.curvature - rest.curvature}, 0.02), 0.03,
                0.03 * 0.15);
    EXPECT_NEAR((curvature - rest.curvature).normalized().dot(curvature.normalized()), 1, 1e-9);
    const TriangleStrain same =
        flowed(own, rest, places, curvature - rest.curvature, {0.0301, 1e6, 0.9}, 0.01);
    EXPECT_EQ(same.stretch, rest.stretch);
    EXPECT_EQ(same.curvature, rest.curvature);
}

// A strip along x of 40 by 4 squares of 25 mm, 10 mm thick. Its ends, two squares long, go to where
// `to` has them in a second, stay for half of one, and are let go but for the first, for three.
struct Strip {
    State held, after;
};
Strip let_go(const PlasticOptions& plastic, const std::function<Vec3(const Vec3&, double)>& to)
{
    geometry::TriMesh mesh = squares({.ni = 40, .nj = 4, .a = 0.025, .moved = 0.2});
    Cubes cubes = geometry::make_sheet(mesh, 0.01, {"sheet", 1000, 1e8, 0.3, 3, 0.002}).cubes;
    const ShellBody body = make_shell(cubes, {.plastic = plastic});
    Strip out;
    State state = rest_state(body);
    for (int frame = 1; frame <= 108; ++frame) {
        Loads loads;
        loads.pins = held_at(cubes, [&](const Vec3& at) {
            return at.x() < 0.051 || (frame <= 36 && at.x() > 0.949);
        });
        const double share = std::min(1.0, frame / 24.0);
        for (std::size_t p = 0; p < loads.pins.corner.size(); ++p) {
            loads.pins.target[p] = to(loads.pins.target[p], share);
        }
        state = advance(body, std::move(state), loads, 1.0 / 24,
                        {.substeps = 2, .newton_iterations = 5, .tolerance = 1e-6});
        if (frame == 36) out.held = state;
    }
    out.after = std::move(state);
    return out;
}

// The middle of the corners that are near x at rest.
Vec3 row_at(const State& state, double x)
{
    geometry::TriMesh mesh = squares({.ni = 40, .nj = 4, .a = 0.025, .moved = 0.2});
    const Cubes cubes = geometry::make_sheet(mesh, 0.01, {"sheet", 1000, 1e8, 0.3, 3, 0.002}).cubes;
    Vec3 sum = Vec3::Zero();
    double count = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (std::abs(cubes.corner_position(k).x() - x) > 0.013) continue;
        sum += state.x[k], ++count;
    }
    return sum / count;
}

TEST(TriangleFlow, AStripThatWasBentKeepsTheCurvatureBeyondTheYieldStrain)
{
    // Along a circle between the ends, so that it is bent evenly.
    constexpr double angle = 1.2, length = 0.9;
    const auto to = [&](const Vec3& rest, double share) {
        const double turn = share * angle, r = length / turn;
        const double end = std::clamp((rest.x() - 0.05) / length, 0.0, 1.0) * turn;
        const double past = rest.x() > 0.949 ? rest.x() - 0.95 : std::min(rest.x() - 0.05, 0.0);
        return Vec3(0.05 + r * std::sin(end) + past * std::cos(end),
                    r * (1 - std::cos(end)) + past * std::sin(end), rest.z());
    };
    const auto angle_of = [&](const State& state) {
        const Vec3 low = row_at(state, 0.15) - row_at(state, 0.1);
        const Vec3 high = row_at(state, 0.9) - row_at(state, 0.85);
        return std::atan2(low.cross(high).z(), low.dot(high));
    };
    const double yield = 0.0015, nu = 0.3;
    const Strip kept = let_go({.yield = yield, .flow = 1e6}, to);
    // The elastic part springs back: k along the strip and -nu k across.
    const double bends = angle_of(kept.held) / 0.75;
    const double elastic = yield * std::sqrt(12.0) / 0.01 / std::sqrt(1 + nu * nu);
    EXPECT_NEAR(bends, angle / length, 0.03 * angle / length);
    EXPECT_NEAR(angle_of(kept.after), 0.75 * (bends - elastic), 0.03 * 0.75 * bends);
    EXPECT_NEAR(angle_of(let_go({}, to).after), 0, 0.01);
}

TEST(TriangleFlow, AStripThatWasDrawnOutStaysLonger)
{
    const auto to = [](const Vec3& rest, double share) {
        return Vec3(rest.x() * (1 + 0.05 * share), rest.y(), rest.z());
    };
    const auto length_of = [&](const State& state) {
        return (row_at(state, 0.75) - row_at(state, 0.25)).norm();
    };
    const double yield = 0.01, nu = 0.3;
    const Strip kept = let_go({.yield = yield, .flow = 1e6}, to);
    const double elastic = yield / std::sqrt(1 + nu * nu);
    const double rest = 0.5, expected = length_of(kept.held) / (1 + elastic);
    EXPECT_NEAR(length_of(kept.after) - rest, expected - rest, 0.03 * (expected - rest));
}

}  // namespace
