#pragma once

// Rest shapes of a shell's triangles that give way (state/plastic.hpp): dents and creases that
// stay.
//
// A triangle has U = sqrt(F^T F) of its gradient F, two by two, and its rest shape S; what it bends
// by along its normal gives way by the same share. The strain that it yields by is the root of the
// mean square through the thickness h:  |e|^2 + h^2 / 12 |k|^2, of the stretch e and the curvature
// k beyond the rest shape. A sheet that is drawn out becomes thinner, so that its stiffness to
// stretch, h times its area, stays as it was; that to bend is not made less.

#include "physics/shell/triangle_shell.hpp"
#include "physics/state/plastic.hpp"

namespace physics {

// Of a triangle, in its axes u and v.
struct TriangleStrain {
    Eigen::Vector3d stretch = Eigen::Vector3d::Zero();    // 11, 22, 12
    Eigen::Vector3d curvature = Eigen::Vector3d::Zero();  // 11, 22, twice 12; 1/m
};
inline constexpr std::size_t triangle_plastic_rows = 6;  // numbers of it in State::plastic

// A triangle's gradient and curvature at rest, once it has flowed.
struct TriangleRest {
    Eigen::Matrix<double, 2, 3> gradient;  // 1/m, S^-1 times what it was
    Eigen::Vector3d curved, turned;        // as in ShellTriangle
};
// f1, f2 and 0, as a cell without twist; x by slot, four numbers each.
ShellVector stretch_at(const ShellTriangle& triangle, const TriangleRest& rest, const double* x);

TriangleRest rest_of(const ShellTriangle& triangle, const TriangleStrain& plastic);

// The root of the mean square of a strain in a triangle of thickness h (m).
double size_of(const TriangleStrain& strain, double h);

// What the rest shape has come to after dt seconds: `places` by column are those of the corners
// now, m, and `bent` what it bends by along its normal beyond the rest shape, 1/m.
TriangleStrain flowed(const ShellTriangle& triangle, const TriangleStrain& rest,
                      const Eigen::Matrix3d& places, const Eigen::Vector3d& bent,
                      const PlasticOptions& options, double dt);

}  // namespace physics
