#include "physics/modal/modes.hpp"

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/plane.hpp"
#include "physics/modal/eigenpairs.hpp"
#include "physics/modal/rigid_motions.hpp"
#include "physics/modal/stiffness_matrix.hpp"
#include "physics/state/cube_mass.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace physics {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using geometry::Cubes;

void check_masses(const Cubes& cubes, const Unknowns& unknowns)
{
    const std::vector<double> mass = geometry::corner_masses(cubes);
    for (std::size_t i = 0; i < unknowns.count(); ++i) {
        const double m = mass[unknowns.corner[i]];
        if (!(m > 0) || !std::isfinite(m)) {
            throw std::invalid_argument(fmt::format(
                "expected a mass above 0 kg at every free corner, found {} kg at corner {}. Every "
                "cube needs samples with mass",
                m, unknowns.corner[i]));
        }
    }
}

// u^T M u of a cube of 1 kg.
double dot_by_mass(const BrickVector& u, const CubeMass& mass)
{
    double sum = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < 8; ++b) {
            sum += mass[a][b] * u.segment<3>(Index(3 * a)).dot(u.segment<3>(Index(3 * b)));
        }
    }
    return sum;
}

// phi^T C phi, C the sum of mass_damping * mass and stiffness_damping * stiffness of each cube.
double material_damping(const Cubes& cubes, const std::vector<Vec3>& phi, CubeStiffness& stiffness)
{
    const CubeMass usual = cube_mass_matrix();
    double sum = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        BrickVector u;
        for (std::size_t a = 0; a < 8; ++a) u.segment<3>(Index(3 * a)) = phi[cubes.corners[c][a]];
        const auto [k, factor] = stiffness.of(c);
        if (cubes.mass_damping[c] > 0) {
            const CubeMass mass = mass_of_cube(cubes, c, usual);
            sum += cubes.mass_damping[c] * cubes.mass[c] * dot_by_mass(u, mass);
        }
        if (cubes.stiffness_damping[c] > 0) {
            sum += cubes.stiffness_damping[c] * factor * u.dot(k * u);
        }
    }
    return sum;
}

// The lowest elastic modes, and in the report how they were found.
Eigenpairs elastic_pairs(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                         Index count, const ModalCubes& of, Report& report)
{
    Eigenpairs pairs;
    pairs.vector.resize(d.rows(), 0);
    if (count > 0) {
        if (few_unknowns(d.rows(), count)) {
            pairs = dense_eigenpairs(d, rigid, count);
        } else {
            ShiftInverse inverse(d, rigid, of);
            pairs = lanczos_eigenpairs(count, inverse);
            report.iterations = inverse.solves;
        }
    }
    report.converged = pairs.converged && Index(pairs.value.size()) == count;
    if (!report.converged) {
        report.warnings.push_back(
            fmt::format("Only {} of {} modes converged.", pairs.value.size(), count));
    }
    return pairs;
}

void add_mode(const Cubes& cubes, const Unknowns& unknowns, const VectorXd& phi, double omega_sq,
              Modes& modes)
{
    // Either sign would do: the largest component is positive.
    Index at = 0;
    phi.cwiseAbs().maxCoeff(&at);
    const double sign = phi[at] < 0 ? -1 : 1;
    std::vector<Vec3> shape(cubes.corner_count(), Vec3::Zero());
    for (std::size_t i = 0; i < unknowns.count(); ++i) {
        shape[unknowns.corner[i]] = sign * phi.segment<3>(Index(3 * i));
    }
    modes.omega_sq.push_back(omega_sq);
    modes.shape.push_back(std::move(shape));
}

// How many of `count` modes are rigid and listed, and how many rigid ones are not.
void count_rigid(const std::vector<RigidMotions>& rigid, const ModeSettings& settings, Index free,
                 Modes& modes)
{
    Index rigid_count = 0;
    for (const auto& piece : rigid) rigid_count += piece.motion.cols();
    modes.rigid = settings.keep_rigid ? int(std::min<Index>(rigid_count, settings.count)) : 0;
    modes.rigid_left_out = int(rigid_count) - modes.rigid;
    if (settings.count - modes.rigid > 3 * free - rigid_count) {
        throw std::invalid_argument(fmt::format(
            "expected at most {} modes of {} free corners with {} rigid motions{}, found {}",
            3 * free - rigid_count + (settings.keep_rigid ? rigid_count : 0), free, rigid_count,
            settings.keep_rigid ? "" : " left out", settings.count));
    }
}

// Cubes that touch along one edge or at one corner only are hinges: they turn at no cost.
bool has_hinges(const Cubes& cubes)
{
    return find_components(cubes, geometry::Connectivity::face).count() >
           find_components(cubes, geometry::Connectivity::corner).count();
}

// What rounding leaves unknown of phi^T K phi: of stiff parts that move as one, large terms cancel.
double rounding_of(const StiffnessAndMass& d, const VectorXd& phi)
{
    constexpr double epsilon = std::numeric_limits<double>::epsilon();
    double sum = 0;
    for (Index i = 0; i < phi.size(); ++i) sum += d.stiffness.coeff(i, i) * phi[i] * phi[i];
    return epsilon * sum;
}

void warn_of_left_out(int hinges, int unknown, Report& report)
{
    if (hinges > 0) {
        report.warnings.push_back(fmt::format(
            "{} motions without stiffness were left out: some cubes share only an edge or a corner "
            "with others. Join them by faces, or keep one component.",
            hinges));
    }
    if (unknown > 0) {
        report.warnings.push_back(fmt::format(
            "{} of the lowest modes were left out: their frequencies are too low beside the "
            "stiffest material and the size of cubes to be known. Lower the highest Young's "
            "modulus, or use larger cubes.",
            unknown));
    }
}

void add_elastic(const StiffnessAndMass& d, const Eigenpairs& pairs, const ModalCubes& of,
                 Modes& modes)
{
    const double no_stiffness = 1e-13 * d.largest_ratio();
    const auto is_low = [&](double value) { return value < no_stiffness; };
    const bool hinged =
        std::any_of(pairs.value.begin(), pairs.value.end(), is_low) && has_hinges(of.cubes);
    int hinges = 0, unknown = 0;
    for (std::size_t i = 0; i < pairs.value.size(); ++i) {
        const VectorXd phi = pairs.vector.col(Index(i));
        const VectorXd force = d.stiffness.selfadjointView<Eigen::Lower>() * phi;
        if (is_low(pairs.value[i]) && (hinged || pairs.value[i] < 10 * rounding_of(d, phi))) {
            ++(hinged ? hinges : unknown);
            continue;
        }
        modes.report.residual =
            std::max(modes.report.residual,
                     (force - pairs.value[i] * d.times_mass(phi)).norm() / force.norm());
        add_mode(of.cubes, of.unknowns, phi, pairs.value[i], modes);
    }
    warn_of_left_out(hinges, unknown, modes.report);
}

}  // namespace

Modes lowest_modes(const Cubes& cubes, const std::vector<std::uint32_t>& pinned,
                   const ModeSettings& settings, std::span<const HeldCube> held)
{
    geometry::need_thickness(cubes, "Modes");
    if (cubes.count() == 0) throw std::invalid_argument("expected at least one cube, found none");
    geometry::check_elements(cubes);
    if (settings.count < 1) {
        throw std::invalid_argument(
            fmt::format("expected at least one mode, found {}", settings.count));
    }
    const Unknowns unknowns = order_unknowns(cubes, pinned);
    if (unknowns.count() == 0) {
        throw std::invalid_argument("expected at least one free corner, found every corner pinned");
    }
    check_masses(cubes, unknowns);
    CubeStiffness stiffness(cubes, settings.element, settings.weighting, held);
    const StiffnessAndMass d = sum_matrices(cubes, unknowns, stiffness);
    const auto rigid = rigid_motions(cubes, unknowns, d, held);

    Modes modes;
    count_rigid(rigid, settings, Index(unknowns.count()), modes);
    const Index elastic = settings.count - modes.rigid;
    const Eigenpairs pairs =
        elastic_pairs(d, rigid, elastic, {cubes, unknowns, stiffness}, modes.report);
    for (const auto& piece : rigid) {
        for (Index m = 0; m < piece.motion.cols() && int(modes.shape.size()) < modes.rigid; ++m) {
            add_mode(cubes, unknowns, spread_out(piece, piece.motion.col(m), d.rows()), 0, modes);
        }
    }
    add_elastic(d, pairs, {cubes, unknowns, stiffness}, modes);
    CubeStiffness material(cubes, settings.element, settings.weighting);
    for (const auto& shape : modes.shape) {
        modes.damping.push_back(material_damping(cubes, shape, material));
    }
    return modes;
}

}  // namespace physics
