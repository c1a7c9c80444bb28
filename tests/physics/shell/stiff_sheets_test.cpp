// Sheets so stiff that one linear solve a step lengthens them by a pull of many times their weight.

#include "physics/shell/shell_cell.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace physics {
namespace {

using geometry::Cubes;

// Steel foil, 0.5 mm thick, 1 m along x: of squares, or of triangles.
Cubes foil(bool triangles)
{
    constexpr int along = 10, across = 2;
    constexpr double young = 2e11;
    if (!triangles) return fixtures::sheet(along, across, 0.1, 5e-4, 0.3, young, 7850);
    const geometry::TriMesh mesh = fixtures::squares(
        {.ni = along, .nj = across, .a = 0.1, .cut = fixtures::Cut::in_turns, .moved = 0});
    return fixtures::sheet_of(mesh, 5e-4, 0.3, young, 7850);
}

struct FoilScene {
    Cubes cubes;
    ShellBody body;
    Loads loads;

    explicit FoilScene(bool triangles, bool both_ends = false)
        : cubes(foil(triangles)), body(make_shell(cubes))
    {
        const auto held = [&](double x) { return x < 1e-6 || (both_ends && x > 1 - 1e-6); };
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            const Vec3 at = cubes.corner_position(k);
            if (!held(at.x())) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(at);
        }
    }
    State after(int frames, State state, const StepOptions& options) const
    {
        for (int i = 0; i < frames; ++i) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
        }
        return state;
    }
    double fallen(int frames, const StepOptions& options) const  // m, the far end
    {
        const State state = after(frames, rest_state(body), options);
        double lowest = 0;
        for (const Vec3& x : state.x) lowest = std::min(lowest, x.y());
        return -lowest;
    }
};

// The sheet swings down about its hinged end. It sank by a fifth of that, as what a step lengthened
// it by held it across in the next one.
TEST(StiffSheets, FallAsConvergedStepsSay)
{
    for (const bool triangles : {false, true}) {
        FoilScene scene(triangles);
        scene.loads.forces.push_back(fixtures::weight({0, -9.81, 0}));
        const double right = scene.fallen(10, {.substeps = 32, .newton_iterations = 30});
        EXPECT_NEAR(right, 0.945, 0.01) << triangles;
        EXPECT_NEAR(scene.fallen(10, {.substeps = 1}), right, 0.35 * right) << triangles;
        EXPECT_NEAR(scene.fallen(10, {.substeps = 4}), right, 0.06 * right) << triangles;
    }
}

// Both ends are moved apart until it is under a true pull, and it is struck from below: the pull
// still stiffens it, and it does not begin to shake.
TEST(StiffSheets, UnderAPullComeToRest)
{
    for (const bool triangles : {false, true}) {
        FoilScene scene(triangles, true);
        for (Vec3& target : scene.loads.pins.target) target.x() *= 1.0005;
        State state = scene.after(12, rest_state(scene.body), {.substeps = 1});
        for (std::size_t k = 0; k < state.v.size(); ++k) {
            const double x = scene.cubes.corner_position(k).x();
            if (x > 1e-6 && x < 1 - 1e-6) state.v[k] += Vec3(0, 3 * std::sin(3.14159 * x), 0);
        }
        const auto fastest = [&] {
            double most = 0;
            for (const Vec3& v : state.v) most = std::max(most, v.norm());
            return most;
        };
        state = scene.after(24, std::move(state), {.substeps = 1});
        EXPECT_LT(fastest(), 0.05) << triangles;
    }
}

TEST(ShellCell, StiffensAcrossByThePullThatALinearStepDidNotMake)
{
    constexpr ShellCell steel{.shear = 2, .bulk = 1, .plane_bend = 0, .twist = 0};
    // A side that is pulled by a hundredth is carried 0.3 across.
    ShellVector before, came = ShellVector::Zero();
    before << 1.01, 0, 0, 0, 1, 0, 0, 0, 0;
    came[2] = 0.3;
    const AcrossStiffness at_first = across_stiffness(steel, before, nullptr);
    const ShellVector after = before + came;
    const AcrossStiffness then = across_stiffness(steel, after, &came);
    const double longer = std::hypot(1.01, 0.3);
    EXPECT_NEAR(then.whole, 3 * (longer - 1) / longer, 1e-12);
    // The pull is that of its length along where it lay, of 1.01, over the longer side.
    EXPECT_NEAR(then.own, 3 * (1.01 - 1) / longer, 1e-12);
    EXPECT_NEAR(at_first.own, 3 * 0.01 / 1.01, 1e-12);
    EXPECT_TRUE(AcrossStiffness({.whole = 2, .own = 0.5}).far_off());
    EXPECT_FALSE(AcrossStiffness({.whole = 2, .own = 1.9}).far_off());
}

}  // namespace
}  // namespace physics
