#pragma once

// The air of a wind, from place to place.
//
// Gusts are those of kinematic simulation (Kraichnan 1970; Fung, Hunt, Malik and Perkins 1992): a
// sum of waves
//   u'(x, t) = sum of A_n (a_n cos p_n + b_n sin p_n),   p_n = k_n . (x - carried) + turned_n
// with a_n and b_n across k_n, so that no air is made or lost. The mean wind carries them along.
// Wave lengths reach from the size of the gusts down to a sixteenth of it, and A_n^2 goes as
// k^(-2/3), as Kolmogorov's spectrum has it; they turn at the rate 0.4 k_n u_n of an eddy of that
// size, whose speed u_n goes as k^(-1/3).
//
// Speed and size may change while time goes by. What has gone by stays, as Gusts has it in sizes of
// then: `carried` is the integral of wind / size, `time` that of speed / size. (Rates of now times
// the time since the shot began would race while they change, the more the later it is.)

#include "physics/state/loads.hpp"

#include <array>

namespace physics {

// How they go on in dt seconds, from what they and their mean velocity (m/s) were before.
void let_pass(const Force& before, double dt, Force& wind);

class Air {
public:
    explicit Air(const Force& wind);

    Vec3 at(const Vec3& place) const;  // m/s

private:
    static constexpr std::size_t waves = 32;
    struct Wave {
        Vec3 k{0, 0, 0};              // 1/m
        Vec3 a{0, 0, 0}, b{0, 0, 0};  // m/s
        double phase = 0;
    };

    Vec3 mean_;  // m/s
    bool gusty_ = false;
    std::array<Wave, waves> wave_;
};

}  // namespace physics
