#include "physics/bricks/holding_elasticity.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/state/hold_matter.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// out = A u, four numbers a corner.
template <class T> void times(const T stiffness[8][8], const T u[8][4], T out[8][4])
{
    for (std::size_t a = 0; a < 8; ++a) {
        T sum[4] = {0, 0, 0, 0};
        for (std::size_t b = 0; b < 8; ++b) {
            for (std::size_t i = 0; i < 4; ++i) sum[i] += stiffness[a][b] * u[b][i];
        }
        for (std::size_t i = 0; i < 4; ++i) out[a][i] = sum[i];
    }
}

// Of each corner that is held, the part that is, if springs hold it along all axes.
std::vector<std::uint32_t> parts_held(const CornerBody& body, const HeldMatter& matter)
{
    std::vector<std::uint32_t> out(matter.corner.size(), geometry::no_index);
    for (const HeldCube& cube : matter.cubes) {
        if (cube.axes != all_axes) continue;
        for (const auto at : cube.corner) out[at] = body.part_of(body.slot_of(matter.corner[at]));
    }
    return out;
}

}  // namespace

HoldingElasticity::HoldingElasticity(const CornerBody& body, Elasticity& method,
                                     const HeldMatter& matter, std::vector<Vec3> from)
    : method_(method), matter_(matter),
      paths_(std::move(from), matter.target, parts_held(body, matter), matter.pivot, body.h),
      target_(matter.target)
{
    for (const HeldCube& cube : matter.cubes) {
        auto& at = at_.emplace_back();
        Spring<double> spring;
        for (std::size_t a = 0; a < 8; ++a) {
            const auto slot = body.slot_of(matter.corner[cube.corner[a]]);
            at[a] = static_cast<std::uint32_t>(4 * slot);
            for (std::size_t b = 0; b < 8; ++b) spring.stiffness[a][b] = stiffness_at(cube, a, b);
        }
        for (std::size_t i = 0; i < 4; ++i) spring.axis[i] = cube.axes >> i & 1;
        Spring<float> low;
        std::copy_n(&spring.stiffness[0][0], 64, &low.stiffness[0][0]);
        std::copy_n(spring.axis, 4, low.axis);
        springs_.push_back(spring);
        springs_low_.push_back(low);
    }
}

void HoldingElasticity::at_share(double share)
{
    target_ = targets(share);
}

std::vector<Vec3> HoldingElasticity::targets(double share) const
{
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < paths_.count(); ++i) out.push_back(paths_.at(i, share));
    return out;
}

std::vector<Vec3> HoldingElasticity::target_velocities(double share) const
{
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < paths_.count(); ++i) out.push_back(paths_.velocity(i, share));
    return out;
}

void HoldingElasticity::away(std::size_t c, const double* x, double d[8][4]) const
{
    for (std::size_t a = 0; a < 8; ++a) {
        const Vec3& to = target_[matter_.cubes[c].corner[a]];
        for (std::size_t i = 0; i < 3; ++i) {
            d[a][i] = springs_[c].axis[i] * (x[at_[c][a] + i] - to[static_cast<Eigen::Index>(i)]);
        }
        d[a][3] = 0;
    }
}

void HoldingElasticity::forces(const double* x, double* f)
{
    method_.forces(x, f);
    double d[8][4], push[8][4];
    for (std::size_t c = 0; c < springs_.size(); ++c) {
        away(c, x, d);
        times(springs_[c].stiffness, d, push);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t i = 0; i < 3; ++i) f[at_[c][a] + i] -= push[a][i];
        }
    }
}

double HoldingElasticity::energy(const double* x)
{
    double d[8][4], push[8][4], sum = 0;
    for (std::size_t c = 0; c < springs_.size(); ++c) {
        away(c, x, d);
        times(springs_[c].stiffness, d, push);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t i = 0; i < 3; ++i) sum += 0.5 * d[a][i] * push[a][i];
        }
    }
    return sum + method_.energy(x);
}

void HoldingElasticity::weigh(double stiffness, double damping)
{
    weight_ = stiffness;
    method_.weigh(stiffness, damping);
}

template <class T>
void HoldingElasticity::add_times(const std::vector<Spring<T>>& springs, const T* p, T* y) const
{
    if (weight_ == 0) return;
    const T weight = static_cast<T>(weight_);
    T u[8][4], push[8][4];
    for (std::size_t c = 0; c < springs.size(); ++c) {
        for (std::size_t a = 0; a < 8; ++a) std::copy_n(p + at_[c][a], 4, u[a]);
        times(springs[c].stiffness, u, push);
        for (std::size_t a = 0; a < 8; ++a) {
            T* to = y + at_[c][a];
            for (std::size_t i = 0; i < 4; ++i) to[i] += weight * springs[c].axis[i] * push[a][i];
        }
    }
}

void HoldingElasticity::multiply(const float* p, float* y) const
{
    method_.multiply(p, y);
    add_times(springs_low_, p, y);
}

void HoldingElasticity::multiply(const double* p, double* y) const
{
    method_.multiply(p, y);
    add_times(springs_, p, y);
}

void HoldingElasticity::add_diagonal(double* d) const
{
    method_.add_diagonal(d);
    for (std::size_t c = 0; c < springs_.size(); ++c) {
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t i = 0; i < 3; ++i) {
                d[at_[c][a] + i] += weight_ * springs_[c].axis[i] * springs_[c].stiffness[a][a];
            }
        }
    }
}

bool HoldingElasticity::cube_matrices(std::vector<BrickMatrix>& out) const
{
    if (!method_.cube_matrices(out)) return false;
    for (const HeldCube& cube : matter_.cubes) add_held(cube, weight_, out[cube.cube]);
    return true;
}

double HoldingElasticity::prepare_coarse(double stiffness, double damping,
                                         const std::vector<double>& mass, const HeldCorners& held)
{
    double most = method_.prepare_coarse(stiffness, damping, mass, held);
    if (most == 0) return 0;
    // Gershgorin's circles about D^-1/2 A D^-1/2 of each cube, whose numbers are 0 to 1.
    for (const Spring<double>& spring : springs_) {
        const auto& k = spring.stiffness;
        for (std::size_t a = 0; a < 8; ++a) {
            double sum = 0;
            for (std::size_t b = 0; b < 8; ++b) sum += k[a][b] / std::sqrt(k[a][a] * k[b][b]);
            most = std::max(most, sum);
        }
    }
    return most;
}

}  // namespace physics
