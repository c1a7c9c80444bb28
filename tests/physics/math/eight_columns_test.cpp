#include "physics/math/eight_columns.hpp"

#include "geometry/base/random.hpp"
#include "tests/physics/every_target.hpp"

#include <tbb/global_control.h>

#include <Eigen/SparseCore>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace {

using namespace physics;
using Eigen::Index;
using Eigen::MatrixXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>;

EightColumns random_rows(std::size_t rows, std::uint64_t seed)
{
    const geometry::Random random(seed);
    EightColumns out(eight * rows);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = random.unit(i) - 0.5;
    return out;
}

MatrixXd matrix_of(const EightColumns& x)
{
    return Eigen::Map<const Rows>(x.data(), Index(x.size() / eight), 8);
}

constexpr std::size_t corners = 1733, rows = 3 * corners;

// About five numbers a row.
Eigen::SparseMatrix<double, Eigen::RowMajor> some_sparse()
{
    const geometry::Random random(7);
    std::vector<Eigen::Triplet<double>> of;
    for (std::size_t i = 0; i < corners; ++i) {
        for (std::size_t k = 0; k < 5; ++k) {
            const std::uint64_t bits = random.bits(5 * i + k);
            of.emplace_back(int(i), int(bits % corners), double(bits >> 40) * 0x1p-24);
        }
    }
    Eigen::SparseMatrix<double, Eigen::RowMajor> out(Index{corners}, Index{corners});
    out.setFromTriplets(of.begin(), of.end());
    return out;
}

EightColumns sparse_product(const Eigen::SparseMatrix<double, Eigen::RowMajor>& a,
                            const EightColumns& x)
{
    EightColumns out;
    times_in_threes(corners, {a.outerIndexPtr(), a.innerIndexPtr(), a.valuePtr()}, x, out);
    return out;
}

// The columns of a front with a strong diagonal; above it, numbers that count for nothing.
MatrixXd some_front(Index pivots, Index border)
{
    const geometry::Random random(9);
    MatrixXd out(pivots + border, pivots);
    for (Index i = 0; i < out.size(); ++i) out.data()[i] = random.unit(std::uint64_t(i)) - 0.5;
    for (Index i = 0; i < pivots; ++i) out(i, i) = 3 + random.unit(std::uint64_t(7 * i));
    return out;
}

TEST(EightColumns, MultiplyAsMatricesDo)
{
    const EightColumns a = random_rows(rows, 1), b = random_rows(rows, 2);
    const Eights dots = transposed_times(a, b);
    const MatrixXd expected = matrix_of(a).transpose() * matrix_of(b);
    EXPECT_LT((dots - expected).norm(), 1e-12 * expected.norm());
    EightColumns c = random_rows(rows, 3);
    const MatrixXd rest = matrix_of(c) - matrix_of(a) * dots;
    subtract_times(a, dots, c);
    EXPECT_LT((matrix_of(c) - rest).norm(), 1e-14 * rest.norm());
}

TEST(EightColumns, ThreeRowsStandForOneOfASparseMatrix)
{
    const auto a = some_sparse();
    const EightColumns x = random_rows(rows, 4);
    const MatrixXd found = matrix_of(sparse_product(a, x)), from = matrix_of(x);
    for (Index axis = 0; axis < 3; ++axis) {
        MatrixXd own(Index{corners}, 8), product(Index{corners}, 8);
        for (Index i = 0; i < own.rows(); ++i) own.row(i) = from.row(3 * i + axis);
        for (Index i = 0; i < own.rows(); ++i) product.row(i) = found.row(3 * i + axis);
        EXPECT_LT((product - a * own).norm(), 1e-14 * product.norm()) << axis;
    }
}

TEST(EightColumns, AreSolvedForWithTheColumnsOfAFront)
{
    for (const Index pivots : {1, 3, 4, 30, 49}) {
        for (const Index border : {0, 1, 50}) {
            const MatrixXd columns = some_front(pivots, border);
            const MatrixXd l = columns.topRows(pivots).triangularView<Eigen::Lower>();
            const MatrixXd below = columns.bottomRows(border);
            const EightColumns start = random_rows(std::size_t(pivots + border), 5);
            const MatrixXd x = matrix_of(start);
            EightColumns down = start, up = start;
            solve_down(std::size_t(pivots), std::size_t(border), columns.data(), down.data());
            solve_up(std::size_t(pivots), std::size_t(border), columns.data(), up.data());
            const MatrixXd y = l.triangularView<Eigen::Lower>().solve(x.topRows(pivots));
            MatrixXd expected(pivots + border, 8);
            expected << y, x.bottomRows(border) - below * y;
            EXPECT_LT((matrix_of(down) - expected).norm(), 1e-13 * expected.norm());
            const MatrixXd known = x.topRows(pivots) - below.transpose() * x.bottomRows(border);
            expected.topRows(pivots) = l.transpose().triangularView<Eigen::Upper>().solve(known);
            expected.bottomRows(border) = x.bottomRows(border);
            EXPECT_LT((matrix_of(up) - expected).norm(), 1e-13 * expected.norm());
        }
    }
}

TEST(EightColumns, RowsOfFourAreSolvedForAsTheFirstFourOfEight)
{
    for (const Index pivots : {1, 3, 4, 30, 49}) {
        for (const Index border : {0, 1, 50}) {
            const MatrixXd columns = some_front(pivots, border);
            const auto p = std::size_t(pivots), b = std::size_t(border);
            const EightColumns start = random_rows(p + b, 5);
            EightColumns down = start, up = start, four_down, four_up;
            for (std::size_t i = 0; i < p + b; ++i) {
                const double* from = &start[eight * i];
                four_down.insert(four_down.end(), from, from + 4);
            }
            four_up = four_down;
            solve_down(p, b, columns.data(), down.data());
            solve_up(p, b, columns.data(), up.data());
            solve_four_down(p, b, columns.data(), four_down.data());
            solve_four_up(p, b, columns.data(), four_up.data());
            for (std::size_t i = 0; i < 4 * (p + b); ++i) {
                const std::size_t at = eight * (i / 4) + i % 4;
                ASSERT_EQ(four_down[i], down[at]) << i;
                ASSERT_EQ(four_up[i], up[at]) << i;
            }
        }
    }
}

// Every kernel's numbers, one after the other.
std::vector<double> all_products()
{
    const EightColumns a = random_rows(rows, 1), b = random_rows(rows, 2);
    EightColumns c = random_rows(rows, 3), front = random_rows(90, 5);
    const Eights dots = transposed_times(a, b);
    subtract_times(a, dots, c);
    EightColumns product = sparse_product(some_sparse(), a);
    const MatrixXd columns = some_front(30, 60);
    solve_down(30, 60, columns.data(), front.data());
    solve_up(30, 60, columns.data(), front.data());
    std::vector<double> out(dots.data(), dots.data() + dots.size());
    for (const EightColumns* x : {&c, &product, &front})
        out.insert(out.end(), x->begin(), x->end());
    return out;
}

TEST(EightColumns, HaveTheSameBitsOnAnyProcessorAndAnyNumberOfThreads)
{
    const std::vector<double> here = all_products();
    on_every_target([&](const char* target) { EXPECT_EQ(all_products(), here) << target; });
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(all_products(), here);
}

}  // namespace
