#pragma once

// How a plane in space resists stretch: as a membrane of its own, a corner of a cell at a time.
//
// A corner is a particle with the two links of one of its cells, of lengths 1 at rest: F = [e1 e2]
// / h, a 3 x 2 matrix. With R the two orthonormal columns nearest to it, a cell of volume V costs
//   U = 1/2 E V mean over its corners of |F - R|^2
// which is a membrane of Young's modulus E and Poisson ratio 0, turns with the sheet, and has the
// forces p_k = -(E V / 4 h) (F - R)_k at the ends of its links. R has a closed form: with n the
// unit normal of the corner,
//   R = [e1 + e2 x n, e2 + n x e1] / t,    t^2 = e1^2 + e2^2 + 2 |e1 x e2|
// (that which J, a quarter turn in the corner's plane, leaves of F: R = (F + J F J^T) / t), and
// where a corner has collapsed to a line, n = 0 still gives a bounded pull to its length.
//
// Corners see what regions of shape matching cannot: a particle that stands out of the sheet
// stretches its links, whatever its neighbourhood is like on the average. And since these are the
// forces of a potential, motion cannot grow from nothing. (Splitting each region's pull into parts
// along its tangents and its normal, each at a rate of its own, gives forces of none: they turn
// with a normal that follows the particles. A single kick then grows without bound.)
//
// U bends no more than springs of E V / h^2 along the links do, so steps are stable as long as no
// particle has a share_m = 2 dt^2 (sum over its cells of E V / h^2) / m above 4.

#include "geometry/cubes.hpp"
#include "physics/aligned.hpp"

#include <span>

namespace physics {

inline constexpr std::uint32_t no_cell = ~0u;

struct Membrane {
    double h = 0;                                       // m, edge of a cell
    std::vector<std::array<std::uint32_t, 4>> cell;     // C, particles at 0, u, v, u + v
    std::vector<std::array<std::uint32_t, 4>> held_by;  // N, 4 cell + place in it, or no_cell
    std::vector<float> stiffness;                       // C, N/m, E V / h^2
    std::vector<float> thickness_sq;                    // C, (t / h)^2
    std::vector<float> mass;                            // C, kg

    std::size_t bytes() const;
};

// Of the plane `cubes` across `axis`.
Membrane make_membrane(const geometry::Cubes& cubes, int axis);

// Which corners of each cell have lost a link. `broken` as in State, 3 particle + axis.
std::vector<std::uint8_t> torn_corners(const Membrane& membrane, int axis,
                                       std::span<const std::uint32_t> broken);

// What of a membrane is torn and what has flowed.
struct MembraneState {
    std::span<const std::uint8_t> torn;  // C, bit k: not corner k; empty: nothing is
    std::span<const float> rest;  // C, inverse of the rest shape in (u, v), 11, 12 and 22; empty: I
};

// Impulses are dt^2 f / m of the pull, in m, of every particle; `share` is dt^2 E V / h^2 of every
// cell, kg.
template <class T> class MembranePull {
public:
    // The corners' pull on their particles at x: one task a piece, cells apart.
    void pull(const Membrane& membrane, const MembraneState& state, std::span<const T> share,
              const std::vector<geometry::Vec3>& x);

    // kg m, sum of what the cells of particle i pull it by.
    Eigen::Matrix<T, 3, 1> at(const Membrane& membrane, std::size_t i) const
    {
        Eigen::Matrix<T, 3, 1> sum = Eigen::Matrix<T, 3, 1>::Zero();
        for (const std::uint32_t h : membrane.held_by[i]) {
            if (h != no_cell) sum += Eigen::Map<const Eigen::Matrix<T, 3, 1>>(&pulls_[3 * h]);
        }
        return sum;
    }

private:
    std::vector<T> pulls_;  // 12 a cell
};

}  // namespace physics
