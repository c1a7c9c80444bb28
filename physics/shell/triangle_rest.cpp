// How a shell of triangles comes to its rest shape, lets it flow and hands it on.

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/shell/triangle_elasticity.hpp"

#include <algorithm>

namespace physics {
namespace {

constexpr std::size_t triangles_that_flow = 256;  // in a task

}  // namespace

double TriangleElasticity::flow(const double* x, double dt, Flow how)
{
    if (!may_flow()) return 0;
    const std::vector<Pose> poses = poses_at(x);
    const bool first = plastic_.empty();
    plastic_.resize(shell_.triangle.size());
    std::vector<double> most(shell_.triangle.size(), 0);
    geometry::parallel_for(most.size(), triangles_that_flow,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t t = begin; t < end; ++t) {
                                   most[t] = flow_triangle(t, x, poses[t].bends, dt, how);
                               }
                           });
    const double flowed = most.empty() ? 0 : *std::max_element(most.begin(), most.end());
    if (first && (flowed == 0 || how == Flow::told)) plastic_.clear();
    return flowed;
}

// By which strain the rest shape of a triangle flows, or would, that bends by these columns.
double TriangleElasticity::flow_triangle(std::size_t t, const double* x,
                                         const Eigen::Matrix3d& bends, double dt, Flow how)
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
    if (how == Flow::told) return flowed;
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

std::vector<float> TriangleElasticity::plastic_strain() const
{
    std::vector<float> out;
    if (!may_flow() && plastic_.empty()) return out;
    bool second = false;  // half of a cell
    for (std::size_t t = 0; t < shell_.triangle.size(); ++t) {
        const ShellTriangle& own = shell_.triangle[t];
        const double strain = plastic_.empty() ? 0 : size_of(plastic_[t], own.thickness);
        const auto size = static_cast<float>(strain);
        if (second) {
            out.back() = std::max(out.back(), size);
        } else {
            out.push_back(size);
        }
        second = own.fourth != geometry::no_index && !second;
    }
    return out;
}

}  // namespace physics
