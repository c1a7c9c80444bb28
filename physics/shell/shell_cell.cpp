#include "physics/shell/shell_cell.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

constexpr double twist_share = 1.0 / 12;  // the mean of s^2 over -1/2 .. 1/2

// The two stretches of a cell's metric, with the parts of u1 and u2 that do not stand for g.
struct Stretches {
    std::array<double, 2> size{};                       // s1, s2
    std::array<Eigen::Vector2d, 2> v;                   // unit
    std::array<Vec3, 2> side;                           // (v1 f1 + v2 f2) / s
    double total() const { return size[0] + size[1]; }  // T
};

Stretches stretches_of(const Vec3& f1, const Vec3& f2, const Vec3& g)
{
    // A collapsed side has no direction to be pulled along.
    constexpr double least = 1e-9;
    const double extra = twist_share * g.squaredNorm();
    const double across = f1.dot(f2), apart = f1.squaredNorm() - f2.squaredNorm();
    const double angle = 0.5 * std::atan2(2 * across, apart);
    Stretches out;
    out.v = {Eigen::Vector2d(std::cos(angle), std::sin(angle)),
             Eigen::Vector2d(-std::sin(angle), std::cos(angle))};
    for (std::size_t k = 0; k < 2; ++k) {
        const Vec3 sum = out.v[k][0] * f1 + out.v[k][1] * f2;
        out.size[k] = std::max(std::sqrt(sum.squaredNorm() + extra), least);
        out.side[k] = sum / out.size[k];
    }
    return out;
}

void add_square(ShellMatrix& to, double weight, const ShellVector& row)
{
    to.noalias() += weight * row * row.transpose();
}

constexpr double narrow = 1e-4;  // the whole is without bound where a side collapses

// [l][k]: ul . dF vk, as rows for a change of f1, f2 and g.
using Changes = std::array<std::array<ShellVector, 2>, 2>;
Changes changes_of(const Stretches& s, const Vec3& g)
{
    Changes out;
    for (std::size_t l = 0; l < 2; ++l) {
        for (std::size_t k = 0; k < 2; ++k) {
            const Vec3 own = l == k ? Vec3(twist_share / s.size[l] * g) : Vec3(Vec3::Zero());
            out[l][k] << s.v[k][0] * s.side[l], s.v[k][1] * s.side[l], own;
        }
    }
    return out;
}

// What the pulls p1 and p2 have too much, where f1, f2 and g came by `came` in the step before.
Eigen::Vector2d more_pull(const ShellCell& cell, const Stretches& s, const ShellVector& at,
                          const ShellVector* came)
{
    if (!came) return Eigen::Vector2d::Zero();
    Eigen::Vector2d longer;
    for (std::size_t k = 0; k < 2; ++k) {
        const auto along = [&](const ShellVector& of) {
            return Vec3(s.v[k][0] * of.head<3>() + s.v[k][1] * of.segment<3>(3));
        };
        const Vec3 side = along(at), before = side - along(*came);
        const double size = before.norm();
        longer[Eigen::Index(k)] = size > 0 ? side.norm() - side.dot(before) / size : 0;
    }
    return cell.shear * longer + Eigen::Vector2d::Constant(cell.bulk * longer.sum());
}

// Of turns of side k out of the sheet, J.
double across(const ShellCell& cell, const Stretches& s, std::size_t k, double more)
{
    const double pull = cell.bulk * (s.total() - 2) - cell.shear;
    const double size = std::max(s.size[k], narrow);
    return cell.shear + pull / size - more / size;
}

// The second derivative of the stretch energy: of each change dF vk the part out of the sheet, the
// turn within it, shear, and stretch.
void add_stretch_curvature(const ShellCell& cell, const Stretches& s, const Vec3& g, bool positive,
                           const Eigen::Vector2d& more, ShellMatrix& to)
{
    const Changes along = changes_of(s, g);
    const double pull = cell.bulk * (s.total() - 2) - cell.shear;
    const auto bounded = [&](double v) { return positive ? std::max(v, 0.0) : v; };
    const double total = std::max(s.total(), narrow);
    const double turn = bounded(cell.shear + 2 * pull / total - more.sum() / total);
    for (std::size_t k = 0; k < 2; ++k) {
        const double out = bounded(across(cell, s, k, more[Eigen::Index(k)]));
        const Eigen::Matrix2d both = out * s.v[k] * s.v[k].transpose();
        for (Eigen::Index i = 0; i < 3; ++i) {
            to(i, i) += both(0, 0), to(3 + i, 3 + i) += both(1, 1);
            to(i, 3 + i) += both(0, 1), to(3 + i, i) += both(1, 0);
            to(6 + i, 6 + i) += twist_share * out;
        }
        add_square(to, -out, along[0][k]);
        add_square(to, -out, along[1][k]);
        add_square(to, cell.shear, along[k][k]);
    }
    add_square(to, 0.5 * turn, along[1][0] - along[0][1]);
    add_square(to, 0.5 * cell.shear, along[1][0] + along[0][1]);
    add_square(to, cell.bulk, along[0][0] + along[1][1]);
}

void add_plane_bend(const ShellCell& cell, const std::array<Vec3, 2>& f, const Vec3& g,
                    Curvature curvature, CellEnergy& out)
{
    for (Eigen::Index k = 0; k < 2; ++k) {
        const Vec3& side = f[static_cast<std::size_t>(k)];
        const double bend = side.dot(g);
        ShellVector row = ShellVector::Zero();
        row.segment<3>(3 * k) = g;
        row.tail<3>() = side;
        out.energy += 0.5 * cell.plane_bend * bend * bend;
        out.slope += cell.plane_bend * bend * row;
        if (curvature == Curvature::none) continue;
        add_square(out.curvature, cell.plane_bend, row);
        if (curvature == Curvature::positive) continue;
        for (Eigen::Index i = 0; i < 3; ++i) {
            out.curvature(3 * k + i, 6 + i) += cell.plane_bend * bend;
            out.curvature(6 + i, 3 * k + i) += cell.plane_bend * bend;
        }
    }
}

}  // namespace

CellEnergy cell_energy(const ShellCell& cell, const ShellVector& at, Curvature curvature,
                       const ShellVector* came)
{
    const std::array<Vec3, 2> f{at.head<3>(), at.segment<3>(3)};
    const Vec3 g = at.tail<3>();
    const Stretches s = stretches_of(f[0], f[1], g);
    const double more = s.total() - 2;
    CellEnergy out;
    out.energy = 0.5 * cell.bulk * more * more + 0.5 * cell.twist * g.squaredNorm();
    out.slope.tail<3>() = cell.twist * g;
    for (std::size_t k = 0; k < 2; ++k) {
        const double one = s.size[k] - 1, force = cell.shear * one + cell.bulk * more;
        out.energy += 0.5 * cell.shear * one * one;
        for (Eigen::Index i = 0; i < 2; ++i) {
            out.slope.segment<3>(3 * i) += force * s.v[k][i] * s.side[k];
        }
        out.slope.tail<3>() += twist_share * force / s.size[k] * g;
    }
    if (curvature != Curvature::none) {
        for (Eigen::Index i = 6; i < 9; ++i) out.curvature(i, i) += cell.twist;
        add_stretch_curvature(cell, s, g, curvature == Curvature::positive,
                              more_pull(cell, s, at, came), out.curvature);
    }
    add_plane_bend(cell, f, g, curvature, out);
    return out;
}

AcrossStiffness across_stiffness(const ShellCell& cell, const ShellVector& at,
                                 const ShellVector* came)
{
    const Stretches s = stretches_of(at.head<3>(), at.segment<3>(3), at.tail<3>());
    const Eigen::Vector2d more = more_pull(cell, s, at, came);
    AcrossStiffness out;
    for (std::size_t k = 0; k < 2; ++k) {
        out.whole = std::max(out.whole, across(cell, s, k, 0));
        out.own = std::max(out.own, across(cell, s, k, more[Eigen::Index(k)]));
    }
    return out;
}

}  // namespace physics
