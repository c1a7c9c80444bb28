#include "physics/modal/oscillator.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using physics::oscillator_step;
using physics::OscillatorStep;

namespace {

// exp of the oscillator's 3x3 matrix, in long double: scaled down, Taylor, squared back up.
Eigen::Matrix<long double, 3, 3> by_exponential(double omega_sq, double c, double dt)
{
    using Matrix = Eigen::Matrix<long double, 3, 3>;
    Matrix a = Matrix::Zero();
    a(0, 1) = 1;
    a(1, 0) = -omega_sq;
    a(1, 1) = -c;
    a(1, 2) = 1;
    a *= dt;
    int squarings = 0;
    for (long double size = a.cwiseAbs().maxCoeff(); size > 0.01L; size /= 2) ++squarings;
    a = a * std::pow(0.5L, squarings);
    Matrix sum = Matrix::Identity(), term = sum;
    for (int n = 1; n < 20; ++n) {
        term = (term * a / n).eval();
        sum += term;
    }
    for (int i = 0; i < squarings; ++i) sum = (sum * sum).eval();
    return sum;
}

}  // namespace

TEST(Oscillator, IsTheMatrixExponential)
{
    // Free, tiny, soft, stiff; undamped, under, near, at and over critical; short and long steps.
    for (const double omega : {0.0, 1e-6, 1e-2, 1.0, 37.0}) {
        for (const double ratio : {0.0, 1e-3, 0.5, 1 - 1e-9, 1 - 1e-4, 1.0, 1 + 1e-9, 1.02, 20.0}) {
            for (const double dt : {1e-6, 1e-3, 1.0 / 24, 0.4, 0.5, 3.0}) {
                const double c = omega > 0 ? 2 * ratio * omega : ratio;
                const auto expected = by_exponential(omega * omega, c, dt);
                const OscillatorStep s = oscillator_step(omega * omega, c, dt);
                const double got[6] = {s.x_of_x, s.x_of_v, s.x_of_f, s.v_of_x, s.v_of_v, s.v_of_f};
                for (int i = 0; i < 6; ++i) {
                    const double e = double(expected(i / 3, i % 3));
                    // Rounding of the phase omega dt (up to 111) and, relative, of the answer.
                    const double size = std::abs(e) + (i % 3 == 0 ? 1 : 0) * 1e-3;
                    const double wave = i == 1 || i == 5 ? 1 / std::max(omega, 1 / dt) : 0;
                    EXPECT_NEAR(got[i], e, 4e-13 * (size + wave + (i == 4) + omega * (i == 3)))
                        << omega << ' ' << ratio << ' ' << dt << ' ' << i;
                }
            }
        }
    }
}

TEST(Oscillator, UndampedRingsForeverAtAnyStep)
{
    // From x = 1: x(t) = cos(omega t). 10^4 periods at 0.37 of a period, and energy kept.
    const double omega = 2 * std::numbers::pi, dt = 0.37;
    const OscillatorStep s = oscillator_step(omega * omega, 0, dt);
    double x = 1, v = 0;
    for (int i = 0; i < 27'027; ++i) s.apply(x, v, 0);
    EXPECT_NEAR(x, std::cos(omega * std::fmod(27'027 * dt, 1.0)), 1e-8);
    EXPECT_NEAR(v * v + omega * omega * x * x, omega * omega, 1e-8);
}

TEST(Oscillator, ManySmallStepsAreOneLargeOne)
{
    for (const double c : {0.0, 0.3, 10.0, 100.0}) {
        double x = 0.2, v = -1, many_x = x, many_v = v;
        oscillator_step(25, c, 2.0).apply(x, v, 3.0);
        const OscillatorStep small = oscillator_step(25, c, 2.0 / 4096);
        for (int i = 0; i < 4096; ++i) small.apply(many_x, many_v, 3.0);
        EXPECT_NEAR(many_x, x, 1e-12);
        EXPECT_NEAR(many_v, v, 1e-11);
    }
}

TEST(Oscillator, ComesToRestAtLoadOverStiffness)
{
    // dt = 1e9 s, from anywhere: x = f / omega^2, and no overflow.
    for (const double c : {0.1, 2.0, 1e3, 1e8}) {
        double x = 5, v = 7;
        oscillator_step(4, c, 1e12).apply(x, v, 8);
        EXPECT_NEAR(x, 2, 1e-9);
        EXPECT_NEAR(v, 0, 1e-9);
    }
    // Without stiffness a load ends in the steady speed f / c.
    double x = 0, v = 0;
    oscillator_step(0, 0.5, 1e3).apply(x, v, 2);
    EXPECT_NEAR(v, 4, 1e-12);
    EXPECT_NEAR(x, 4 * (1e3 - 2), 1e-9);
    // Without anything, x = f t^2 / 2.
    x = v = 0;
    oscillator_step(0, 0, 3).apply(x, v, 2);
    EXPECT_NEAR(x, 9, 1e-14);
    EXPECT_NEAR(v, 6, 1e-14);
    oscillator_step(4, 1, 0).apply(x, v, 2);
    EXPECT_EQ(v, 6);
}
