#pragma once

// A damped oscillator under a constant load, x'' + c x' + omega^2 x = f, stepped exactly: each mode
// of vibration is one.

namespace physics {

// (x, v) after a step, linear in (x, v) before it and f.
struct OscillatorStep {
    double x_of_x = 1, x_of_v = 0, x_of_f = 0;
    double v_of_x = 0, v_of_v = 1, v_of_f = 0;

    void apply(double& x, double& v, double f) const
    {
        const double before = x;
        x = x_of_x * x + x_of_v * v + x_of_f * f;
        v = v_of_x * before + v_of_v * v + v_of_f * f;
    }
};

// The step of `dt` seconds, dt >= 0 and of any length, for omega_sq >= 0 (rad^2/s^2) and damping
// c >= 0 (1/s): free, under-, critically or overdamped. Right to rounding in every case.
OscillatorStep oscillator_step(double omega_sq, double damping, double dt);

}  // namespace physics
