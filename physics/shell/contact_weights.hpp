#pragma once

// A contact as the element of a sheet that holds it has it.

#include "physics/body/point_contact.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace physics {

// The weights of an element's corners; none where the contact has other corners too.
template <std::size_t N>
std::optional<std::array<double, N>> weights_in(const std::array<std::uint32_t, N>& corners,
                                                const PointContact& contact)
{
    std::array<double, N> out{};
    for (std::size_t a = 0; a < contact.count; ++a) {
        if (contact.weight[a] == 0) continue;
        const auto found = std::find(corners.begin(), corners.end(), contact.corners[a]);
        if (found == corners.end()) return std::nullopt;
        out[std::size_t(found - corners.begin())] += double(contact.weight[a]);
    }
    return out;
}

// matrix += w w^T times a block, between the first corners of an element.
template <std::size_t N, class Matrix>
void add_between(const std::array<double, N>& weight, const geometry::Mat3& block, Matrix& matrix)
{
    for (std::size_t i = 0; i < N; ++i) {
        for (std::size_t j = 0; j < N; ++j) {
            matrix.template block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * j)) +=
                weight[i] * weight[j] * block;
        }
    }
}

}  // namespace physics
