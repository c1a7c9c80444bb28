#include "physics/bricks/brick_element.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace physics {

namespace {

using geometry::Mat3;
using geometry::Vec3;
using Monomials = std::array<Vec3, 8>;

// From corners to monomials, sum_a s_a^m u_a for all m, or from monomials to corners, sum_m s_a^m
// f_m for all a: in place, a bit at a time.
enum class Towards { monomials, corners };
void butterfly(Monomials& c, Towards way)
{
    for (unsigned bit = 1; bit < 8; bit *= 2) {
        for (unsigned m = 0; m < 8; ++m) {
            if (m & bit) continue;
            const Vec3 low = c[m], high = c[m | bit];
            c[m] = way == Towards::monomials ? Vec3(low + high) : Vec3(low - high);
            c[m | bit] = way == Towards::monomials ? Vec3(high - low) : Vec3(low + high);
        }
    }
}

// Of the one-point element: what monomial m's hourglass along axis i resists with, in Pa.
double hourglass_modulus(unsigned m, unsigned i, Lame material)
{
    if (std::popcount(m) == 3) return 4 * material.mu / 9;
    return (m >> i & 1 ? third_modulus(material, BrickElement::one_point) : material.mu) / 3;
}

}  // namespace

Lame lame(double young, double poisson)
{
    return {young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
}

BrickElement element_of(const geometry::Cubes& cubes, BrickElement asked)
{
    constexpr double nearly_incompressible = 0.45;  // Poisson ratio
    const bool any = std::any_of(cubes.poisson.begin(), cubes.poisson.end(),
                                 [](double nu) { return nu > nearly_incompressible; });
    return any && asked == BrickElement::incompatible ? BrickElement::relaxed : asked;
}

double third_modulus(Lame material, BrickElement element)
{
    const auto [lambda, mu] = material;
    if (element == BrickElement::trilinear) return lambda;
    if (element == BrickElement::one_point) return mu * (3 * lambda + 2 * mu) / (lambda + mu);
    return 2 * lambda * mu / (lambda + 2 * mu);
}

BrickVector brick_forces(const BrickVector& u, double h, Lame material, BrickElement element)
{
    const auto [lambda, mu] = material;
    Monomials c, f;
    for (unsigned a = 0; a < 8; ++a) {
        c[a] = u.segment<3>(3 * a) / 8;
        f[a].setZero();
    }
    butterfly(c, Towards::monomials);
    const bool one_point = element == BrickElement::one_point;
    for (unsigned n = 0; n < (one_point ? 1 : 7); ++n) {
        Mat3 g = Mat3::Zero();
        for (unsigned j = 0; j < 3; ++j) {
            if (!(n >> j & 1)) g.col(j) = 2 / h * c[n | 1u << j];
        }
        double bulk = lambda;
        if (element == BrickElement::relaxed && std::popcount(n) == 2) {
            bulk = third_modulus(material, element);
        }
        if (element != BrickElement::trilinear && std::popcount(n) == 1) {
            const int d = std::countr_zero(n);
            double others = 0;
            for (int j = 0; j < 3; ++j) {
                if (j == d) continue;
                g(j, d) = -g(d, j);
                others += g(j, j);
            }
            g(d, d) = -lambda * others / (lambda + 2 * mu);
        }
        const Mat3 p = mu * (g + g.transpose()) + bulk * g.trace() * Mat3::Identity();
        const double weight = h * h * h / std::pow(3, std::popcount(n));
        for (unsigned j = 0; j < 3; ++j) {
            if (!(n >> j & 1)) f[n | 1u << j] += weight * 2 / h * p.col(j);
        }
    }
    for (const unsigned m : {3u, 5u, 6u, 7u}) {
        for (unsigned i = 0; one_point && i < 3; ++i) {
            f[m][i] = 4 * h * hourglass_modulus(m, i, material) * c[m][i];
        }
    }
    butterfly(f, Towards::corners);
    BrickVector forces;
    for (unsigned a = 0; a < 8; ++a) forces.segment<3>(3 * a) = f[a] / 8;
    return forces;
}

BrickMatrix brick_stiffness(double h, Lame material, BrickElement element)
{
    BrickMatrix k;
    for (int i = 0; i < 24; ++i)
        k.col(i) = brick_forces(BrickVector::Unit(i), h, material, element);
    return 0.5 * (k + k.transpose());  // rounding apart it is symmetric already
}

// The projection on what is orthogonal to the rigid motions of a cube.
static BrickMatrix without_rigid()
{
    Eigen::Matrix<double, 24, 6> rigid;
    for (unsigned a = 0; a < 8; ++a) {
        const Vec3 at((a & 1) - 0.5, (a >> 1 & 1) - 0.5, (a >> 2 & 1) - 0.5);
        for (int i = 0; i < 3; ++i) {
            rigid.block<3, 1>(3 * Eigen::Index(a), i) = Vec3::Unit(i) / std::sqrt(8.0);
            rigid.block<3, 1>(3 * Eigen::Index(a), 3 + i) = Vec3::Unit(i).cross(at) / 2;
        }
    }
    return BrickMatrix::Identity() - rigid * rigid.transpose();
}

BrickMatrix stiffness_of(const geometry::OwnElement& element)
{
    static const BrickMatrix project = without_rigid();
    BrickMatrix k;
    std::size_t at = 0;
    for (Eigen::Index i = 0; i < 24; ++i) {
        for (Eigen::Index j = 0; j <= i; ++j) k(i, j) = k(j, i) = double(element.stiffness[at++]);
    }
    const BrickMatrix half = k * project;
    k.noalias() = project * half;
    return (0.5 * (k + k.transpose())).eval();
}

std::array<float, 300> lower_triangle(const BrickMatrix& k)
{
    std::array<float, 300> own{};
    std::size_t at = 0;
    for (Eigen::Index i = 0; i < 24; ++i) {
        for (Eigen::Index j = 0; j <= i; ++j) own[at++] = static_cast<float>(k(i, j));
    }
    return own;
}

}  // namespace physics
