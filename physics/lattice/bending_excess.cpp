#include "physics/lattice/bending_excess.hpp"

#include "physics/lattice/lattice.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

// A cube's stiffness and place, E V (Pa m^3) and m.
struct StiffCube {
    double weight;
    Vec3 centre;
};

// A slight bend of one linked body.
struct Bend {
    double weight = 0;             // sum of E V
    Vec3 moment = Vec3::Zero();    // and of its moments
    Mat3 spread = Mat3::Zero();    //
    Vec3 centre, e1, e3;           // middle, longest and shortest axis
    double expected = 0, got = 0;  // energy, by the material and by the lattice
};

std::vector<StiffCube> stiff_cubes(const geometry::Cubes& cubes, Weighting weighting)
{
    const double h = cubes.size;
    std::vector<StiffCube> out(cubes.count());
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        out[c].centre = (cubes.cell[c].cast<double>() + Vec3::Constant(0.5)) * h;
        out[c].weight = cubes.young[c] * stiffness_share(cubes, c, weighting) * h * h * h;
    }
    return out;
}

// By number of the piece, with room for `pieces`: the principal axes of their stiffness.
std::vector<Bend> find_axes(const geometry::Cubes& cubes, const std::vector<StiffCube>& stiff,
                            const std::vector<std::uint32_t>& piece, std::size_t pieces)
{
    std::vector<Bend> bends(pieces);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto& [weight, centre] = stiff[c];
        Bend& b = bends[piece[cubes.corners[c][0]]];
        b.weight += weight;
        b.moment += weight * centre;
        b.spread += weight * centre * centre.transpose();
    }
    for (Bend& b : bends) {
        if (b.weight == 0) continue;
        b.centre = b.moment / b.weight;
        const Mat3 about = b.spread / b.weight - b.centre * b.centre.transpose();
        const Eigen::SelfAdjointEigenSolver<Mat3> eigen(about);
        b.e1 = eigen.eigenvectors().col(2);
        b.e3 = eigen.eigenvectors().col(0);
    }
    return bends;
}

// The lattice alone, with the stiffness of its material and one short step.
LatticeOptions bare_options(LatticeOptions options)
{
    options.stiffness = Stiffness::material;
    options.damping = 0;
    options.tear = 0;
    options.substeps = 1;
    options.precision = Precision::full;
    options.plastic.yield = 0;
    return options;
}

}  // namespace

std::vector<double> bending_excess(const geometry::Cubes& cubes, const LatticeBody& body,
                                   const std::vector<std::uint32_t>& piece)
{
    const std::size_t n = cubes.corner_count();
    const double h = cubes.size;
    const std::vector<StiffCube> stiff = stiff_cubes(cubes, body.options.weighting);
    std::vector<Bend> bends = find_axes(cubes, stiff, piece, n);
    double largest = 0;
    for (const float r : body.whole.rate_sq) largest = std::max(largest, double(r));
    State state = rest_state(body);
    const double kappa = 1e-7 / h, dt = 1e-3 / std::sqrt(largest);
    std::vector<Vec3> u(n);
    for (std::size_t k = 0; k < n; ++k) {
        const Bend& b = bends[piece[k]];
        const Vec3 p = cubes.corner[k].cast<double>() * h - b.centre;
        const double along = p.dot(b.e1), across = p.dot(b.e3);
        u[k] = kappa * (along * along / 2 * b.e3 - along * across * b.e1);
        state.x[k] += u[k];
    }
    const State after = advance(body, state, {}, dt, bare_options(body.options));
    for (std::size_t k = 0; k < n; ++k) {
        bends[piece[k]].got -= 0.5 * body.base.mass[k] * u[k].dot(after.v[k]) / dt;
    }
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        Bend& b = bends[piece[cubes.corners[c][0]]];
        const double away = (stiff[c].centre - b.centre).dot(b.e3);
        b.expected += 0.5 * stiff[c].weight * kappa * kappa * (away * away + h * h / 12);
    }
    std::vector<double> out(n, 1);
    for (std::size_t k = 0; k < n; ++k) {
        const Bend& b = bends[piece[k]];
        const double ratio = b.got / b.expected;
        if (ratio > 1e-3 && ratio < 1e3) out[k] = ratio;
    }
    return out;
}

}  // namespace physics
