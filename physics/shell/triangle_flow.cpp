#include "physics/shell/triangle_flow.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/shell/triangle_elasticity.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::Mat3;

constexpr std::size_t triangles_that_flow = 256;  // in a task

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

double TriangleElasticity::flow(const double* x, double dt)
{
    const PlasticOptions& options = body_.options.plastic;
    if (!(options.yield > 0)) return 0;
    const std::vector<Pose> poses = poses_at(x);
    const bool first = plastic_.empty();
    plastic_.resize(shell_.triangle.size());
    std::vector<double> most(shell_.triangle.size(), 0);
    geometry::parallel_for(most.size(), triangles_that_flow,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t t = begin; t < end; ++t) {
                                   most[t] = flow_triangle(t, x, poses[t].bends, dt);
                               }
                           });
    const double flowed = most.empty() ? 0 : *std::max_element(most.begin(), most.end());
    if (first && flowed == 0) plastic_.clear();
    return flowed;
}

// By which strain the rest shape of a triangle flows that bends by these columns.
double TriangleElasticity::flow_triangle(std::size_t t, const double* x,
                                         const Eigen::Matrix3d& bends, double dt)
{
    const ShellTriangle& own = shell_.triangle[t];
    Eigen::Matrix3d places;
    for (std::size_t i = 0; i < 3; ++i) {
        places.col(Eigen::Index(i)) = Eigen::Map<const Vec3>(x + 4 * std::size_t{own.corner[i]});
    }
    const Vec3 a = places.col(1) - places.col(0), b = places.col(2) - places.col(0);
    const Vec3 normal = a.cross(b).normalized();
    TriangleStrain& rest = plastic_[t];
    const TriangleStrain next =
        flowed(own, rest, places, bends.transpose() * normal, body_.options.plastic, dt);
    const double flowed =
        size_of({next.stretch - rest.stretch, next.curvature - rest.curvature}, own.thickness);
    if (!(flowed > least_flow)) return 0;
    rest = next;
    rest_[t] = rest_of(own, next);
    return flowed;
}

void TriangleElasticity::load_plastic(const std::vector<float>& from)
{
    plastic_.clear(), rest_.clear();
    if (from.size() == triangle_plastic_rows * shell_.triangle.size()) {
        for (std::size_t at = 0; at < from.size(); at += triangle_plastic_rows) {
            const Eigen::Map<const Eigen::Matrix<float, 6, 1>> row(&from[at]);
            plastic_.push_back({row.head<3>().cast<double>(), row.tail<3>().cast<double>()});
        }
    }
    for (std::size_t t = 0; t < shell_.triangle.size(); ++t) {
        const ShellTriangle& own = shell_.triangle[t];
        rest_.push_back(plastic_.empty() ? TriangleRest{own.gradient, own.curved, own.turned}
                                         : rest_of(own, plastic_[t]));
    }
}

std::vector<float> TriangleElasticity::plastic() const
{
    std::vector<float> out;
    for (const TriangleStrain& each : plastic_) {
        for (const double value : each.stretch) out.push_back(static_cast<float>(value));
        for (const double value : each.curvature) out.push_back(static_cast<float>(value));
    }
    return out;
}

}  // namespace physics
