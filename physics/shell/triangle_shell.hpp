#pragma once

// A thin elastic sheet of triangles, of any shape at rest: what it is made of.
//
// Stretch. A triangle has the gradient f1, f2 of its places along two axes of its own, and costs
// what shell_cell.hpp says of a cell without twist (constant strain).
//
// Bending. The second fundamental form is constant in a triangle, from the slopes across its sides
// (Morley. The triangular equilibrium element in the solution of plate bending problems.
// Aeronautical Quarterly 19, 1968; as discrete shape operators: Grinspun, Gingold, Reisman, Zorin.
// Computing discrete shape operators on general meshes. Eurographics 2006): with the side's length
// l, its unit normal n in the triangle's plane at rest, its direction t, and g the derivative of
// the places across it,
//   h_ab = 1/A sum_sides l n_a (t_b (x_end - x_begin) / l + n_b g),    a, b = 1, 2
//
//        o               Both triangles at a side have the same g, but for its sign: it is what
//       / \              joins them. g is no motion of its own: it has no mass, and is what makes
//      /   \  ^ g        the energy least. So at a free side no moment acts across, and on any
//     o-----o |          mesh, however irregular, plates bend as they should: what takes slopes
//      \   /             from the places nearby instead (the mean over two triangles, a quadratic
//       \ /              through six points) is wrong by factors of 0.4 to 1.8 there.
//        o
//
// h is a vector for each a and b: along the normal by the curvature where the sheet does not
// stretch, and all of it linear in places and slopes (as in shell_body.hpp). A sheet that is curved
// at rest has h = T^c_ab f_c + k_ab N there, with the normal N of the triangle, and costs
//   A D / 2 ((1 - nu) sum e_ab . e_ab + nu |e_11 + e_22|^2),  e_ab = h_ab - T^c_ab f_c - k_ab N
// D = E h^3 / (12 (1 - nu^2)), by what it bends from there; f and N are those of now.
//
// Pins. A triangle that is pinned wholly, of a plane a cell that is, clamps those beside it: it is
// made so stiff that they meet it at its own slope. A side that is pinned at its ends alone is a
// hinge. So is, between others, a side at which more than two triangles meet: the two that run on
// most straightly bend as one.

#include "geometry/base/no_index.hpp"
#include "geometry/base/vec.hpp"
#include "physics/shell/shell_cell.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace physics {

class SlopeCache;

struct ShellTriangle {
    std::array<std::uint32_t, 3> corner{};  // slots
    std::array<std::uint32_t, 3> side{};    // from corner i to corner i + 1
    Eigen::Matrix<double, 2, 3> gradient;   // 1/m, f_a = sum_i gradient(a, i) x_i
    ShellCell stretch;                      // J
    // e_11, e_22 and 2 e_12 by the corners' places and the sides' slopes, without N. 1/m^2, 1/m.
    Eigen::Matrix3d by_place, by_slope;
    Eigen::Vector3d curved = Eigen::Vector3d::Zero();  // k_11, k_22, 2 k_12 at rest. 1/m
    Eigen::Matrix3d plate;                             // N m m^2, A D of e_11, e_22, 2 e_12
    // by_place^T plate by_slope and curved^T plate by_slope: what places and slopes have to do with
    // each other. N, N m.
    Eigen::Matrix3d joined;
    Eigen::Vector3d turned = Eigen::Vector3d::Zero();
    double damping = 0;                         // s, Rayleigh's with the stiffness
    double thickness = 0;                       // m
    std::uint32_t fourth = geometry::no_index;  // slot, of the cell that it is half of
};

struct TriangleShell {
    std::vector<ShellTriangle> triangle;  // T
    // Of each corner, 3 triangle + corner: K + 1, into around.
    std::vector<std::uint32_t> of_corner, around;
    // S, 3 triangle + side of the one or two at each side; no_index: none.
    std::vector<std::array<std::uint32_t, 2>> side;
    bool even = true;         // the damping is the same in all
    double most_damping = 0;  // s

    // Rows of the stiffness matrix between corners, 3 x 3 blocks: K + 1, into column; they ascend.
    std::vector<std::uint32_t> row, column;
    std::vector<std::array<std::uint32_t, 9>> block_at;  // T, entry of corners (i, j) at 3 i + j

    std::shared_ptr<SlopeCache> slopes;  // slope_factor.hpp; whoever keeps the shell makes it

    std::size_t bytes() const;
};

// Of each side, S, m, where corners are at `x`, four numbers a slot.
std::vector<Vec3> middles_of_sides(const TriangleShell& shell, const double* x);

// Three corners (slots) of a triangle and what it is made of.
struct TrianglePlan {
    std::array<std::uint32_t, 3> corner{};
    double young = 0, poisson = 0, thickness = 0;  // Pa, 1, m
    double damping = 0;                            // s
    std::uint32_t fourth = geometry::no_index;     // of the cell that it is half of
};

// Of triangles with an area. `rest` has four numbers a slot; the stiffnesses to stretch and to bend
// are multiplied by `stretch` and `bend`.
TriangleShell make_triangle_shell(const std::vector<TrianglePlan>& triangles, const double* rest,
                                  std::size_t corners, double stretch, double bend);

}  // namespace physics
