#pragma once

// A contact as the linear solver of a step sees it.

#include "physics/body/point_contact.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace physics {

// W^T matrix W, W the weights of its corners.
template <class T> struct ContactBlock {
    std::array<std::uint32_t, PointContact::most> corners;  // whose weights are not 0
    std::array<T, PointContact::most> weight;
    std::uint32_t count;      // of these
    std::array<T, 6> matrix;  // xx xy xz yy yz zz

    // y += W^T matrix W p
    void add_times(const T* p, T* y) const
    {
        T u[4] = {0, 0, 0, 0};  // with the fourth, compilers take all at a time
        for (std::size_t a = 0; a < count; ++a) {
            const T* from = p + 4 * std::size_t{corners[a]};
            for (std::size_t i = 0; i < 4; ++i) u[i] += weight[a] * from[i];
        }
        const T f[4] = {matrix[0] * u[0] + matrix[1] * u[1] + matrix[2] * u[2],
                        matrix[1] * u[0] + matrix[3] * u[1] + matrix[4] * u[2],
                        matrix[2] * u[0] + matrix[4] * u[1] + matrix[5] * u[2], 0};
        for (std::size_t a = 0; a < count; ++a) {
            T* to = y + 4 * std::size_t{corners[a]};
            for (std::size_t i = 0; i < 4; ++i) to[i] += weight[a] * f[i];
        }
    }
};

}  // namespace physics
