#include "physics/bricks/direct_factor.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/body/point_contact.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <numeric>

namespace {

using namespace physics;

// A sum of a positive matrix a cube and a diagonal, with a few corners held.
struct Sum {
    geometry::Cubes cubes;
    std::vector<BrickMatrix> matrix;
    std::vector<char> held;
    std::vector<std::uint32_t> slot;  // backwards
    std::vector<double> diagonal, right;

    explicit Sum(geometry::Cubes its_cubes) : cubes(std::move(its_cubes))
    {
        const std::size_t corners = cubes.corner_count();
        const geometry::Random random(8);
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            const double young = std::pow(1e6, random.unit(c));
            matrix.push_back(brick_stiffness(cubes.size, lame(young, 0.3)));
        }
        held.assign(corners, 0);
        for (std::size_t k = 0; k < 5; ++k) held[random.bits(k) % corners] = 1;
        slot.resize(corners);
        std::iota(slot.rbegin(), slot.rend(), 0u);
        diagonal.assign(4 * corners, 0.05);
        right.resize(4 * corners);
        for (std::size_t i = 0; i < right.size(); ++i) right[i] = random.unit(1000 + i) - 0.5;
    }

    std::optional<DirectFactor> factor() const
    {
        auto tree = std::make_shared<const Dissection>(dissect(cubes, held, 1e9, 8));
        return DirectFactor::make(std::move(tree), matrix, diagonal, slot, axes);
    }
    std::vector<double> solution() const
    {
        std::vector<double> x(right.size(), 0);
        factor()->solve(right.data(), x.data());
        for (std::size_t k = 0; k < axes.size(); ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                if (is_held(k, i)) x[4 * std::size_t{slot[k]} + i] = 0;
            }
        }
        return x;
    }
    // The largest number of right - A x at free corners.
    double left_over(const std::vector<double>& x) const
    {
        std::vector<double> rest = right;
        for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= diagonal[i] * x[i];
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            BrickVector u;
            for (Eigen::Index i = 0; i < 24; ++i) u[i] = x[number(c, i)];
            const BrickVector f = matrix[c] * u;
            for (Eigen::Index i = 0; i < 24; ++i) rest[number(c, i)] -= f[i];
        }
        double most = 0;
        for (std::size_t k = 0; k < held.size(); ++k) {
            for (std::size_t i = 0; i < 3 && !held[k]; ++i) {
                if (is_held(k, i)) continue;
                most = std::max(most, std::abs(rest[4 * std::size_t{slot[k]} + i]));
            }
        }
        return most;
    }

    bool is_held(std::size_t k, std::size_t axis) const
    {
        return !axes.empty() && (axes[k] >> axis & 1) != 0;
    }

    std::vector<std::uint8_t> axes;  // of corners that are not held wholly; empty: none

private:
    std::size_t number(std::size_t c, Eigen::Index i) const
    {
        const auto at = static_cast<std::size_t>(i);
        return 4 * std::size_t{slot[cubes.corners[c][at / 3]]} + at % 3;
    }
};

TEST(DirectFactor, LeavesOnlyRoundingOver)
{
    // Stiffness ratio 1e6: numbers of A x are up to 1e6 times those of the right-hand side, whose
    // rounding is 1e-16 each.
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        const Sum sum(fixtures::blob(seed, 150, 0.5));
        EXPECT_LT(sum.left_over(sum.solution()), 1e-8);
    }
    for (const auto& cubes :
         {fixtures::box(200, 1, 1, 0.5), fixtures::box(30, 3, 2, 0.5), fixtures::box(1, 1, 1, 0.5),
          fixtures::cubes_on({{0, 0, 0}, {1000, 0, 0}, {0, -70000, 5}}, 0.5)}) {
        const Sum sum(cubes);
        EXPECT_LT(sum.left_over(sum.solution()), 1e-8);
    }
}

// Nothing is eliminated at a cut between them.
TEST(DirectFactor, TakesPartsWithEmptyLayersBetween)
{
    std::vector<geometry::Vec3i> cells;
    const geometry::Cubes part = fixtures::box(3, 3, 3, 0.1);
    for (const auto& c : part.cell) {
        cells.push_back(c);
        cells.push_back(c + geometry::Vec3i(0, 6, 0));
    }
    const Sum sum(fixtures::cubes_on(cells, 0.1));
    EXPECT_LT(sum.left_over(sum.solution()), 1e-9);
}

TEST(DirectFactor, KeepsHeldCornersAsTheyAre)
{
    const Sum sum(fixtures::box(20, 2, 2, 0.5));
    std::vector<double> x(sum.right.size(), 7);
    sum.factor()->solve(sum.right.data(), x.data());
    for (std::size_t k = 0; k < sum.held.size(); ++k) {
        EXPECT_EQ(x[4 * std::size_t{sum.slot[k]}] == 7, sum.held[k] != 0);
    }
}

TEST(DirectFactor, SolvesEightAtATimeAsOneByOne)
{
    const Sum sum(fixtures::blob(2, 150, 0.5));
    auto factor = sum.factor();
    const std::size_t corners = sum.slot.size();
    const geometry::Random random(5);
    EightColumns right(3 * eight * corners), found(right.size(), 7);
    for (std::size_t i = 0; i < right.size(); ++i) right[i] = random.unit(i) - 0.5;
    factor->solve(right, found);
    for (std::size_t j = 0; j < eight; ++j) {
        std::vector<double> one(4 * corners), x(4 * corners, 7);
        const auto at = [&](std::size_t i) { return eight * (3 * (i / 4) + i % 4) + j; };
        for (std::size_t i = 0; i < one.size(); ++i) one[i] = i % 4 < 3 ? right[at(i)] : 0;
        factor->solve(one.data(), x.data());
        double most = 0, off = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (i % 4 == 3) continue;
            most = std::max(most, std::abs(x[i]));
            off = std::max(off, std::abs(x[i] - found[at(i)]));
        }
        EXPECT_LT(off, 1e-9 * most) << j;
    }
}

TEST(DirectFactor, SolvesBetweenTheAxesThatAreFree)
{
    Sum sum(fixtures::blob(1, 150, 0.5));
    sum.axes.resize(sum.held.size());
    for (std::size_t k = 0; k < sum.axes.size(); ++k) {
        sum.axes[k] = static_cast<std::uint8_t>(k % 7);  // none, x, y, xy, ..
    }
    EXPECT_LT(sum.left_over(sum.solution()), 1e-8);
}

TEST(DirectFactor, GivesTheSameBytesForAnyNumberOfThreads)
{
    const Sum sum(fixtures::box(100, 4, 4, 0.5));
    std::vector<std::vector<double>> solutions;
    for (const std::size_t threads : {1u, 4u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        solutions.push_back(sum.solution());
    }
    EXPECT_EQ(solutions[0], solutions[1]);
}

TEST(DirectFactor, SaysWhenAPivotIsNotPositive)
{
    Sum sum(fixtures::box(30, 1, 1, 0.5));
    sum.diagonal.assign(sum.diagonal.size(), -1e9);
    EXPECT_FALSE(sum.factor());
}

// Bricks of two materials, with damping and masses that are not lumped, bent and pulled apart.
struct Bent {
    BricksBody body;
    BrickElasticity elasticity;
    std::size_t n;

    explicit Bent(BrickElement element = BrickElement::incompatible)
        : body(make_bricks(cubes(), {.element = element})), elasticity(body), n(body.base.numbers)
    {
        const geometry::Random random(3);
        Aligned<double> x = body.base.rest, f(elasticity.room());
        for (std::size_t i = 0; i < n; ++i) x[i] += i % 4 < 3 ? 0.2 * random.unit(i) : 0;
        elasticity.weigh(0.01, 0.1);
        elasticity.use_hessian(true);
        elasticity.forces(x.data(), f.data());
        elasticity.couple(1, 0.1);
    }
    static geometry::Cubes cubes()
    {
        auto out = fixtures::box(9, 3, 2, 0.5, {.poisson = 0.4, .stiffness_damping = 0.02});
        for (std::size_t c = 0; c < out.count(); c += 2) out.young[c] = 3e4;
        return out;
    }
    // Of the product with the sum of the cubes' matrices: its largest difference to the kernels'
    // product, as a share of that.
    double error()
    {
        std::vector<BrickMatrix> matrix;
        EXPECT_TRUE(elasticity.cube_matrices(matrix));
        const geometry::Random random(5);
        Aligned<double> p(n), y(elasticity.room()), sum(n, 0);
        for (std::size_t i = 0; i < n; ++i) p[i] = i % 4 < 3 ? random.unit(i) - 0.5 : 0;
        elasticity.multiply(p.data(), y.data());
        for (std::size_t c = 0; c < body.cubes; ++c) {
            for (Eigen::Index i = 0; i < 24; ++i) {
                for (Eigen::Index j = 0; j < 24; ++j) {
                    sum[number(c, i)] += matrix[c](i, j) * p[number(c, j)];
                }
            }
        }
        double worst = 0, most = 0;
        for (std::size_t k = 0; k < 4 * body.base.corners; ++k) {
            worst = std::max(worst, std::abs(sum[k] - y[k]));
            most = std::max(most, std::abs(y[k]));
        }
        return worst / most;
    }

private:
    std::size_t number(std::size_t c, Eigen::Index i) const
    {
        const auto at = static_cast<std::size_t>(i);
        return 4 * std::size_t{body.base.slot[body.rest->corners[c][at / 3]]} + at % 3;
    }
};

TEST(BrickMatrices, AddUpToTheProductOfTheKernels)
{
    Bent bent;
    EXPECT_LT(bent.error(), 1e-13);
    bent.elasticity.use_hessian(false);
    EXPECT_LT(bent.error(), 1e-13);
    bent.elasticity.couple(0, 0);
    EXPECT_LT(bent.error(), 1e-13);
}

TEST(BrickMatrices, OfOnePointAddUpToTheProductOfTheKernels)
{
    Bent bent(BrickElement::one_point);
    EXPECT_LT(bent.error(), 1e-13);
    bent.elasticity.use_hessian(false);
    EXPECT_LT(bent.error(), 1e-13);
}

// What a point that touches a collider adds, W^T B W, stands in the matrix of its cube.
TEST(BrickMatrices, ATouchedPointAddsToThatOfItsCubeAlone)
{
    Bent bent;
    const geometry::Mat3 block = geometry::Vec3(1, 2, 3) * geometry::Vec3(1, 2, 3).transpose() +
                                 0.5 * geometry::Mat3::Identity();
    const auto weights = geometry::trilinear_weights({0.2, 0.7, 0.4});
    const geometry::Random random(6);
    for (const std::uint32_t c : {0u, 17u, 53u}) {
        PointContact contact{};
        for (std::size_t a = 0; a < 8; ++a) {
            contact.corners[a] = bent.body.base.slot[bent.body.rest->corners[c][a]];
            contact.weight[a] = static_cast<float>(weights[a]);
        }
        std::vector<BrickMatrix> before, after;
        ASSERT_TRUE(bent.elasticity.cube_matrices(before));
        after = before;
        bent.elasticity.add_contact(contact, block, after);
        BrickVector p, expected;
        geometry::Vec3 moved = geometry::Vec3::Zero();
        for (Eigen::Index i = 0; i < 24; ++i) p[i] = random.unit(std::uint64_t(i)) - 0.5;
        for (Eigen::Index a = 0; a < 8; ++a) {
            moved += double(contact.weight[std::size_t(a)]) * p.segment<3>(3 * a);
        }
        for (Eigen::Index a = 0; a < 8; ++a) {
            expected.segment<3>(3 * a) = double(contact.weight[std::size_t(a)]) * (block * moved);
        }
        for (std::uint32_t k = 0; k < bent.body.cubes; ++k) {
            const BrickVector added = (after[k] - before[k]) * p;
            const double off = k == c ? (added - expected).norm() : added.norm();
            EXPECT_LT(off, 1e-9 * expected.norm()) << c << ' ' << k;
        }
        // A point of a part that touches another one is in two cubes, and these are not one cube's.
        const auto once = after;
        contact.count = 16;
        bent.elasticity.add_contact(contact, block, after);
        contact.count = 8;
        std::swap(contact.corners[0], contact.corners[7]);
        bent.elasticity.add_contact(contact, block, after);
        for (std::uint32_t k = 0; k < bent.body.cubes; ++k) EXPECT_EQ(after[k], once[k]) << k;
    }
}

TEST(BrickMatrices, TheirFactorAndDiagonalAreThoseOfTheKernels)
{
    // At rest: the factor of K + M against a product, and the product's diagonal.
    for (const auto element : {BrickElement::incompatible, BrickElement::trilinear,
                               BrickElement::one_point, BrickElement::relaxed}) {
        const BricksBody body = make_bricks(Bent::cubes(), {.element = element});
        BrickElasticity elasticity(body);
        const std::size_t n = body.base.numbers;
        Aligned<double> x = body.base.rest, f(elasticity.room()), diagonal(n, 0);
        elasticity.forces(x.data(), f.data());
        elasticity.weigh(1, 0);
        elasticity.add_diagonal(diagonal.data());
        std::vector<double> mass(n / 4, 1e3);
        ASSERT_TRUE(std::isfinite(elasticity.prepare_inverse(1, 0, mass, {})));
        const geometry::Random random(8);
        Aligned<double> p(n, 0), y(elasticity.room(), 0);
        for (std::size_t i = 0; i < n; ++i) p[i] = i % 4 < 3 ? random.unit(i) - 0.5 : 0;
        elasticity.multiply(p.data(), y.data());
        Aligned<float> right(n, 0), found(n, 0);
        for (std::size_t i = 0; i < n; ++i) right[i] = float(y[i] + 1e3 * p[i]);
        elasticity.apply_inverse(right.data(), found.data());
        for (std::size_t k = 0; k < body.base.corners; ++k) {
            for (std::size_t i = 4 * k; i < 4 * k + 3; ++i)
                EXPECT_NEAR(double(found[i]), p[i], 1e-4);
            Aligned<double> unit(n, 0), row(elasticity.room());
            unit[4 * k + 1] = 1;
            elasticity.multiply(unit.data(), row.data());
            EXPECT_NEAR(row[4 * k + 1], diagonal[4 * k + 1], 1e-12 * diagonal[4 * k + 1]);
        }
    }
}

}  // namespace
