#pragma once

// What a step of shape matching gives each particle, many at a time.

#include "geometry/base/vec.hpp"

#include <array>
#include <cstddef>

namespace physics {

// Sums over particles: linear (3), angular (3) and mass moments (3), and m x x^T (xx, xy, xz, yy,
// yz, zz), about the origin.
struct PullMomentum {
    static constexpr std::size_t numbers = 15;
    std::array<double, numbers> sum{};

    geometry::Vec3 linear() const { return {sum[0], sum[1], sum[2]}; }
    geometry::Vec3 angular() const { return {sum[3], sum[4], sum[5]}; }
    geometry::Vec3 moment() const { return {sum[6], sum[7], sum[8]}; }
    geometry::Mat3 spread() const
    {
        geometry::Mat3 m;
        m << sum[9], sum[10], sum[11], sum[10], sum[12], sum[13], sum[11], sum[13], sum[14];
        return m;
    }
    PullMomentum operator+(const PullMomentum& o) const
    {
        PullMomentum out = *this;
        for (std::size_t i = 0; i < numbers; ++i) out.sum[i] += o.sum[i];
        return out;
    }
};

// Particles one after another: pointers at the first of each array.
template <class T> struct PulledParticles {
    std::size_t count;
    const double* x;       // 3 a particle, m
    double* v;             // 3 a particle, m/s; impulses are added
    float* before;         // 3 a particle, d of the step before; that of this one on return
    const T* goal;         // 4 a particle, the weighed sum of T_r X_i about the origin
    const T* weight;       // the weights' sum
    const float* held_by;  // 1 / |R_i|
    const double* mass;    // kg
    const T* stretch;      // 4 a particle, kg m; null: none
};

// d_i = (goal_i - weight_i (x_i - origin)) held_by_i + stretch_i / m_i, and v_i += stiffness d_i +
// damping (d_i - before_i), both 1/s. Returns the sums of those impulses. The bits do not depend on
// the processor.
template <class T>
PullMomentum pull_particles(const PulledParticles<T>& particles, const geometry::Vec3& origin,
                            double stiffness, double damping);

// A motion of all particles: v_i += push - spin x (x_i - pivot), then x_i += dt v_i.
struct CommonPush {
    geometry::Vec3 push, spin, pivot;  // m/s, rad/s, m
    double dt = 0;                     // s
};

// Moves `count` particles, three numbers each. Returns the sum of their places. The bits do not
// depend on the processor.
geometry::Vec3 push_together(const CommonPush& push, std::size_t count, double* x, double* v);

}  // namespace physics
