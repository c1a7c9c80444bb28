#include "physics/shell/triangle_flow.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::Mat3;

// S or U, with 1 across the sheet.
Mat3 with_thickness(const Eigen::Vector3d& stretch)
{
    Mat3 out = Mat3::Identity();
    out(0, 0) += stretch[0], out(1, 1) += stretch[1];
    out(0, 1) = out(1, 0) = stretch[2];
    return out;
}

Eigen::Vector3d in_plane(const Mat3& strain)
{
    return {strain(0, 0), strain(1, 1), strain(0, 1)};
}

// sqrt(F^T F) less I.
Eigen::Vector3d stretch_of(const Eigen::Matrix<double, 3, 2>& f)
{
    const Eigen::Matrix2d c = f.transpose() * f;
    const double root = std::sqrt(std::max(0.0, c.determinant()));
    const double scale = std::sqrt(c.trace() + 2 * root);
    return {(c(0, 0) + root) / scale - 1, (c(1, 1) + root) / scale - 1, c(0, 1) / scale};
}

}  // namespace

ShellVector stretch_at(const ShellTriangle& triangle, const TriangleRest& rest, const double* x)
{
    const auto at = [&](std::size_t i) -> Vec3 {
        return Eigen::Map<const Vec3>(x + 4 * std::size_t{triangle.corner[i]});
    };
    ShellVector out = ShellVector::Zero();
    // From its first corner: what is far away is told as exactly as what is near.
    const Vec3 first = at(0);
    for (std::size_t i = 1; i < 3; ++i) {
        const Vec3 away = at(i) - first;
        out.head<3>() += rest.gradient(0, Eigen::Index(i)) * away;
        out.segment<3>(3) += rest.gradient(1, Eigen::Index(i)) * away;
    }
    return out;
}

TriangleRest rest_of(const ShellTriangle& triangle, const TriangleStrain& plastic)
{
    const Mat3 inverse = with_thickness(plastic.stretch).inverse();
    const Eigen::Vector3d curved = triangle.curved + plastic.curvature;
    return {inverse.topLeftCorner<2, 2>() * triangle.gradient, curved,
            triangle.by_slope.transpose() * triangle.plate * curved};
}

double size_of(const TriangleStrain& strain, double h)
{
    const auto &e = strain.stretch, &k = strain.curvature;
    const double stretch_sq = e[0] * e[0] + e[1] * e[1] + 2 * e[2] * e[2];
    const double bend_sq = k[0] * k[0] + k[1] * k[1] + 0.5 * k[2] * k[2];
    return std::sqrt(stretch_sq + h * h / 12 * bend_sq);
}

TriangleStrain flowed(const ShellTriangle& triangle, const TriangleStrain& rest,
                      const Eigen::Matrix3d& places, const Eigen::Vector3d& bent,
                      const PlasticOptions& options, double dt)
{
    constexpr double least = 0.05;  // of its area: what is crushed has no shape
    const Mat3 stretch = with_thickness(stretch_of(places * triangle.gradient.transpose()));
    if (!(stretch.determinant() > least)) return rest;
    const Mat3 before = with_thickness(rest.stretch), strain = strain_beyond(stretch, before);
    const double h = triangle.thickness;
    const double share = share_that_flows(options, size_of({in_plane(strain), bent}, h), dt);
    if (!(share > 0)) return rest;
    TriangleStrain out{in_plane(grown_rest(before, share, strain, false)),
                       rest.curvature + share * bent};
    const double size = size_of(out, h);
    if (size > options.limit) {
        out.stretch *= options.limit / size;
        out.curvature *= options.limit / size;
    }
    return out;
}

}  // namespace physics
