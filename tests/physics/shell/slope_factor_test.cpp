#include "physics/shell/slope_factor.hpp"

#include "physics/shell/shell.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace {

using namespace physics;
using namespace fixtures;
using Eigen::Index;
using Eigen::MatrixXd;

// Of 12 x 12 squares that are cut and moved as chance has it.
ShellBody some_shell()
{
    return make_shell(sheet_of(squares({.ni = 12, .nj = 12}), 0.01), {});
}

std::vector<double> weights_of(const TriangleShell& shell)
{
    std::vector<double> out;
    for (std::uint32_t t = 0; t < shell.triangle.size(); ++t) out.push_back(1 + 9 * chance(3, t));
    return out;
}

SideVectors some_pulls(const TriangleShell& shell)
{
    SideVectors out(Index(shell.side.size()), 3);
    for (Index i = 0; i < out.size(); ++i) out.data()[i] = chance(5, std::uint32_t(i)) - 0.5;
    return out;
}

TEST(SlopeFactor, SolvesTheMatrixOfAllTriangles)
{
    const ShellBody body = some_shell();
    const TriangleShell& shell = *body.triangles;
    const std::vector<double> weight = weights_of(shell);
    MatrixXd matrix = MatrixXd::Zero(Index(shell.side.size()), Index(shell.side.size()));
    for (std::size_t t = 0; t < shell.triangle.size(); ++t) {
        const ShellTriangle& own = shell.triangle[t];
        const Eigen::Matrix3d k = weight[t] * own.by_slope.transpose() * own.plate * own.by_slope;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                matrix(own.side[i], own.side[j]) += k(Index(i), Index(j));
            }
        }
    }
    const SideVectors pulls = some_pulls(shell);
    const MatrixXd expected = matrix.llt().solve(MatrixXd(pulls));
    SideVectors slopes = pulls;
    Aligned<double> work;
    SlopeFactor(shell, body.base.rest.data(), weight).solve(slopes, work);
    EXPECT_LT((MatrixXd(slopes) - expected).norm(), 1e-11 * expected.norm());
}

TEST(SlopeFactor, HasTheSameBitsForAnyNumberOfThreads)
{
    const ShellBody body = some_shell();
    const TriangleShell& shell = *body.triangles;
    const auto solved = [&] {
        SideVectors slopes = some_pulls(shell);
        Aligned<double> work;
        SlopeFactor(shell, body.base.rest.data(), weights_of(shell)).solve(slopes, work);
        return slopes;
    };
    const SideVectors here = solved();
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(solved(), here);
}

TEST(SlopeFactor, RefusesTrianglesThatDoNotResist)
{
    const ShellBody body = some_shell();
    const TriangleShell& shell = *body.triangles;
    const std::vector<double> none(shell.triangle.size(), 0);
    EXPECT_THROW(SlopeFactor(shell, body.base.rest.data(), none), std::invalid_argument);
}

}  // namespace
