#pragma once

// Keeps the volume of a layer by moving its contributions outward or inward.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, IV: one controller a skeleton, proportional and derivative, on the volume of its territory.
// What is ours: the exact slope C_i = dV/dtau_i (samples.hpp), and that the whole is kept too.
//
// With e_i = V_i - V_i0 of each territory now, V_i1 its target after the step, and over a part
// (skeletons that blend)
//   wanted change of i            w_i = v_i + m_i, v_i = V_i1 - V_i0, m_i = -(1 - exp(-K_p dt)) e_i
//   and of the part               W = sum w_i - K_d (sum e_i - sum e_i')
//       e_i': what the error would be now if nothing had moved. So K_d = 1 meets in advance what
//       motion does at a steady rate, and never answers to itself.
//   locally                      dtau_i = (v_i + m_i / 2) C_i / (C_i^2 + C_0^2)
//       half, because a territory also gives to its neighbours what it takes; C_0: a tenth of the
//       surface of a ball of that volume: a skeleton that is buried in others is left alone.
//   the rest of W over the part  dtau = (W - sum C_i dtau_i) / sum C_i, the same for all with
//       C_i > C_0.
// tau stays within half the thickness.

#include <cstdint>
#include <span>
#include <vector>

namespace physics {

struct VolumeControl {
    double proportional = 0;  // K_p, 1/s; 0: off
    double derivative = 1;    // K_d, 1
    bool operator==(const VolumeControl&) const = default;
};

// What the controllers of a body go by, all one a skeleton.
struct VolumeSense {
    std::span<const double> volume;        // m^3, V_i
    std::span<const double> target;        // m^3, V_i0
    std::span<const double> target_after;  // m^3, V_i1
    std::span<const double> slope;         // m^2, C_i
    std::span<const std::uint32_t> part;   // those of one part blend; empty: all do
    std::span<const double> thickness;     // m
};

// One step of dt seconds. Changes `translation`, and `expected` (e_i' of the next step; empty
// before the first).
void control_volume(const VolumeControl& control, const VolumeSense& sense, double dt,
                    std::vector<double>& translation, std::vector<double>& expected);

}  // namespace physics
