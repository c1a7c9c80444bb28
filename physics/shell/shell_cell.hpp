#pragma once

// How one cell of a shell resists stretch, shear and twist.
//
//      2-------3  v      f1 = ((x1 - x0) + (x3 - x2)) / 2a,  the mean side along u
//      |       |         f2 = ((x2 - x0) + (x3 - x1)) / 2a,  along v
//      0-------1  u      g  = (x0 - x1 - x2 + x3) / a,       what is not flat and parallel of it
//
// A bilinear cell is x = c + a (f1 s + f2 t + g s t) with s, t in -1/2 .. 1/2. Its metric, on the
// average over the cell, is
//   C11 = |f1|^2 + |g|^2 / 12,   C22 = |f2|^2 + |g|^2 / 12,   C12 = f1 . f2
// (the average and not its values in four points: these would keep a cell from bending along its
// diagonal without stretch). With the stretches s1, s2 = sqrt of its eigenvalues and T = s1 + s2 a
// sheet of thickness h costs, per area at rest,
//   h (mu ((s1 - 1)^2 + (s2 - 1)^2) + lambda / 2 (T - 2)^2)
// with lambda = E nu / (1 - nu^2) and mu = E / (2 (1 + nu)) of plane stress. It turns with the
// sheet, and where the cell has collapsed it still pulls it to its size. A bend of the cell within
// its plane, strains s . g1 and t . g2, costs h E / 24 ((f1 . g)^2 + (f2 . g)^2), and its twist
// D (1 - nu) |g|^2 / a^2 (shell_body.hpp).
//
// The stretch is a function of C alone, and that is F^T F of the 9 x 2 matrix F = [f1, g', 0; f2,
// 0, g'], g' = g / sqrt(12). So with F = sum sk uk vk^T the second derivative has the eigenvalues
// of a sheet in nine dimensions: of turns of side k out of the sheet pk / sk, with pk = 2 mu (sk -
// 1) + lambda (T - 2) the force per length across it, and of the turn within it 2 (p1 + p2) / T.
// Those are below 0 where it is pressed together; all others never are.
//
// A linear step that turns a side by an angle lengthens it by 1 / cos of that. The next one takes
// it back, but the pull by which a stiff sheet is too long holds it across all the while: of steel
// foil it is a thousand times the weight, and the foil sinks as through honey. With u the way that
// the side lay before, the pull of linear forces was that of a length u . (side), and the sheet
// stiffens by that.

#include "geometry/base/vec.hpp"

#include <array>

namespace physics {

using geometry::Vec3;

using ShellVector = Eigen::Matrix<double, 9, 1>;  // f1, f2, g
using ShellMatrix = Eigen::Matrix<double, 9, 9>;

// Stiffnesses of a cell, J.
struct ShellCell {
    double shear = 0, bulk = 0;  // 2 mu h a^2 and lambda h a^2
    double plane_bend = 0;       // E h a^2 / 12
    double twist = 0;            // 2 D (1 - nu)
};

// What f1, f2 and g have of each corner, times a.
constexpr std::array<std::array<double, 3>, 4> shell_shares{
    {{-0.5, -0.5, 1}, {0.5, -0.5, -1}, {-0.5, 0.5, -1}, {0.5, 0.5, 1}}};

// Which second derivative: none, all of it, or only what is never negative of it.
enum class Curvature { none, whole, positive };

struct CellEnergy {
    double energy = 0;  // J
    ShellVector slope = ShellVector::Zero();
    ShellMatrix curvature = ShellMatrix::Zero();
};
// With what f1, f2 and g `came` by in the step before, the sheet stiffens across itself by the pull
// that it had without what the step lengthened it by.
CellEnergy cell_energy(const ShellCell& cell, const ShellVector& at, Curvature curvature,
                       const ShellVector* came = nullptr);

// How much the sheet stiffens across itself, J: by the whole of the larger pull, and without that.
struct AcrossStiffness {
    double whole = 0, own = 0;

    AcrossStiffness times(double factor) const { return {factor * whole, factor * own}; }
    // As shares of what masses hold against it.
    bool far_off() const
    {
        constexpr double matters = 0.3;
        return whole - own > matters * (1 + own);
    }
};
AcrossStiffness across_stiffness(const ShellCell& cell, const ShellVector& at,
                                 const ShellVector* came);

}  // namespace physics
