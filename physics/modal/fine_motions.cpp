#include "physics/modal/fine_motions.hpp"

#include "physics/modal/eigenpairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace physics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::Cubes;
using geometry::Vec3;

// Everything that a solve with the free body needs.
struct FreeBody {
    const Cubes& cubes;
    Unknowns unknowns;
    CubeStiffness stiffness;
    StiffnessAndMass matrices;
    std::vector<RigidMotions> rigid;

    explicit FreeBody(const Cubes& of)
        : cubes(of), unknowns(order_unknowns(of, {})),
          stiffness(of, BrickElement::incompatible, Weighting::filled),
          matrices(sum_matrices(of, unknowns, stiffness)),
          rigid(rigid_motions(of, unknowns, matrices))
    {}
};

// Adds a motion with u^T M u = 1. What has next to no energy is no motion of a solid.
void add(const FreeBody& body, const VectorXd& u, double no_stiffness, FineMotions& out)
{
    const VectorXd force = body.matrices.stiffness.selfadjointView<Eigen::Lower>() * u;
    if (!(u.dot(force) > no_stiffness)) return;
    out.of.conservativeResize(Index(3 * body.cubes.corner_count()), out.of.cols() + 1);
    for (std::size_t i = 0; i < body.unknowns.count(); ++i) {
        out.of.col(out.of.cols() - 1).segment<3>(Index(3 * body.unknowns.corner[i])) =
            u.segment<3>(Index(3 * i));
    }
    out.energy.push_back(u.dot(force));
}

// The pairs of axes i, j of the six linear fields: x_i along j and x_j along i.
constexpr std::array<std::array<int, 2>, 6> field_axes = {
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

// The six accelerations, by unknown, and two columns of zeros.
EightColumns linear_fields(const FreeBody& body)
{
    EightColumns out(eight * std::size_t(body.matrices.rows()), 0.0);
    for (std::size_t k = 0; k < body.unknowns.count(); ++k) {
        const Vec3 x = body.cubes.corner_position(body.unknowns.corner[k]);
        for (std::size_t f = 0; f < field_axes.size(); ++f) {
            const auto [i, j] = field_axes[f];
            out[eight * (3 * k + std::size_t(j)) + f] = x[i];
            out[eight * (3 * k + std::size_t(i)) + f] = x[j];
        }
    }
    return out;
}

// Displacements under these, with u^T M u = 1.
MatrixXd linear_displacements(const FreeBody& body, ShiftInverse& inverse)
{
    EightColumns field = linear_fields(body), load, x;
    inverse.project(field);
    inverse.weigh(field, load);
    inverse.apply(load, x);
    inverse.weigh(x, load);
    const Eights size_sq = transposed_times(x, load);
    MatrixXd out(body.matrices.rows(), Index(field_axes.size()));
    for (Index f = 0; f < out.cols(); ++f) {
        for (Index i = 0; i < out.rows(); ++i)
            out(i, f) = x[eight * std::size_t(i) + std::size_t(f)];
        if (size_sq(f, f) > 0) out.col(f) /= std::sqrt(size_sq(f, f));
    }
    return out;
}

}  // namespace

FineMotions fine_motions(const Cubes& cubes, int modes, Report& report)
{
    FreeBody body(cubes);
    FineMotions out;
    const Index free = body.matrices.rows() - Index(6 * body.rigid.size());
    const Index count = std::min<Index>(modes, free / 3);
    ShiftInverse inverse(body.matrices, body.rigid, {cubes, body.unknowns, body.stiffness});
    if (!inverse.factored() || count < 1) {
        report.converged = false;
        return out;
    }
    // Cubes that touch along one edge or at one corner only turn at no cost: they are left out.
    const double no_stiffness = 1e-12 * body.matrices.largest_ratio();
    Eigenpairs pairs;
    Index hinges = 0;
    for (Index asked = count; asked <= std::min(8 * count, free); asked = count + hinges) {
        const Index before = hinges;
        inverse.leave_out(MatrixXd(body.matrices.rows(), 0));
        // A few cubes have too few dimensions for blocks of eight.
        pairs = few_unknowns(body.matrices.rows(), asked)
                    ? dense_eigenpairs(body.matrices, body.rigid, asked)
                    : lanczos_eigenpairs(asked, inverse);
        hinges = 0;
        for (const double value : pairs.value) hinges += value > no_stiffness ? 0 : 1;
        if (hinges == before || !pairs.converged) break;
    }
    report.iterations += inverse.solves;
    report.converged =
        report.converged && pairs.converged && hinges < static_cast<Index>(pairs.value.size());
    for (std::size_t k = std::size_t(hinges); k < pairs.value.size(); ++k) {
        add(body, pairs.vector.col(Index(k)), no_stiffness, out);
    }
    out.modes = out.energy.size();
    inverse.leave_out(pairs.vector.leftCols(hinges));
    const MatrixXd fields = linear_displacements(body, inverse);
    for (Index f = 0; f < fields.cols(); ++f) add(body, fields.col(f), no_stiffness, out);
    return out;
}

}  // namespace physics
