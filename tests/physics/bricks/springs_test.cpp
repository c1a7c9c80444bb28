#include "physics/bricks/springs.hpp"

#include "geometry/base/random.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace physics;

TEST(Springs, AStretchedBarHasYoungsModulusWhateverItsSection)
{
    // Uniform strain e along x with -e/4 across: every cut carries E e A, every corner inside is in
    // balance and the free sides feel nothing. Springs are linear in length, not in place: relative
    // error e.
    const double e = 1e-7;
    for (const auto& [nx, ny, nz] : {std::array{4, 1, 1}, {5, 2, 3}, {1, 1, 1}}) {
        const auto cubes = fixtures::box(nx, ny, nz, 0.1, {.young = 2e5});
        for (const double bending : {0.0, 0.4}) {
            const SpringsBody body = make_springs(cubes, {.bending = bending});
            auto x = corner_positions(cubes);
            for (auto& p : x) p = p.cwiseProduct(Vec3(1 + e, 1 - e / 4, 1 - e / 4));
            const auto f = spring_forces(body, x);
            Vec3 on_end = Vec3::Zero();
            const double force = 2e5 * e * 0.01 * ny * nz;
            for (std::size_t k = 0; k < f.size(); ++k) {
                if (cubes.corner[k].x() == nx) on_end += f[k];
                if (cubes.corner[k].x() > 0 && cubes.corner[k].x() < nx && bending == 0) {
                    EXPECT_LT(f[k].norm(), 1e-6 * force);
                }
            }
            EXPECT_NEAR(on_end.x(), -force, 1e-5 * force);
            EXPECT_LT(std::hypot(on_end.y(), on_end.z()), 1e-5 * force);
        }
    }
}

TEST(Springs, FreeFallAndMomentum)
{
    const auto cubes = fixtures::blob(3, 40, 0.1);
    const SpringsBody body = make_springs(cubes);
    Loads loads;
    loads.forces.push_back({});
    State state = rest_state(body);
    for (int i = 0; i < 10; ++i) state = advance(body, state, loads, 0.05);
    for (const Vec3& v : state.v) EXPECT_NEAR(v.y(), -9.81 * 0.5, 1e-6);
}

TEST(Springs, ACollapsedBodyUnfolds)
{
    const auto cubes = fixtures::box(3, 2, 2, 0.1, {.mass_damping = 5, .stiffness_damping = 0.02});
    const SpringsBody body = make_springs(cubes);
    State state = rest_state(body);
    for (Vec3& p : state.x) p.setZero();
    for (int i = 0; i < 400; ++i) state = advance(body, state, {}, 0.02);
    // Distances between corners are those at rest.
    const auto rest = corner_positions(cubes);
    for (std::size_t k = 1; k < rest.size(); ++k) {
        EXPECT_NEAR((state.x[k] - state.x[0]).norm(), (rest[k] - rest[0]).norm(), 0.005);
    }
}

TEST(Springs, RandomCornersGiveNoNaN)
{
    const auto cubes = fixtures::box(4, 4, 4, 0.1);
    const SpringsBody body = make_springs(cubes);
    State state = rest_state(body);
    const geometry::Random random(1);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        for (int i = 0; i < 3; ++i) state.x[k][i] = random.unit(3 * k + std::size_t(i));
    }
    for (const double dt : {0.001, 0.02, 1.0, 10.0}) {
        for (int i = 0; i < 20; ++i) state = advance(body, state, {}, dt);
        for (const Vec3& p : state.x) ASSERT_TRUE(p.allFinite());
    }
}

bool any_has(const std::vector<std::string>& warnings, const std::string& text)
{
    return std::any_of(warnings.begin(), warnings.end(), [&](const std::string& warning) {
        return warning.find(text) != std::string::npos;
    });
}

// Springs cannot tell a shape from its mirror image: it is at rest, and still wrong.
TEST(Springs, WarnOfInvertedCubes)
{
    const auto cubes = fixtures::box(4, 3, 3, 0.1);
    const SpringsBody body = make_springs(cubes);
    State state = rest_state(body);
    EXPECT_TRUE(advance(body, state, {}, 0.02).report.warnings.empty());
    for (Vec3& p : state.x) p.x() = -p.x();
    state = advance(body, state, {}, 0.02);
    ASSERT_EQ(state.report.warnings.size(), 1u);
    EXPECT_EQ(state.report.warnings[0],
              "A quarter of the cubes or more are inverted or pressed flat. Use a stiffer material "
              "or shorter steps: raise step.substeps; where it is 0, lower step.error.");
    // Turned by any angle and stretched, none is.
    state = rest_state(body);
    const Eigen::AngleAxisd turn(2, Vec3(1, 2, 3).normalized());
    for (Vec3& p : state.x) p = turn * (1.5 * p);
    EXPECT_FALSE(any_has(advance(body, state, {}, 1e-4).report.warnings, "inverted"));
}

// A body of a tenth of a millimetre moves many times its own size in a step: only shorter steps
// help, and a stiffer material makes it worse.
TEST(Springs, InvertedCubesThatMoveFarInAStepNeedSubsteps)
{
    const auto cubes = fixtures::box(4, 4, 4, 2.5e-5, {.young = 1e5});
    const SpringsBody body = make_springs(cubes);
    State state = rest_state(body);
    for (Vec3& p : state.x) p.x() = -p.x();
    for (Vec3& v : state.v) v = Vec3(0, -0.4, 0);
    const std::string said = "corners move more than a cube per step. Use shorter steps: ";
    state = advance(body, state, {}, 1.0 / 24);
    EXPECT_TRUE(any_has(state.report.warnings, said));
    EXPECT_FALSE(any_has(state.report.warnings, "stiffer"));
    // With as many as a cube's length takes, the material is to blame.
    StepOptions options;
    options.substeps = 1000;
    state = advance(body, state, {}, 1.0 / 24, options);
    EXPECT_TRUE(any_has(state.report.warnings, "Use a stiffer material"));
}

// Beyond 1e19 m the squares of distances leave single precision: meshes would hold infinities.
TEST(Springs, WarnWhenCornersAreLost)
{
    const auto cubes = fixtures::box(2, 2, 2, 0.1);
    const SpringsBody body = make_springs(cubes);
    State state = rest_state(body);
    for (Vec3& v : state.v) v = Vec3(1e22, 0, 0);
    state = advance(body, state, {}, 0.02);
    EXPECT_FALSE(state.report.converged);
    EXPECT_TRUE(any_has(state.report.warnings, "corners are more than 1e15 m away"));
}

// A solve that may not iterate cannot converge; springs report it as bricks do.
TEST(Springs, WarnWhenTheSolverDoesNotConverge)
{
    const auto cubes = fixtures::box(6, 2, 2, 0.1, {.young = 1e7});
    const SpringsBody body = make_springs(cubes);
    State state = rest_state(body);
    state.x[0] += Vec3(0.02, 0.01, 0);
    StepOptions options;
    options.solver_iterations = 1;
    state = advance(body, state, {}, 0.02, options);
    EXPECT_FALSE(state.report.converged);
    EXPECT_TRUE(any_has(state.report.warnings, "Raise step.solver_iterations."));
}

}  // namespace
