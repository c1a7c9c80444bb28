#include "physics/bricks/own_bricks.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/bricks/brick_kernels.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using Eigen::Index;
using geometry::no_index;

bool is_own(const geometry::Cubes& cubes, std::uint32_t c)
{
    return c != no_index && cubes.is_own(c);
}

// W: corner values by the numbers of a field.
Eigen::Matrix<double, 24, field_numbers> from_field()
{
    constexpr unsigned order[7] = {1, 2, 4, 3, 6, 5, 7};  // x, y, z, xy, yz, zx, xyz
    Eigen::Matrix<double, 24, field_numbers> w;
    w.setZero();
    for (unsigned a = 0; a < 8; ++a) {
        for (unsigned m = 0; m < 7; ++m) {
            double sign = 1;
            for (unsigned bit = 1; bit < 8; bit *= 2) {
                if ((order[m] & bit) != 0 && (a & bit) == 0) sign = -sign;
            }
            for (unsigned i = 0; i < 3; ++i) w(3 * a + i, 3 * m + i) = sign;
        }
    }
    return w;
}

// W^T (D - M) W of cube c.
Eigen::Matrix<double, 7, 7> excess_of(const geometry::Cubes& cubes, std::uint32_t c,
                                      const Eigen::Matrix<double, 24, field_numbers>& w,
                                      const CubeMass& usual)
{
    const CubeMass mass = mass_of_cube(cubes, c, usual);
    Eigen::Matrix<double, 8, 8> n = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 7> of_x;
    for (Index a = 0; a < 8; ++a) {
        for (Index b = 0; b < 8; ++b) {
            const double m = mass[std::size_t(a)][std::size_t(b)];
            n(a, b) -= m;
            n(a, a) += m;
        }
        for (Index m = 0; m < 7; ++m) of_x(a, m) = w(3 * a, 3 * m);
    }
    return of_x.transpose() * n * of_x;
}

// Its lower triangle, row by row, a lane's numbers apart.
template <class Matrix> void put_lane(const Matrix& of, double* to)
{
    for (Index row = 0; row < of.rows(); ++row) {
        for (Index column = 0; column <= row; ++column, to += block_lanes) *to = of(row, column);
    }
}

Aligned<float> low(const Aligned<double>& of)
{
    Aligned<float> out(of.size());
    std::transform(of.begin(), of.end(), out.begin(),
                   [](double k) { return static_cast<float>(k); });
    return out;
}

}  // namespace

OwnBricks make_own_bricks(const geometry::Cubes& cubes, const BrickLayout& layout,
                          const std::vector<double>& edge, BrickElement element,
                          Weighting weighting, const std::vector<std::uint8_t>& rigid)
{
    OwnBricks out;
    if (cubes.own.empty()) return out;
    out.at.assign(layout.blocks(), no_index);
    for (std::size_t i = 0; i < layout.cube.size(); ++i) {
        auto& at = out.at[i / block_lanes];
        if (at == no_index && is_own(cubes, layout.cube[i])) {
            at = static_cast<std::uint32_t>(out.blocks++);
        }
    }
    out.matrices.assign(out.blocks * own_rows * block_lanes, 0);
    out.mass.assign(out.blocks * own_mass_rows * block_lanes, 0);
    const auto w = from_field();
    const CubeMass usual = cube_mass_matrix();
    geometry::parallel_for(
        layout.cube.size(), block_lanes, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::uint32_t block = out.at[i / block_lanes], c = layout.cube[i];
                if (block == no_index || c == no_index) continue;
                const double h = edge[i / block_lanes];
                put_lane(excess_of(cubes, c, w, usual),
                         &out.mass[block * own_mass_rows * block_lanes + i % block_lanes]);
                if (!rigid.empty() && rigid[c] != 0) continue;
                const BrickMatrix k =
                    is_own(cubes, c)
                        ? BrickMatrix(cubes.young[c] * h *
                                      stiffness_of(cubes.elements[cubes.own[c]]))
                        : BrickMatrix(
                              stiffness_share(cubes, c, weighting) *
                              brick_stiffness(h, lame(cubes.young[c], cubes.poisson[c]), element));
                const Eigen::Matrix<double, field_numbers, field_numbers> of =
                    w.transpose() * k * w / 64;
                put_lane(of, &out.matrices[block * own_rows * block_lanes + i % block_lanes]);
            }
        });
    out.matrices_low = low(out.matrices);
    out.mass_low = low(out.mass);
    return out;
}

std::array<double, 8> corner_diagonal(const BrickMatrix& k)
{
    std::array<double, 8> out{};
    for (std::size_t a = 0; a < 8; ++a) out[a] = k.diagonal().segment<3>(Index(3 * a)).maxCoeff();
    return out;
}

double largest_eigenvalue(const BrickMatrix& k)
{
    const auto diagonal = corner_diagonal(k);
    BrickMatrix scaled = k;
    for (std::size_t a = 0; a < 8; ++a) {
        if (!(diagonal[a] > 0)) continue;
        scaled.middleRows<3>(Index(3 * a)) /= std::sqrt(diagonal[a]);
        scaled.middleCols<3>(Index(3 * a)) /= std::sqrt(diagonal[a]);
    }
    const Eigen::SelfAdjointEigenSolver<BrickMatrix> eigen(scaled, Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[23];
}

double largest_eigenvalue(const CubeMass& m)
{
    Eigen::Matrix<double, 8, 8> scaled;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < 8; ++b) {
            scaled(Index(a), Index(b)) = m[a][b] / std::sqrt(m[a][a] * m[b][b]);
        }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> eigen(scaled,
                                                                           Eigen::EigenvaluesOnly);
    return eigen.eigenvalues()[7];
}

}  // namespace physics
