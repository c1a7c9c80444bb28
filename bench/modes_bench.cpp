// The 20 lowest modes of a block of cubes, held at one side: block Lanczos on fronts (Modes) and
// Spectra's Lanczos on Eigen's factorisation.

#include "physics/modal/modes.hpp"
#include "physics/modal/stiffness_matrix.hpp"

#include <Eigen/SparseCholesky>
#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/SymGEigsShiftSolver.h>

#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr int modes = 20;

geometry::Cubes block(int wide)
{
    std::vector<geometry::Vec3i> cells;
    for (int z = 0; z <= wide; ++z) {
        for (int y = 0; y < wide; ++y) {
            for (int x = 0; x < wide; ++x) cells.emplace_back(x, y, z);
        }
    }
    return geometry::solid_cubes(std::move(cells), 1.0 / wide, {}, geometry::Vec3::Zero());
}

std::vector<std::uint32_t> held_side(const geometry::Cubes& cubes)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k].x() == 0) out.push_back(k);
    }
    return out;
}

// (K - shift M)^-1
struct Inverse {
    using Scalar = double;
    const Sparse &k, &m;
    Eigen::SimplicialLDLT<Sparse> factor;

    Inverse(const Sparse& stiffness, const Sparse& mass) : k(stiffness), m(mass) {}
    Eigen::Index rows() const { return k.rows(); }
    Eigen::Index cols() const { return k.cols(); }
    void set_shift(double shift) { factor.compute(k - shift * m); }
    void perform_op(const double* from, double* to) const
    {
        Eigen::Map<Eigen::VectorXd>(to, rows()) =
            factor.solve(Eigen::Map<const Eigen::VectorXd>(from, rows()));
    }
};

// The lower triangle, with three rows and columns for each.
Sparse in_threes(const physics::StiffnessAndMass& of)
{
    std::vector<Eigen::Triplet<double>> numbers;
    for (Eigen::Index i = 0; i < of.mass.outerSize(); ++i) {
        for (decltype(of.mass)::InnerIterator it(of.mass, i); it; ++it) {
            for (int axis = 0; axis < 3 && it.col() <= it.row(); ++axis) {
                numbers.emplace_back(int(3 * it.row()) + axis, int(3 * it.col()) + axis,
                                     it.value());
            }
        }
    }
    Sparse out(of.rows(), of.rows());
    out.setFromTriplets(numbers.begin(), numbers.end());
    return out;
}

void fronts(benchmark::State& state)
{
    const geometry::Cubes cubes = block(int(state.range(0)));
    const auto held = held_side(cubes);
    for (auto _ : state) {
        const physics::Modes found = physics::lowest_modes(cubes, held, {.count = modes});
        state.counters["lowest"] = found.omega_sq.front();
        state.counters["highest"] = found.omega_sq.back();
    }
    state.counters["unknowns"] = 3 * double(cubes.corner_count() - held.size());
}

void spectra(benchmark::State& state)
{
    const geometry::Cubes cubes = block(int(state.range(0)));
    const auto held = held_side(cubes);
    for (auto _ : state) {
        const physics::Unknowns unknowns = physics::order_unknowns(cubes, held);
        physics::CubeStiffness stiffness(cubes, physics::BrickElement::incompatible,
                                         physics::Weighting::filled);
        const auto matrices = physics::sum_matrices(cubes, unknowns, stiffness);
        const Sparse mass = in_threes(matrices);
        Inverse inverse(matrices.stiffness, mass);
        Spectra::SparseSymMatProd<double> weigh(mass);
        Spectra::SymGEigsShiftSolver<Inverse, Spectra::SparseSymMatProd<double>,
                                     Spectra::GEigsMode::ShiftInvert>
            solver(inverse, weigh, modes, 2 * modes + 8, 0.0);
        solver.init();
        solver.compute(Spectra::SortRule::LargestMagn, 300, 1e-10);
        state.counters["lowest"] = solver.eigenvalues().minCoeff();
        state.counters["highest"] = solver.eigenvalues().maxCoeff();
    }
    state.counters["unknowns"] = 3 * double(cubes.corner_count() - held.size());
}

BENCHMARK(fronts)->Arg(14)->Arg(24)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(spectra)->Arg(14)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
