// Plates and strips against closed forms: E, nu and thickness alone tell how they bend.

#include "tests/physics/shell/shell_fixtures.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using namespace physics;
using namespace fixtures;

namespace {

constexpr double thickness = 0.01, young = 1e6, density = 1000;

double plate_stiffness(double nu)
{
    return young * std::pow(thickness, 3) / (12 * (1 - nu * nu));
}

// The stiffness between the corners' motions across the sheet at x, and their masses, of all
// corners that are not pinned. N/m, kg.
struct Across {
    Eigen::MatrixXd stiffness;
    Eigen::VectorXd mass;
};
Across across(const ShellBody& body, const State& state, const Pins& pins)
{
    ShellElasticity elasticity(body, pins);
    elasticity.use_hessian(true);
    Aligned<double> f(body.base.numbers), p(body.base.numbers, 0), y(body.base.numbers);
    elasticity.forces(by_slot(body.base, state.x).data(), f.data());
    elasticity.weigh(1, 0);
    std::vector<std::size_t> free;
    for (std::uint32_t k = 0; k < body.base.corners; ++k) {
        if (!std::binary_search(pins.corner.begin(), pins.corner.end(), k)) free.push_back(k);
    }
    const auto n = Eigen::Index(free.size());
    Across out{Eigen::MatrixXd(n, n), Eigen::VectorXd(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
        const std::size_t k = free[std::size_t(i)];
        p[4 * k + 1] = 1;
        elasticity.multiply(p.data(), y.data());
        p[4 * k + 1] = 0;
        out.mass[i] = body.base.mass[k];
        for (Eigen::Index j = 0; j < n; ++j) {
            out.stiffness(j, i) = y[4 * free[std::size_t(j)] + 1];
        }
    }
    return out;
}

// Angular frequencies, rad/s, ascending.
Eigen::VectorXd frequencies(const ShellBody& body, const Pins& pins)
{
    const Across a = across(body, rest_state(body), pins);
    const Eigen::VectorXd root = a.mass.cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        root.asDiagonal() * a.stiffness * root.asDiagonal(), Eigen::EigenvaluesOnly);
    return solver.eigenvalues().cwiseMax(0).cwiseSqrt();
}

double sag(const Cubes& cubes, const State& state)
{
    double most = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        most = std::max(most, cubes.corner_position(k).y() - state.x[k].y());
    }
    return most;
}

// w D / (q a^4) of a square plate of n cells a side under its weight, held `layers` corners deep.
double plate_sag(int n, int layers, double nu)
{
    const int all = n + 2 * (layers - 1);
    const double a = 1.0 / n, acceleration = 1e-4;
    const Cubes cubes = sheet(all, all, a, thickness, nu, young, density);
    const ShellBody body = make_shell(cubes);
    Loads loads;
    loads.pins =
        held_where(cubes, [&](const Vec3i& at) { return near_border(at, all, all, layers); });
    loads.forces = {weight({0, -acceleration, 0})};
    const State state = settled(body, loads);
    EXPECT_TRUE(state.report.converged) << state.report.residual;
    return sag(cubes, state) * plate_stiffness(nu) / (density * thickness * acceleration);
}

}  // namespace

// Timoshenko, Woinowsky-Krieger. Theory of plates and shells. 1959, tables 8 and 35.
TEST(ShellPlates, SagUnderEvenPressureAsNavierSays)
{
    for (const double nu : {0.0, 0.3}) EXPECT_NEAR(plate_sag(16, 1, nu), 0.00406, 0.01 * 0.00406);
}

TEST(ShellPlates, SagLessWhereTwoRowsOfTheirRimAreHeld)
{
    EXPECT_NEAR(plate_sag(24, 2, 0.3), 0.001265, 0.02 * 0.001265);
}

TEST(ShellPlates, AStripHeldAtOneEndSagsAsABeamDoes)
{
    // q b L^4 / (8 E I) whatever nu: the strip is free to curve across.
    constexpr int n = 20;
    for (const int width : {1, 3}) {
        const double a = 0.05, length = n * a, acceleration = 1e-4;
        const Cubes cubes = sheet(n + 1, width, a, thickness, 0.3, young, density);
        const ShellBody body = make_shell(cubes);
        Loads loads;
        loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] < 2; });
        loads.forces = {weight({0, -acceleration, 0})};
        const double load = density * thickness * acceleration;
        const double stiffness = young * std::pow(thickness, 3) / 12;
        EXPECT_NEAR(sag(cubes, settled(body, loads)) * 8 * stiffness / (load * std::pow(length, 4)),
                    1, 0.02)
            << width;
    }
}

TEST(ShellPlates, AStripHangsAsTheHeavyElasticaDoes)
{
    // E I theta'' = -q b (L - s) cos theta, theta(0) = theta'(L) = 0, with q b L^3 / E I = 10: its
    // end hangs at 0.65635 L, -0.70020 L (shooting, 4,000 steps of Runge and Kutta).
    constexpr int n = 20;
    const Cubes cubes = sheet(n + 1, 1, 1.0 / n, thickness, 0.3, young, density);
    const ShellBody body = make_shell(cubes);
    Loads loads;
    loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] < 2; });
    const double stiffness = young * std::pow(thickness, 3) / 12;
    loads.forces = {weight({0, -10 * stiffness / (density * thickness), 0})};
    const State state = settled(body, loads);
    EXPECT_TRUE(state.report.converged) << state.report.residual;
    const Vec3 end = state.x[cubes.corner_count() / 2 - 1];
    EXPECT_NEAR(end.x() - 1.0 / n, 0.65635, 0.005);
    EXPECT_NEAR(end.y(), -0.70020, 0.005);
}

TEST(ShellPlates, VibrateFreelyAtTheirFrequencies)
{
    // w a^2 sqrt(rho h / D) of a free square plate of nu = 0.3: 13.468, 19.596, 24.270 (Leissa. The
    // free vibration of rectangular plates. J. Sound Vib. 31(3), 1973, by finer computations). The
    // first is a twist, the second bends both ways against each other, the third alike: nu tells
    // them apart. The six slowest across the sheet are three rigid motions.
    const ShellBody body = make_shell(sheet(12, 12, 1.0 / 12, thickness, 0.3, young, density));
    const Eigen::VectorXd w =
        frequencies(body, {}) * std::sqrt(density * thickness / plate_stiffness(0.3));
    EXPECT_LT(w[2], 1e-3);
    EXPECT_NEAR(w[3], 13.468, 0.03 * 13.468);
    EXPECT_NEAR(w[4], 19.596, 0.03 * 19.596);
    EXPECT_NEAR(w[5], 24.270, 0.03 * 24.270);
}

TEST(ShellPlates, ClampedOnesVibrateAtTheirFrequency)
{
    const int n = 14;
    const Cubes cubes = sheet(n + 2, n + 2, 1.0 / n, thickness, 0.3, young, density);
    const Pins pins =
        held_where(cubes, [&](const Vec3i& at) { return near_border(at, n + 2, n + 2, 2); });
    const double w = frequencies(make_shell(cubes), pins)[0] *
                     std::sqrt(density * thickness / plate_stiffness(0.3));
    EXPECT_NEAR(w, 35.985, 0.03 * 35.985);
}

TEST(ShellPlates, AStripBucklesAtEulersLoad)
{
    // Hinged at both ends: P = pi^2 E I / L^2. Pressed evenly by the strain e it bears E h b e and
    // widens by nu e; it buckles where the lowest eigenvalue across it falls below 0.
    constexpr int n = 20;
    const double length = 1, a = length / n, nu = 0.3;
    const Cubes cubes = sheet(n, 2, a, thickness, nu, young, density);
    const ShellBody body = make_shell(cubes);
    const Pins pins = held_where(cubes, [](const Vec3i& at) { return at[0] == 0 || at[0] == n; });
    const double euler = std::pow(std::numbers::pi * thickness / length, 2) / 12;
    double low = 0, high = 3 * euler;
    for (int i = 0; i < 12; ++i) {
        const double strain = (low + high) / 2;
        State state = rest_state(body);
        for (Vec3& x : state.x) x.x() *= 1 - strain, x.z() *= 1 + nu * strain;
        const Eigen::LLT<Eigen::MatrixXd> factor(across(body, state, pins).stiffness);
        (factor.info() == Eigen::Success ? low : high) = strain;
    }
    EXPECT_NEAR(low / euler, 1, 0.03);
}
