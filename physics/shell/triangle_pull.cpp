// How a shell of triangles stiffens across itself by its pull.

#include "physics/shell/triangle_elasticity.hpp"

#include <algorithm>
#include <limits>

namespace physics {

AcrossStiffness TriangleElasticity::across(std::size_t t, const double* came, double tau) const
{
    const ShellTriangle& own = shell_.triangle[t];
    const TriangleRest& rest = rest_[t];
    double least = std::numeric_limits<double>::infinity();  // kg
    for (const auto k : own.corner) least = std::min(least, body_.base.mass[k]);
    const double steepest = rest.gradient.colwise().squaredNorm().maxCoeff();
    const ShellVector change = stretch_at(own, rest, came);
    return across_stiffness(own.stretch, stretch_at(own, rest, at_.data()), &change)
        .times(steepest * tau * tau / least);
}

bool TriangleElasticity::look_back(const double* came, double tau)
{
    bool far_off = false;
    for (std::size_t t = 0; t < shell_.triangle.size() && !far_off; ++t) {
        far_off = across(t, came, tau).far_off();
    }
    if (!far_off) return false;
    came_.assign(came, came + body_.base.numbers);
    evaluate();
    assemble();
    return true;
}

}  // namespace physics
