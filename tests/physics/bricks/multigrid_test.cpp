#include "physics/bricks/multigrid.hpp"

#include "geometry/base/random.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/step_multigrid.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace {

using namespace physics;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using geometry::Vec3i;

std::array<BrickMatrix, 3> parts_of(double h)
{
    return {brick_stiffness(h, {0, 1}), brick_stiffness(h, {1, 0}, BrickElement::trilinear),
            BrickMatrix::Zero()};
}

Vec3i bits_of(int a)
{
    return {a & 1, a >> 1 & 1, a >> 2};
}

TEST(CoarseGrid, KeepsPartsOfOneCellApartAndJoinsWhatSharesCorners)
{
    // Two rods side by side in one row of cells of 4, and the same joined at their far end.
    std::vector<Vec3i> cells;
    for (int x = 0; x < 8; ++x) {
        cells.emplace_back(x, 0, 0);
        cells.emplace_back(x, 2, 0);
    }
    const auto of = [](const geometry::Cubes& cubes) {
        return coarsen({cubes.cell, cubes.corners, cubes.corner}, 4);
    };
    const CoarseGrid apart = of(fixtures::cubes_on(cells, 1));
    EXPECT_EQ(apart.cell.size(), 4u);
    EXPECT_EQ(apart.node.size(), 24u);
    cells.emplace_back(7, 1, 0);
    const CoarseGrid joined = of(fixtures::cubes_on(cells, 1));
    EXPECT_EQ(joined.cell.size(), 3u);
    EXPECT_EQ(joined.node.size(), 4u + 4u + 4u + 4u);
}

TEST(CoarseEnergy, OfACellOfCellsIsThatOfItsNodesAsTheyAreMoved)
{
    const geometry::Random random(3);
    CellMatrix half, expected;
    for (Index i = 0; i < half.size(); ++i) half(i) = random.unit(std::size_t(i)) - 0.5;
    const CellMatrix energy = half * half.transpose();
    for (int p = 0; p < 8; ++p) {
        // t_a = sum_j N_j (t_j + w_j x (x_a - x_j)), w_a = sum_j N_j w_j / 2
        CellMatrix q = CellMatrix::Zero();
        for (int a = 0; a < 8; ++a) {
            const auto motion = corner_motion(bits_of(p) + bits_of(a), 2);
            q.middleRows<3>(6 * a) = motion;
            for (Index j = 0; j < 8; ++j) {
                q.block<3, 3>(6 * a + 3, 6 * j + 3) = 0.5 * motion.middleCols<3>(6 * j);
            }
        }
        CellMatrix sum = CellMatrix::Zero();
        add_cell_of_cells(energy, bits_of(p), 2, sum);
        expected = q.transpose() * energy * q;
        EXPECT_LT((sum - expected).norm(), 1e-12 * expected.norm());
    }
}

// A dense sum over the cubes of a body and a diagonal, and its coarse grids.
struct Dense {
    explicit Dense(const geometry::Cubes& cubes) : held(cubes.corner_count(), 0)
    {
        const geometry::Random random(8);
        const auto n = Index(3 * cubes.corner_count());
        matrix = MatrixXd::Zero(n, n);
        for (std::size_t k = 0; k < 3; ++k) held[random.bits(k) % held.size()] = all_axes;
        held[random.bits(3) % held.size()] = 2;  // y
        const auto parts = parts_of(cubes.size);
        std::vector<std::array<double, 3>> weights;
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            weights.push_back({1 + random.unit(100 + 2 * c), 2 * random.unit(101 + 2 * c), 0});
            const BrickMatrix e = weights[c][0] * parts[0] + weights[c][1] * parts[1];
            for (Index i = 0; i < 24; ++i) {
                for (Index j = 0; j < 24; ++j) {
                    matrix(3 * Index{cubes.corners[c][std::size_t(i / 3)]} + i % 3,
                           3 * Index{cubes.corners[c][std::size_t(j / 3)]} + j % 3) += e(i, j);
                }
            }
        }
        matrix.diagonal().array() += 0.05;
        for (std::size_t k = 0; k < held.size(); ++k) slot.push_back(std::uint32_t(k));
        const std::vector<double> diagonal(held.size(), 0.05);
        coarse = Multigrid::make(cubes, {parts, weights, nullptr, {}}, diagonal, held);
    }

    VectorXd correct(const VectorXd& r)
    {
        std::vector<float> from(4 * held.size(), 0), to(from);
        for (Index i = 0; i < r.size(); ++i) {
            if (!is_held(i)) from[std::size_t(4 * (i / 3) + i % 3)] = float(r[i]);
        }
        coarse.correct(from.data(), to.data(), slot.data(), {}, work);
        VectorXd z(r.size());
        for (Index i = 0; i < r.size(); ++i) {
            z[i] = is_held(i) ? 0 : double(to[std::size_t(4 * (i / 3) + i % 3)]);
        }
        return z;
    }
    // Along an axis, at a corner that has free ones.
    bool is_held(Index number) const
    {
        const auto axes = held[std::size_t(number / 3)];
        return axes != all_axes && (axes >> (number % 3) & 1) != 0;
    }

    std::vector<std::uint8_t> held;
    std::vector<std::uint32_t> slot;
    MatrixXd matrix;
    Multigrid coarse;
    Multigrid::Work work;
};

VectorXd random_vector(Index n, std::uint64_t seed)
{
    const geometry::Random random(seed);
    VectorXd v(n);
    for (Index i = 0; i < n; ++i) v[i] = random.unit(std::size_t(i)) - 0.5;
    return v;
}

TEST(Multigrid, WithOneGridFindsTheBestOfTheMotionsThatItsNodesHave)
{
    // Then C A is a projection: C A (C r) = C r. Blended motions are not independent of each other;
    // the inverse has 1e-6 of the diagonal added, and in single precision that leaves 2 %.
    for (const auto& cubes : {fixtures::blob(1, 150, 0.5), fixtures::box(9, 5, 6, 0.5)}) {
        Dense dense(cubes);
        ASSERT_EQ(dense.coarse.levels(), 1u);
        const VectorXd z = dense.correct(random_vector(dense.matrix.rows(), 5));
        EXPECT_GT(z.norm(), 0.01);
        EXPECT_LT((dense.correct(dense.matrix * z) - z).norm(), 0.04 * z.norm());
        for (std::size_t k = 0; k < dense.held.size(); ++k) {
            if (dense.held[k] == all_axes) {
                EXPECT_EQ(z.segment<3>(Index(3 * k)).norm(), 0);
            }
        }
    }
}

// The equations of one step of 0.01 s of a body held at its low end.
struct Step {
    explicit Step(const geometry::Cubes& cubes)
        : body(make_bricks(cubes)), elasticity(body), held(fixtures::first_layer(cubes))
    {
        const std::size_t n = body.base.numbers;
        x = by_slot(body.base, rest_state(body).x);
        system.numbers = n;
        system.room = elasticity.room();
        system.multiply = [this](const float* p, float* y) { elasticity.multiply(p, y); };
        turn(0);
        Aligned<double> whole(n, 0);
        elasticity.add_diagonal(whole.data());
        system.diagonal.assign(n, 0), system.inverse.assign(n, 0);
        for (std::size_t k = 0; k < body.base.corners; ++k) {
            for (std::size_t i = 4 * k; i < 4 * k + 3; ++i) {
                system.diagonal[i] = float(body.base.mass[k]);
                system.inverse[i] = float(1 / (body.base.mass[k] + whole[i]));
            }
        }
        for (const auto k : held) {
            for (std::size_t i = 0; i < 3; ++i) {
                system.inverse[4 * body.base.slot_of(k) + i] = 0;
            }
        }
        multigrid.start(elasticity.prepare_coarse(tau * tau, tau, body.base.mass, {held, {}}));
    }

    // Twists the body by an angle a metre.
    void turn(double angle)
    {
        Aligned<double> turned = x, force(elasticity.room());
        for (std::size_t i = 0; i < 4 * body.base.corners; i += 4) {
            const double c = std::cos(angle * x[i]), s = std::sin(angle * x[i]);
            turned[i + 1] = c * x[i + 1] - s * x[i + 2];
            turned[i + 2] = s * x[i + 1] + c * x[i + 2];
        }
        elasticity.forces(turned.data(), force.data());
        elasticity.weigh(tau * tau, tau);
    }

    Aligned<float> random_force(std::uint64_t seed) const
    {
        const geometry::Random random(seed);
        Aligned<float> r(system.numbers, 0);
        for (std::size_t i = 0; i < r.size(); ++i) {
            if (system.inverse[i] != 0) r[i] = float(random.unit(i) - 0.5);
        }
        return r;
    }

    Aligned<float> precondition(const Aligned<float>& r)
    {
        Aligned<float> z(r.size(), 0);
        multigrid.apply(system, elasticity, r.data(), z.data());
        return z;
    }

    // Solves for a force to a residual of `part` of it.
    Solved solve(const Aligned<float>& r, double part, bool by_multigrid)
    {
        system.precondition = nullptr;
        if (by_multigrid) {
            system.precondition = [this](const float* from, float* to) {
                multigrid.apply(system, elasticity, from, to);
            };
        }
        double size_sq = 0;
        for (std::size_t i = 0; i < r.size(); ++i) {
            size_sq += double(r[i]) * double(r[i]) * double(system.inverse[i]);
        }
        work.r = r;
        return conjugate_gradients(system, part * std::sqrt(size_sq), 4000, work);
    }

    static constexpr double tau = 0.01;
    BricksBody body;
    BrickElasticity elasticity;
    std::vector<std::uint32_t> held;
    Aligned<double> x;
    LinearSystem<float> system;
    StepMultigrid multigrid;
    ConjugateVectors<float> work;
};

double dot(const Aligned<float>& a, const Aligned<float>& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += double(a[i]) * double(b[i]);
    return sum;
}

TEST(StepMultigrid, IsSymmetricAndPositiveForTwistedBodiesToo)
{
    Step step(fixtures::box(30, 12, 12, 0.1));
    for (const double angle : {0.0, 2.0}) {
        step.turn(angle);
        const auto a = step.random_force(1), b = step.random_force(2);
        const auto of_a = step.precondition(a), of_b = step.precondition(b);
        EXPECT_GT(dot(a, of_a), 0);
        EXPECT_GT(dot(b, of_b), 0);
        EXPECT_NEAR(dot(a, of_b), dot(b, of_a), 1e-5 * std::sqrt(dot(a, of_a) * dot(b, of_b)));
        EXPECT_TRUE(step.solve(a, 1e-5, true).converged);
    }
}

TEST(StepMultigrid, SolvesAsTheDiagonalDoesInFewerIterations)
{
    geometry::Cubes cubes = fixtures::box(16, 14, 13, 0.1);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (cubes.cell[c].y() < 7) cubes.young[c] *= 1e6;  // a stiffness ratio of 1e6
        if (cubes.cell[c].x() == 10) cubes.fill[c] = 1e-3, cubes.mass[c] *= 1e-3;
    }
    Step step(cubes);
    const auto r = step.random_force(7);
    const Solved slow = step.solve(r, 1e-6, false);
    const Aligned<float> expected = step.work.x;
    const Solved quick = step.solve(r, 1e-6, true);
    EXPECT_TRUE(quick.converged);
    EXPECT_LE(5 * quick.iterations, slow.iterations);
    // The residual is measured by forces: in energy the two differ by about its square.
    Aligned<float> difference = expected;
    for (std::size_t i = 0; i < r.size(); ++i) difference[i] -= step.work.x[i];
    Aligned<float> product(step.system.room, 0);
    const auto energy = [&](const Aligned<float>& u) {
        step.elasticity.multiply(u.data(), product.data());
        double sum = 0;
        for (std::size_t i = 0; i < u.size(); ++i) {
            sum += double(u[i]) * double(product[i] + step.system.diagonal[i] * u[i]);
        }
        return sum;
    };
    EXPECT_LT(energy(difference), 1e-6 * energy(expected));
}

TEST(StepMultigrid, TakesNoMoreIterationsInLargerBodies)
{
    const auto iterations = [](int n) {
        Step step(fixtures::box(n, n, n, 1.0 / n));
        Aligned<float> weight(step.system.numbers, 0);  // N: down, at free corners
        for (std::size_t i = 1; i < weight.size(); i += 4) {
            if (step.system.inverse[i] != 0) weight[i] = -9.81f * step.system.diagonal[i];
        }
        return step.solve(weight, 1e-6, true).iterations;
    };
    const int small = iterations(13);
    EXPECT_GT(small, 3);
    EXPECT_LE(iterations(26), small + 3);
}

TEST(StepMultigrid, MovesABodyAsTheDiagonalDoes)
{
    const geometry::Cubes cubes = fixtures::box(20, 20, 20, 0.05);
    BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    for (const auto k : fixtures::first_layer(cubes)) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    const auto step = [&] {
        return advance(body, rest_state(body), loads, 0.05, {.tolerance = 1e-8});
    };
    const State quick = step();
    body.multigrids = nullptr;
    const State slow = step();
    EXPECT_LT(4 * quick.report.iterations, slow.report.iterations);
    double most = 0, moved = 0;
    for (std::size_t k = 0; k < quick.x.size(); ++k) {
        most = std::max(most, (quick.x[k] - slow.x[k]).norm());
        moved = std::max(moved, (quick.x[k] - cubes.corner_position(k)).norm());
    }
    EXPECT_LT(most, 1e-6 * moved);
}

// What a body takes for its cubes' largest eigenvalue is that at an end of their Poisson ratios.
TEST(StepMultigrid, BoundsTheEigenvaluesOfCubesOfAnyPoissonRatio)
{
    std::vector<double> largest;
    for (double poisson = -0.95; poisson < 0.499; poisson += 0.05) {
        const auto cubes = fixtures::box(1, 1, 1, 0.5, {.poisson = poisson});
        largest.push_back(make_bricks(cubes).largest_eigenvalue);
    }
    for (std::size_t i = 1; i + 1 < largest.size(); ++i) {
        EXPECT_LE(largest[i], std::max(largest[i - 1], largest[i + 1]));
    }
}

TEST(StepMultigrid, GivesTheSameBytesOnOneThreadAndTwo)
{
    Step step(fixtures::box(20, 20, 20, 0.1));
    const auto r = step.random_force(3);
    const auto many = step.precondition(r);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    Step again(fixtures::box(20, 20, 20, 0.1));
    EXPECT_EQ(many, again.precondition(r));
}

}  // namespace
