#include "physics/modal/fine_motions.hpp"

#include "physics/modal/eigenpairs.hpp"

#include <algorithm>

namespace physics {
namespace {

using Eigen::Index;
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

// What has next to no energy is no motion of a solid.
void add(const FreeBody& body, const VectorXd& y, double no_stiffness, FineMotions& out)
{
    const VectorXd u = body.matrices.without_root_transposed(y);
    const VectorXd force = body.matrices.stiffness.selfadjointView<Eigen::Lower>() * u;
    if (!(u.dot(force) > no_stiffness * y.squaredNorm())) return;
    out.of.conservativeResize(Index(3 * body.cubes.corner_count()), out.of.cols() + 1);
    for (std::size_t i = 0; i < body.unknowns.count(); ++i) {
        out.of.col(out.of.cols() - 1).segment<3>(Index(3 * body.unknowns.corner[i])) =
            u.segment<3>(Index(3 * i));
    }
    out.energy.push_back(u.dot(force));
}

// The acceleration x_i along j and x_j along i, by unknown.
VectorXd linear_field(const FreeBody& body, int i, int j)
{
    VectorXd out = VectorXd::Zero(body.matrices.rows());
    for (std::size_t k = 0; k < body.unknowns.count(); ++k) {
        const Vec3 x = body.cubes.corner_position(body.unknowns.corner[k]);
        out[Index(3 * k) + j] += x[i];
        if (i != j) out[Index(3 * k) + i] += x[j];
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
        inverse.found.resize(body.matrices.rows(), 0);
        pairs = lanczos_eigenpairs(body.matrices, asked, inverse);
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
    inverse.found = pairs.vector.leftCols(hinges);
    VectorXd y(body.matrices.rows());
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
            const VectorXd load = body.matrices.times_root_transposed(linear_field(body, i, j));
            inverse.perform_op(load.data(), y.data());
            add(body, y.normalized(), no_stiffness, out);
        }
    }
    return out;
}

}  // namespace physics
