#include "physics/modal/shift_inverse.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "physics/state/cube_mass.hpp"

#include <algorithm>
#include <limits>
#include <memory>

namespace physics {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

std::size_t four(const StiffnessAndMass& d)
{
    return std::size_t(d.rows()) / 3 * 4;
}

std::vector<BrickMatrix> shifted_cubes(double shift, const ModalCubes& of)
{
    const CubeMass usual = cube_mass_matrix();
    std::vector<BrickMatrix> matrices(of.cubes.count());
    for (std::size_t c = 0; c < matrices.size(); ++c) {
        const auto [k, factor] = of.stiffness.of(c);
        const CubeMass mass = mass_of_cube(of.cubes, c, usual);
        matrices[c] = factor * k;
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) {
                const double m = shift * of.cubes.mass[c] * mass[a][b];
                for (std::size_t j = 0; j < 3; ++j) {
                    matrices[c](Index(3 * a + j), Index(3 * b + j)) -= m;
                }
            }
        }
    }
    return matrices;
}

}  // namespace

ShiftedInverse::ShiftedInverse(const StiffnessAndMass& d, double shift, const ModalCubes& of)
    : slot_(of.unknowns.at.begin(), of.unknowns.at.end()), b_(four(d)), x_(four(d))
{
    std::vector<char> pinned(slot_.size(), 0);
    for (std::size_t k = 0; k < slot_.size(); ++k) {
        if (slot_[k] == geometry::no_index) pinned[k] = 1;
    }
    auto tree = std::make_shared<const Dissection>(
        dissect(of.cubes, pinned, std::numeric_limits<double>::infinity()));
    // Pinned corners are read and written nowhere.
    const std::vector<double> nothing(four(d), 0.0);
    fronts_ = DirectFactor::make(std::move(tree), shifted_cubes(shift, of), nothing, slot_);
    if (!fronts_) columns_.compute(d.shifted(shift));
}

VectorXd ShiftedInverse::solve(const VectorXd& r)
{
    if (!fronts_) return columns_.solve(r);
    const std::size_t n = b_.size() / 4;
    for (std::size_t i = 0; i < n; ++i) std::copy_n(r.data() + 3 * i, 3, b_.data() + 4 * i);
    fronts_->solve(b_.data(), x_.data());
    VectorXd out(r.size());
    for (std::size_t i = 0; i < n; ++i) std::copy_n(x_.data() + 4 * i, 3, out.data() + 3 * i);
    return out;
}

ShiftInverse::ShiftInverse(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                           const ModalCubes& of)
    : shift(-1e-12 * d.largest_ratio()), inverse_(d, shift, of), matrices_(d), rigid_(rigid),
      size_(d.rows())
{}

void ShiftInverse::perform_op(const double* from, double* to) const
{
    geometry::stop_if_asked();
    const Eigen::Map<const VectorXd> x(from, size_);
    Eigen::Map<VectorXd> y(to, size_);
    VectorXd work = x;
    project(work);
    y = matrices_.times_root_transposed(inverse_.solve(matrices_.times_root(work)));
    project(y);
    ++solves;
}

void ShiftInverse::project(Eigen::Ref<VectorXd> x) const
{
    for (const auto& piece : rigid_) take_out(piece, x);
    if (found.cols() > 0) x -= found * (found.transpose() * x);
}

}  // namespace physics
