// Bodies of many cubes in a row: their condition grows by the fourth power of their length.

#include "physics/bricks/settle.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace {

using namespace physics;

constexpr double h = 0.01, density = 1000, gravity = 9.81;

struct Bar {
    geometry::Cubes cubes;
    BricksBody body;
    Loads loads;

    // Young's modulus by the place along the bar, in cubes.
    Bar(int length, const std::function<double(int)>& young)
        : cubes(fixtures::box(length, 1, 1, h, {.density = density, .poisson = 0}))
    {
        for (std::size_t c = 0; c < cubes.count(); ++c) cubes.young[c] = young(cubes.cell[c].x());
        body = make_bricks(cubes);
        loads.forces.push_back({});  // gravity
        loads.pins.corner = fixtures::first_layer(cubes);
        for (const auto k : loads.pins.corner) {
            loads.pins.target.push_back(cubes.corner_position(k));
        }
    }
    double sag(const State& state) const
    {
        double lowest = 0;
        for (const Vec3& x : state.x) lowest = std::min(lowest, x.y());
        return -lowest;
    }
};

// By the weight q over the length L: the tip's angle and sag, of a thin bar of stiffness EI.
struct Sag {
    double angle = 0, depth = 0;
};

// theta'' = -q (L - s) / EI cos theta, theta(0) = 0: integrated from a guess of theta'(0). Returns
// theta'(L), that is 0 for the right guess.
double shoot(double q, double length, double bending, double start, Sag& out)
{
    constexpr int steps = 4000;
    const double ds = length / steps;
    double angle = 0, curvature = start, depth = 0;
    for (int i = 0; i < steps; ++i) {
        const double half =
            curvature - 0.5 * ds * q * (length - i * ds) / bending * std::cos(angle);
        const double middle = angle + 0.5 * ds * half;
        const double at = length - (i + 0.5) * ds;
        depth += ds * std::sin(middle);
        curvature -= ds * q * at / bending * std::cos(middle);
        angle += ds * 0.5 * (half + curvature + 0.5 * ds * q * at / bending * std::cos(middle));
    }
    out = {angle, depth};
    return curvature;
}

Sag elastica(double q, double length, double bending)
{
    Sag out;
    double low = 0, high = q * length * length / bending;
    for (int i = 0; i < 60; ++i) {
        const double start = 0.5 * (low + high);
        (shoot(q, length, bending, start, out) > 0 ? high : low) = start;
    }
    return out;
}

TEST(LongBodies, ABarOfAThousandCubesHangsAsTheElasticaDoes)
{
    // Loads that a linear bar would sag 0.1 and 1 of its length under. Conjugate gradients took
    // 100,000 iterations and 25 s, and did not get there.
    const double length = 1000 * h, q = density * gravity * h * h;
    for (const double share : {0.1, 1.0}) {
        const double bending = q * std::pow(length, 3) / (8 * share);
        const Bar bar(1000, [&](int) { return 12 * bending / std::pow(h, 4); });
        const State state = settle(bar.body, rest_state(bar.body), bar.loads, {});
        EXPECT_TRUE(state.report.converged);
        EXPECT_LT(state.report.iterations, 500);
        // The lower corners hang half a cube deeper by the turned end. The bar stretches by 1e-6.
        const Sag expected = elastica(q, length, bending);
        EXPECT_NEAR(bar.sag(state), expected.depth, 1e-3 * expected.depth);
    }
}

TEST(LongBodies, SoftAndStiffPiecesInARowSagAsTheirSumDoes)
{
    // Every other ten cubes a million times stiffer: only the soft ones bend. M(s) = q (L - s)^2 /
    // 2 and the tip sinks by the sum of M(s) (L - s) / EI over them.
    const int n = 200;
    const double length = n * h, q = density * gravity * h * h, soft = 1e11;
    const auto young = [&](int at) { return at / 10 % 2 == 0 ? soft : 1e6 * soft; };
    const Bar bar(n, young);
    const State state = settle(bar.body, rest_state(bar.body), bar.loads, {});
    EXPECT_TRUE(state.report.converged);
    EXPECT_LT(state.report.iterations, 500);
    double expected = 0;
    constexpr int parts = 20;  // of a cube
    for (int i = 0; i < parts * n; ++i) {
        const double left = length - (i + 0.5) * h / parts;
        const double bending = young(i / parts) * std::pow(h, 4) / 12;
        expected += h / parts * 0.5 * q * std::pow(left, 3) / bending;
    }
    EXPECT_NEAR(bar.sag(state), expected, 2e-3 * expected);
}

TEST(LongBodies, AStepOfSoftAndStiffPiecesEndsWhereTheDiagonalTakesIt)
{
    // The diagonal alone takes tens of thousands of iterations.
    const Bar bar(150, [](int at) { return at / 10 % 2 == 0 ? 1e9 : 1e15; });
    std::array<State, 2> states;
    for (const std::size_t i : {0u, 1u}) {
        BricksBody body = bar.body;
        if (i == 1) body.dissections = nullptr;
        states[i] = advance(body, rest_state(body), bar.loads, 0.04,
                            {.tolerance = 1e-6, .solver_iterations = 1000000});
    }
    EXPECT_LT(10 * states[0].report.iterations, states[1].report.iterations);
    double worst = 0, most = 0;
    for (std::size_t k = 0; k < states[0].x.size(); ++k) {
        worst = std::max(worst, (states[0].x[k] - states[1].x[k]).norm());
        most = std::max(
            most,
            (states[0].x[k] - bar.cubes.corner_position(static_cast<std::uint32_t>(k))).norm());
    }
    EXPECT_LT(worst, 1e-3 * most);
}

}  // namespace
