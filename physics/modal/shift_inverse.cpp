#include "physics/modal/shift_inverse.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "physics/state/cube_mass.hpp"

#include <algorithm>
#include <limits>
#include <memory>

namespace physics {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>;

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
{
    std::vector<char> pinned(of.unknowns.at.size(), 0);
    for (std::size_t k = 0; k < pinned.size(); ++k) {
        if (of.unknowns.at[k] == geometry::no_index) pinned[k] = 1;
    }
    auto tree = std::make_shared<const Dissection>(
        dissect(of.cubes, pinned, std::numeric_limits<double>::infinity()));
    // Pinned corners are read and written nowhere.
    const std::vector<double> nothing(4 * of.unknowns.count(), 0.0);
    fronts_ =
        DirectFactor::make(std::move(tree), shifted_cubes(shift, of), nothing, of.unknowns.at);
    if (!fronts_) columns_.compute(d.shifted(shift));
}

void ShiftedInverse::solve(const EightColumns& r, EightColumns& x)
{
    x.resize(r.size());
    if (fronts_) {
        fronts_->solve(r, x);
        return;
    }
    const auto rows = Index(r.size() / eight);
    Eigen::Map<Rows>(x.data(), rows, 8) =
        columns_.solve(MatrixXd(Eigen::Map<const Rows>(r.data(), rows, 8)));
}

ShiftInverse::ShiftInverse(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                           const ModalCubes& of)
    : shift(-1e-12 * d.largest_ratio()), inverse_(d, shift, of), matrices_(d), rigid_(rigid),
      found_(d.rows(), 0), weighed_(d.rows(), 0)
{}

Index ShiftInverse::dimensions() const
{
    Index out = rows() - found_.cols();
    for (const RigidMotions& piece : rigid_) out -= piece.motion.cols();
    return out;
}

void ShiftInverse::apply(const EightColumns& load, EightColumns& x)
{
    geometry::stop_if_asked();
    inverse_.solve(load, x);
    project(x);
    solves += int(eight);
}

void ShiftInverse::project(EightColumns& x) const
{
    for (const RigidMotions& piece : rigid_) take_out(piece, x);
    if (found_.cols() == 0) return;
    Eigen::Map<Rows> all(x.data(), rows(), 8);
    const MatrixXd along = weighed_.transpose() * all;
    all.noalias() -= found_ * along;
}

void ShiftInverse::leave_out(const MatrixXd& modes)
{
    found_ = modes;
    weighed_ = matrices_.times_mass(modes);
}

}  // namespace physics
