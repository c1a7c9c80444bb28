#pragma once

// A thin elastic sheet as the implicit time step sees it: cells that resist stretch
// (shell_cell.hpp) and points that resist bending.
//
// A plate bends with the energy per area (Kirchhoff; Timoshenko, Woinowsky-Krieger. Theory of
// plates and shells. 1959)
//   D / 2 ((kuu + kvv)^2 - 2 (1 - nu) (kuu kvv - kuv^2)),    D = E h^3 / (12 (1 - nu^2))
// On the grid, kuu and kvv are known at points and kuv in cells:
//
//   kuu = (x[i-1] - 2 x[i] + x[i+1]) / a^2        kuv = (x0 - x1 - x2 + x3) / a^2
//
// They are vectors. A sheet that does not stretch has them along its normal, so that their products
// are those of the curvatures; and the energy is a square of positions: no normal that a fold could
// leave undetermined, and one matrix for all of the motion (Bergou, Wardetzky, Harmon, Zorin,
// Grinspun. A quadratic bending model for inextensible surfaces. SGP 2006). What it adds is a
// resistance to changes of the stretch from cell to cell, h^2 / 12 a^2 of that to stretch.
//
// Each of the up to four cells around a point gives it a quarter of its area. Where a point has no
// neighbour on one side of it, on borders and around holes, no moment acts across: its curvature
// there is what makes the energy least, kuu = -nu kvv, and
//   D / 2 (1 - nu^2) kvv^2
// is left. So Poisson's ratio is right on free borders, and a strip of any width bends with E I.
//
// Pins. One row of pinned points is a hinge. With two rows, that next to the free points is a
// clamp: it stands for its mirror image too and weighs twice.

#include "physics/body/corner_body.hpp"
#include "physics/shell/shell_cell.hpp"
#include "physics/shell/triangle_shell.hpp"
#include "physics/state/plastic.hpp"
#include "physics/state/state.hpp"

#include <memory>
#include <vector>

namespace physics {

class DissectionCache;

// Factors of what thickness and material give.
struct ShellOptions {
    double stretch = 1;
    double bend = 1;
    PartContactOptions contact{};
    PlasticOptions plastic{};  // of triangles
};

// A point and its neighbours; no_index where it has none.
struct ShellPoint {
    static constexpr std::size_t low_u = 0, high_u = 1, low_v = 2, high_v = 3;

    std::array<std::uint32_t, 4> beside{};
    bool along_u = false, along_v = false;  // it has kuu, kvv
    // N/m: the energy is 1/2 (uu |su|^2 + 2 uv su . sv + vv |sv|^2), s = x[i-1] - 2 x[i] + x[i+1].
    double uu = 0, uv = 0, vv = 0;
    double uu_damping = 0, uv_damping = 0, vv_damping = 0;  // N s/m, likewise
};

struct ShellBody {
    CornerBody base;  // slots are corners
    ShellOptions options;
    std::shared_ptr<const TriangleShell> triangles;  // null: cells of planes, as what follows has
    std::vector<std::array<std::uint32_t, 4>> cell;  // C, corners 0 .. 3
    std::vector<ShellCell> matter;                   // C
    std::vector<double> damping;                     // C, s, Rayleigh's with the stiffness
    std::vector<ShellPoint> point;                   // K
    std::vector<double> plate;                       // C, N m, D
    std::vector<double> poisson;                     // C

    // Rows of the stiffness matrix, 3 x 3 blocks: K + 1, into column; columns ascend.
    std::vector<std::uint32_t> row;
    std::vector<std::uint32_t> column;
    std::vector<std::array<std::uint32_t, 16>> cell_at;  // C, entry of corners (i, j) at 4 i + j
    std::vector<std::array<std::uint32_t, 4>> cells_of;  // K, 4 cell + corner; no_index: none

    // For the factor of a step: cells, each with the neighbours of its corner 0, and the other
    // points that bend, as cubes on a grid so coarse that each lies between two of its planes.
    geometry::Cubes elements;
    std::vector<std::array<std::uint32_t, 2>> element;  // its cell and point; no_index: none
    std::shared_ptr<DissectionCache> dissections;

    std::size_t bytes() const;
};

// Of planes of cubes (geometry/cubes/plane.hpp) and sheets of triangles (sheet.hpp), which state
// thickness and matter. Where there is a sheet, cells of planes become two triangles each. Contact
// and wind act on the surfaces of planes, or on the sheets themselves when these are null. Throws
// std::invalid_argument for cubes that are neither, and where more than one cell of a plane lies on
// the same side of a point.
ShellBody make_shell(const BodyModels& models, const ShellOptions& options = {});

// Of one model.
ShellBody make_shell(const geometry::Cubes& cubes, const ShellOptions& options = {},
                     const geometry::TriMesh* surface = nullptr);

State rest_state(const ShellBody& body);

// Where the block of a row and column is among all columns.
std::uint32_t entry_of(const ShellBody& body, std::uint32_t row, std::uint32_t column);

}  // namespace physics
