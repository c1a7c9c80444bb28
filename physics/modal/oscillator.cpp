#include "physics/modal/oscillator.hpp"

#include <cmath>

// With a = c/2, the roots of r^2 + c r + omega^2 are -a +- sqrt(a^2 - omega^2). All three ways
// below give S(t), the answer to a unit kick, and I(t) = its integral, the answer to a unit load:
//   x(t) = (S' + c S) x + S v + I f      v(t) = -omega^2 S x + S' v + S f
// and each is used where nothing cancels.

namespace physics {

namespace {

struct Response {
    double kick;        // S
    double kick_slope;  // S'
    double load;        // I
};

// Short steps: the power series of the solution, from its differential equation.
Response by_series(double omega_sq, double c, double t)
{
    // x = sum x_n with x_{n+2} = -(c t (n+1) x_{n+1} + omega^2 t^2 x_n) / ((n+1)(n+2)), for the
    // kick (x_0, x_1) = (0, t). The load's answer is its integral, term by term.
    const double ct = c * t, wt_sq = omega_sq * t * t;
    double before = 0, now = t;
    double kick = 0, slope = 0, load = 0;
    for (int n = 1; n < 30; ++n) {
        kick += now;
        slope += n * now / t;
        load += now * t / (n + 1);
        const double next = -(ct * n * now + wt_sq * before) / (n * (n + 1.0));
        before = now;
        now = next;
    }
    return {kick, slope, load};
}

// Two real roots apart: r1 is written so that it stays exact down to omega = 0.
Response overdamped(double omega_sq, double a, double root, double t)
{
    const double r2 = -(a + root), r1 = omega_sq / r2;
    const double e1 = std::exp(r1 * t), e2 = std::exp(r2 * t), apart = 2 * root;
    const double i1 = r1 == 0 ? t : std::expm1(r1 * t) / r1, i2 = std::expm1(r2 * t) / r2;
    return {(e1 - e2) / apart, (r1 * e1 - r2 * e2) / apart, (i1 - i2) / apart};
}

// Two complex roots, or nearly a double one. omega t is not small here.
Response underdamped(double omega_sq, double a, double excess, double t)
{
    // C = cos(w t), S = sin(w t) / w with w^2 = -excess; near w = 0, cosh and sinh alike, by
    // series.
    const double z = excess * t * t;
    double cosine, sine;
    if (std::abs(z) < 1e-3) {
        cosine = 1 + z / 2 * (1 + z / 12 * (1 + z / 30 * (1 + z / 56)));
        sine = t * (1 + z / 6 * (1 + z / 20 * (1 + z / 42 * (1 + z / 72))));
    } else {
        const double w = std::sqrt(-excess);
        cosine = std::cos(w * t);
        sine = std::sin(w * t) / w;
    }
    const double e = std::exp(-a * t);
    return {e * sine, e * (cosine - a * sine), (1 - e * (cosine + a * sine)) / omega_sq};
}

}  // namespace

OscillatorStep oscillator_step(double omega_sq, double damping, double dt)
{
    if (dt == 0) return {};
    const double a = damping / 2, excess = a * a - omega_sq;
    const bool is_short = damping * dt < 0.5 && omega_sq * dt * dt < 0.25;
    const Response r = is_short                  ? by_series(omega_sq, damping, dt)
                       : excess * dt * dt > 1e-3 ? overdamped(omega_sq, a, std::sqrt(excess), dt)
                                                 : underdamped(omega_sq, a, excess, dt);
    return {
        r.kick_slope + damping * r.kick, r.kick, r.load, -omega_sq * r.kick, r.kick_slope, r.kick};
}

}  // namespace physics
