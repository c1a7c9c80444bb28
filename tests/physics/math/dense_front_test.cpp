#include "physics/math/dense_front.hpp"

#include "geometry/base/random.hpp"
#include "tests/physics/every_target.hpp"

#include <tbb/global_control.h>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

namespace {

using namespace physics;
using Eigen::Index;
using Eigen::MatrixXd;

// Symmetric and positive.
MatrixXd some_matrix(Index n)
{
    const geometry::Random random{std::uint64_t(n)};
    MatrixXd a(n, n);
    for (Index i = 0; i < a.size(); ++i) a.data()[i] = random.unit(std::uint64_t(i)) - 0.5;
    return a * a.transpose() + MatrixXd::Identity(n, n);
}

struct Front {
    MatrixXd columns, rest;
    bool positive = false;
};

// What lies above the diagonal is not a number: it may not be read.
Front eliminated(const MatrixXd& a, Index pivots)
{
    MatrixXd lower =
        MatrixXd::Constant(a.rows(), a.cols(), std::numeric_limits<double>::quiet_NaN());
    lower.triangularView<Eigen::Lower>() = a;
    const Index border = a.rows() - pivots;
    Front out{lower.leftCols(pivots), lower.bottomRightCorner(border, border)};
    out.positive = eliminate_front(std::size_t(pivots), std::size_t(border), out.columns.data(),
                                   out.rest.data());
    return out;
}

std::vector<double> numbers_of(const Front& front)
{
    std::vector<double> out;
    for (const MatrixXd* m : {&front.columns, &front.rest}) {
        for (Index j = 0; j < m->cols(); ++j) {
            for (Index i = j; i < m->rows(); ++i) out.push_back((*m)(i, j));
        }
    }
    return out;
}

const std::vector<std::pair<Index, Index>> sizes = {
    {1, 0}, {3, 2}, {17, 40}, {48, 0}, {49, 7}, {96, 200}, {130, 225}, {300, 211}, {61, 401}};

TEST(DenseFront, IsTheFactorAndWhatRemains)
{
    for (const auto& [pivots, border] : sizes) {
        const MatrixXd a = some_matrix(pivots + border);
        const Front front = eliminated(a, pivots);
        ASSERT_TRUE(front.positive);
        const MatrixXd l = a.llt().matrixL();
        const MatrixXd l21 = l.bottomLeftCorner(border, pivots);
        const MatrixXd left = a.bottomRightCorner(border, border) - l21 * l21.transpose();
        MatrixXd columns = l.leftCols(pivots), found = MatrixXd::Zero(columns.rows(), pivots);
        found.triangularView<Eigen::Lower>() = front.columns;
        EXPECT_LT((found - columns).norm(), 1e-13 * columns.norm()) << pivots << " " << border;
        MatrixXd off = MatrixXd::Zero(border, border);
        off.triangularView<Eigen::Lower>() = front.rest - left;
        EXPECT_LE(off.norm(), 1e-13 * a.norm()) << pivots << " " << border;
    }
}

TEST(DenseFront, HasTheSameBitsOnAnyProcessorAndAnyNumberOfThreads)
{
    for (const auto& size : sizes) {
        const Index pivots = size.first, border = size.second;
        const MatrixXd a = some_matrix(pivots + border);
        const std::vector<double> here = numbers_of(eliminated(a, pivots));
        on_every_target([&](const char* target) {
            EXPECT_EQ(numbers_of(eliminated(a, pivots)), here) << target << " " << pivots;
        });
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        EXPECT_EQ(numbers_of(eliminated(a, pivots)), here) << pivots;
    }
}

TEST(DenseFront, FindsAPivotThatIsNotPositive)
{
    for (const Index at : {0, 47, 48, 120}) {
        MatrixXd a = some_matrix(200);
        a(at, at) = -1;
        EXPECT_FALSE(eliminated(a, 130).positive) << at;
        EXPECT_TRUE(eliminated(a, at).positive) << at;
    }
}

}  // namespace
