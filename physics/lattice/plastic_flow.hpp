#pragma once

// Rest shapes of regions that give way (state/plastic.hpp), with U = R^T A B^-1 of a region.

#include "physics/lattice/step_state.hpp"

#include <span>

namespace physics {

// S_r, which State::plastic keeps less I.
template <class T> Eigen::Matrix<T, 3, 3> rest_shape(const FrameState& step, std::size_t slot)
{
    const float* const p = step.state.plastic.data() + 6 * slot;
    Eigen::Matrix<T, 3, 3> s;
    s << T(1 + p[0]), T(p[1]), T(p[2]), T(p[1]), T(1 + p[3]), T(p[4]), T(p[2]), T(p[4]),
        T(1 + p[5]);
    return s;
}

// Lets the rest shape of a region give way to its strain; m is A_r, r its rotation.
template <class T>
void flow(FrameState& step, std::size_t slot, const Eigen::Matrix<T, 3, 3>& m,
          const Eigen::Matrix<T, 3, 3>& r);

// Fills State::plastic_strain after the last step: of each cube the mean of its corners' regions.
void find_plastic_strain(FrameState& step);

// The inverse of what the rest shape of each membrane cell has flowed to: its corners' regions'
// mean. Empty where nothing flows.
template <class T> std::span<const float> find_membrane_rest(StepState<T>& step);

}  // namespace physics
