#pragma once

// How a plane in space resists stretch: as a membrane of its own, a corner of a cell at a time.
//
//      2-------3  v      Corner 0 has the links e1 = 01 and e2 = 02,
//      |       |         corner 1 has 01 and 13, corner 2 has 23 and 02,
//      |       |         corner 3 has 23 and 13: each link is part of two
//      0-------1  u      corners of a cell.
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

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/cubes.hpp"
#include "physics/math/aligned_memory.hpp"

#include <span>

namespace physics {

inline constexpr std::uint32_t no_cell = geometry::no_index;

// Cells one after another along u that share their links across, so that what they read and write
// lies in two rows of particles.
struct MembraneStrip {
    std::uint32_t first, count;  // cells, at most 64
    std::uint32_t row;           // of its pulls: count + 1 particles at v = 0, then as many at 1
    bool in_order;               // both rows of particles are numbered one after another,
    std::uint32_t low, high;     // from these on; if not, they are Membrane::link from `low` on
};

// Particles one after another and the pulls that each adds up, likewise: `rows` of the first, then
// no_cell.
struct MembraneRun {
    std::uint32_t first;
    std::array<std::uint32_t, 4> rows;
};

struct Membrane {
    using Cell = std::array<std::uint32_t, 4>;  // particles at 0, u, v, u + v

    double h = 0;                                    // m, edge of a cell
    std::array<int, 2> axes{0, 1};                   // u and v
    std::vector<MembraneStrip> strip;                // all cells, in their order
    std::vector<std::array<std::uint32_t, 2>> link;  // of strips out of order: particles at v = 0
                                                     // and 1
    std::vector<MembraneRun> run;                    // all particles, in their order
    std::size_t rows = 0;                            // pulls of all strips
    std::vector<float> stiffness;                    // C, N/m, E V / h^2
    std::vector<float> bend;                         // C, (t / h)^2 / (1 - nu^2)
    std::vector<float> mass;                         // C, kg

    std::size_t cells() const { return mass.size(); }
    // Particles at v = 0 and 1 of the links across a strip, 0 .. count.
    std::array<std::uint32_t, 2> across(const MembraneStrip& of, std::uint32_t k) const
    {
        if (of.in_order) return {of.low + k, of.high + k};
        return link[of.low + k];
    }
    // Calls with(c, cell) for all cells of the strips begin .. end, in their order.
    template <class With>
    void for_each_cell(std::size_t begin, std::size_t end, const With& with) const
    {
        for (std::size_t s = begin; s < end; ++s) {
            const MembraneStrip& of = strip[s];
            auto near = across(of, 0);
            for (std::uint32_t k = 0; k < of.count; ++k) {
                const auto far = across(of, k + 1);
                with(std::size_t(of.first + k), Cell{near[0], far[0], near[1], far[1]});
                near = far;
            }
        }
    }
    template <class With> void for_each_cell(const With& with) const
    {
        for_each_cell(0, strip.size(), with);
    }

    std::size_t bytes() const;
};

// Of the plane `cubes` across `axis`, with a cell of each cube. u is the axis along which cubes and
// corners are numbered one after another. Throws std::invalid_argument where more than four cells
// meet at a corner.
Membrane make_membrane(const geometry::Cubes& cubes, int axis);

// Which corners of each cell have lost a link. `broken` as in State, 3 particle + axis.
std::vector<std::uint8_t> torn_corners(const Membrane& membrane,
                                       std::span<const std::uint32_t> broken);

// Of each of `particles` the sum of `of_cell`, C, over the cells it is a corner of.
std::vector<double> sum_at_corners(const Membrane& membrane, std::span<const double> of_cell,
                                   std::size_t particles);

// What of a membrane is torn and what has flowed.
struct MembraneState {
    std::span<const std::uint8_t> torn;  // C, bit k: not corner k; empty: nothing is
    std::span<const float> rest;  // C, inverse of the rest shape in (u, v), 11, 12 and 22; empty: I
};

// Impulses are dt^2 f / m of the pull, in m, of every particle; `share` is dt^2 E V / h^2 of every
// cell, kg.
template <class T> class MembranePull {
public:
    // The corners' pull on their particles at x: one task a piece, strips apart.
    void pull(const Membrane& membrane, const MembraneState& state, std::span<const T> share,
              const std::vector<geometry::Vec3>& x);

    // kg m, what the cells pull `count` particles from `first` on by: four numbers each, the last
    // 0.
    void gather(const Membrane& membrane, std::size_t first, std::size_t count, T* to) const;

private:
    std::vector<T> pulls_;  // 4 a row of a strip
};

}  // namespace physics
