#include "physics/bricks/corner_factor.hpp"

#include "geometry/base/random.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <set>

namespace {

using namespace physics;
using geometry::no_index;

struct Problem {
    geometry::Cubes cubes;
    std::vector<char> held;
    std::array<BrickMatrix, 3> parts;
    std::vector<std::array<double, 3>> weights;
    std::vector<double> diagonal;
};

Problem problem(const geometry::Cubes& cubes)
{
    Problem p;
    p.cubes = cubes;
    const geometry::Random random(8);
    p.held.assign(cubes.corner_count(), 0);
    for (std::size_t k = 0; k < 5; ++k) p.held[random.bits(k) % p.held.size()] = 1;
    p.parts = {brick_stiffness(cubes.size, {0, 1}),
               brick_stiffness(cubes.size, {1, 0}, BrickElement::trilinear), BrickMatrix::Zero()};
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        p.weights.push_back({1 + random.unit(100 + 2 * c), 2 * random.unit(101 + 2 * c), 0});
    }
    p.diagonal.assign(cubes.corner_count(), 0.05);
    return p;
}

// Largest difference to a dense solve of the same system, relative to the solution's largest.
double error(const Problem& p)
{
    const auto k = static_cast<Eigen::Index>(p.cubes.corner_count());
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * k, 3 * k);
    for (std::size_t c = 0; c < p.cubes.count(); ++c) {
        const BrickMatrix e = p.weights[c][0] * p.parts[0] + p.weights[c][1] * p.parts[1];
        for (int i = 0; i < 24; ++i) {
            for (int j = 0; j < 24; ++j) {
                a(3 * Eigen::Index{p.cubes.corners[c][std::size_t(i / 3)]} + i % 3,
                  3 * Eigen::Index{p.cubes.corners[c][std::size_t(j / 3)]} + j % 3) += e(i, j);
            }
        }
    }
    Eigen::VectorXd b(3 * k);
    const geometry::Random random(4);
    std::vector<float> from(4 * std::size_t(k), 0), to(4 * std::size_t(k), 0);
    std::vector<std::uint32_t> slot(static_cast<std::size_t>(k));
    for (Eigen::Index i = 0; i < k; ++i) {
        slot[std::size_t(i)] = static_cast<std::uint32_t>(k - 1 - i);  // any order
        for (Eigen::Index j = 0; j < 3; ++j) {
            const auto value = static_cast<float>(random.unit(std::size_t(3 * i + j)) - 0.5);
            b[3 * i + j] = double(value);
            from[4 * std::size_t(k - 1 - i) + std::size_t(j)] = value;
            a(3 * i + j, 3 * i + j) += p.diagonal[std::size_t(i)];
            if (!p.held[std::size_t(i)]) continue;
            a.row(3 * i + j).setZero();
            a.col(3 * i + j).setZero();
            a(3 * i + j, 3 * i + j) = 1;
            b[3 * i + j] = 0;
        }
    }
    const Eigen::VectorXd expected = a.llt().solve(b);
    Dissection tree = dissect(p.cubes, p.held, 1e9);
    const auto factor =
        CornerFactor::make(std::move(tree), {p.parts, p.weights, nullptr, {}}, p.diagonal);
    EXPECT_TRUE(factor.has_value());
    Aligned<float> work;
    factor->solve(from.data(), to.data(), slot.data(), work);
    double worst = 0;
    for (Eigen::Index i = 0; i < k; ++i) {
        for (Eigen::Index j = 0; j < 3; ++j) {
            const double x = double(to[4 * std::size_t(k - 1 - i) + std::size_t(j)]);
            worst = std::max(worst, std::abs(x - expected[3 * i + j]));
        }
    }
    return worst / expected.cwiseAbs().maxCoeff();
}

TEST(CornerFactor, SolvesAsADenseFactorizationDoes)
{
    // Single precision, condition below 1e3.
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        EXPECT_LT(error(problem(fixtures::blob(seed, 150, 0.5))), 1e-5);
    }
    EXPECT_LT(error(problem(fixtures::box(20, 2, 2, 0.5))), 1e-5);
    EXPECT_LT(error(problem(fixtures::box(1, 1, 1, 0.5))), 1e-5);
    EXPECT_LT(error(problem(fixtures::cubes_on({{0, 0, 0}, {1000, 0, 0}, {0, -70000, 5}}, 0.5))),
              1e-5);
}

TEST(CornerFactor, SaysWhenAPivotIsNotPositive)
{
    Problem p = problem(fixtures::box(2, 1, 1, 0.5));
    p.diagonal.assign(p.diagonal.size(), -1e3);
    EXPECT_FALSE(CornerFactor::make(dissect(p.cubes, {}, 1e9), {p.parts, p.weights, nullptr, {}},
                                    p.diagonal));
}

TEST(Dissection, EliminatesEveryCornerOnceAndKnowsItsBorder)
{
    const auto cubes = fixtures::blob(5, 800, 1);
    const Dissection tree = dissect(cubes, {}, 1e9);
    std::vector<std::uint32_t> front(cubes.corner_count(), no_index);
    for (std::uint32_t f = 0; f < tree.fronts.size(); ++f) {
        for (const auto k : tree.fronts[f].pivots) {
            EXPECT_EQ(front[k], no_index);
            front[k] = f;
        }
        EXPECT_TRUE(tree.fronts[f].parent == no_index || tree.fronts[f].parent > f);
    }
    EXPECT_EQ(std::count(front.begin(), front.end(), no_index), 0);
    // The border of a front is what its branch meets outside the branch.
    std::vector<std::set<std::uint32_t>> meets(tree.fronts.size());
    for (const auto& eight : cubes.corners) {
        for (const auto a : eight) {
            for (const auto b : eight) {
                if (front[b] > front[a]) meets[front[a]].insert(b);
            }
        }
    }
    for (std::uint32_t f = 0; f < tree.fronts.size(); ++f) {
        for (const auto child : tree.fronts[f].children) {
            for (const auto k : meets[child]) {
                if (front[k] != f) meets[f].insert(k);
            }
        }
        const auto& border = tree.fronts[f].border;
        EXPECT_EQ(std::set(border.begin(), border.end()), meets[f]);
    }
    EXPECT_TRUE(dissect(cubes, {}, 100).fronts.empty());
}

}  // namespace
