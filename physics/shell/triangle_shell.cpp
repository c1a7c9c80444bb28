#include "physics/shell/triangle_shell.hpp"

#include <algorithm>
#include <cmath>
#include <map>

// Map: frames and gradients; which triangles a side joins; bending; rows of the matrix.

namespace physics {
namespace {

using geometry::no_index;

Vec3 place_of(const double* x, std::uint32_t k)
{
    return Eigen::Map<const Vec3>(x + 4 * std::size_t{k});
}

// A triangle at rest, in axes of its own.
struct AtRest {
    std::array<Vec3, 3> place;
    Vec3 u, v, normal;  // unit
    double area = 0;    // m^2

    std::size_t end_of(std::size_t side) const { return (side + 1) % 3; }
    Vec3 along(std::size_t side) const { return place[end_of(side)] - place[side]; }
    // Unit, out of the triangle in its plane.
    Vec3 out_of(std::size_t side) const { return along(side).cross(normal).normalized(); }
    Eigen::Vector2d flat(const Vec3& way) const { return {way.dot(u), way.dot(v)}; }
};

AtRest at_rest(const TrianglePlan& plan, const double* rest)
{
    AtRest out;
    for (std::size_t i = 0; i < 3; ++i) out.place[i] = place_of(rest, plan.corner[i]);
    const Vec3 twice = out.along(0).cross(-out.along(2));
    out.area = twice.norm() / 2;
    out.normal = twice.normalized();
    out.u = out.along(0).normalized();
    out.v = out.normal.cross(out.u);
    return out;
}

// Of linear functions: how much each corner has of their slopes along u and v.
Eigen::Matrix<double, 2, 3> gradient_of(const AtRest& t)
{
    Eigen::Matrix<double, 2, 3> out;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t across = (i + 1) % 3;
        out.col(Eigen::Index(i)) =
            -t.flat(t.out_of(across)) * t.along(across).norm() / (2 * t.area);
    }
    return out;
}

// The triangles' sides, paired where they join: by ends, those that run on most straightly first.
struct Sides {
    std::vector<std::array<std::uint32_t, 2>> of;  // S, 3 triangle + side
    std::vector<std::uint32_t> at;                 // 3 T
};

void pair_up(std::vector<std::uint32_t> uses, const std::vector<AtRest>& rest, Sides& out)
{
    constexpr double folded_shut = 1 - 1e-6;    // cosine between the ways out of both
    constexpr std::size_t most_that_bend = 16;  // of more, each turns freely
    const auto out_of = [&](std::uint32_t use) { return rest[use / 3].out_of(use % 3); };
    while (!uses.empty()) {
        std::size_t a = uses.size() - 1, b = no_index;
        double least = folded_shut;
        for (std::size_t i = 0; i < uses.size() && uses.size() <= most_that_bend; ++i) {
            for (std::size_t j = i + 1; j < uses.size(); ++j) {
                const double turn = out_of(uses[i]).dot(out_of(uses[j]));
                if (turn < least) a = i, b = j, least = turn;
            }
        }
        const auto number = static_cast<std::uint32_t>(out.of.size());
        out.of.push_back({uses[a], b == no_index ? no_index : uses[b]});
        out.at[uses[a]] = number;
        if (b != no_index) {
            out.at[uses[b]] = number;
            uses.erase(uses.begin() + std::ptrdiff_t(b));
        }
        uses.erase(uses.begin() + std::ptrdiff_t(a));
    }
}

Sides sides_of(const std::vector<TrianglePlan>& triangles, const std::vector<AtRest>& rest)
{
    std::map<std::array<std::uint32_t, 2>, std::vector<std::uint32_t>> uses;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t a = triangles[t].corner[i], b = triangles[t].corner[(i + 1) % 3];
            uses[{std::min(a, b), std::max(a, b)}].push_back(3 * t + i);
        }
    }
    Sides out;
    out.at.assign(3 * triangles.size(), no_index);
    for (auto& [ends, all] : uses) pair_up(std::move(all), rest, out);
    return out;
}

// The derivative of the places across a side at rest, out of the first of its triangles.
Vec3 slope_at_rest(const std::array<std::uint32_t, 2>& uses, const std::vector<AtRest>& rest)
{
    const Vec3 first = rest[uses[0] / 3].out_of(uses[0] % 3);
    if (uses[1] == no_index) return first;
    return (first - rest[uses[1] / 3].out_of(uses[1] % 3)).normalized();
}

// l / A times n_1 w_1, n_2 w_2, n_1 w_2 + n_2 w_1.
Eigen::Vector3d symmetric(const Eigen::Vector2d& n, const Eigen::Vector2d& w, double share)
{
    return share * Eigen::Vector3d(n[0] * w[0], n[1] * w[1], n[0] * w[1] + n[1] * w[0]);
}

void add_bending(const AtRest& at, std::uint32_t number, const Sides& sides,
                 const std::vector<AtRest>& rest, ShellTriangle& to)
{
    to.by_place.setZero();
    for (std::size_t i = 0; i < 3; ++i) {
        const auto column = static_cast<Eigen::Index>(i);
        const Vec3 along = at.along(i);
        const double length = along.norm();
        const Eigen::Vector2d n = at.flat(at.out_of(i)), t = at.flat(along / length);
        const Eigen::Vector3d ends = symmetric(n, t, 1 / at.area);
        to.by_place.col(static_cast<Eigen::Index>(at.end_of(i))) += ends;
        to.by_place.col(column) -= ends;
        const std::uint32_t use = 3 * number + static_cast<std::uint32_t>(i);
        to.side[i] = sides.at[use];
        const double way = sides.of[to.side[i]][0] == use ? 1 : -1;
        to.by_slope.col(column) = symmetric(n, n, way * length / at.area);
    }
    // What it is at rest goes with the triangle.
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();  // a column each
    for (std::size_t i = 0; i < 3; ++i) {
        const auto column = static_cast<Eigen::Index>(i);
        const Vec3 slope = slope_at_rest(sides.of[to.side[i]], rest);
        h += (at.place[i] - at.place[0]) * to.by_place.col(column).transpose() +
             slope * to.by_slope.col(column).transpose();
    }
    constexpr double flat = 1e-9;  // of one over its size
    const double least = flat / std::sqrt(at.area);
    const auto cut = [&](double value) { return std::abs(value) < least ? 0.0 : value; };
    for (Eigen::Index k = 0; k < 3; ++k) {
        to.curved[k] = cut(at.normal.dot(h.col(k)));
        to.by_place.row(k) -= cut(at.u.dot(h.col(k))) * to.gradient.row(0) +
                              cut(at.v.dot(h.col(k))) * to.gradient.row(1);
    }
}

void add_matter(const TrianglePlan& plan, double area, double stretch, double bend,
                ShellTriangle& to)
{
    const double nu = plan.poisson, h = plan.thickness;
    const double plane = plan.young / (1 - nu * nu);
    to.stretch.shear = plan.young / (1 + nu) * h * area * stretch;
    to.stretch.bulk = plane * nu * h * area * stretch;
    to.plate << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
    to.plate *= area * bend * plane * h * h * h / 12;
    to.damping = plan.damping;
    to.thickness = h;
    to.fourth = plan.fourth;
}

void add_rows(std::size_t corners, TriangleShell& shell)
{
    std::vector<std::vector<std::uint32_t>> rows(corners);
    for (const ShellTriangle& t : shell.triangle) {
        for (const auto i : t.corner) {
            rows[i].insert(rows[i].end(), t.corner.begin(), t.corner.end());
        }
    }
    shell.row.push_back(0);
    for (std::uint32_t k = 0; k < corners; ++k) {
        auto& columns = rows[k];
        columns.push_back(k);
        std::sort(columns.begin(), columns.end());
        columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
        shell.column.insert(shell.column.end(), columns.begin(), columns.end());
        shell.row.push_back(static_cast<std::uint32_t>(shell.column.size()));
    }
    for (const ShellTriangle& t : shell.triangle) {
        auto& at = shell.block_at.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) {
            const auto first = shell.column.begin() + shell.row[t.corner[i]];
            const auto last = shell.column.begin() + shell.row[t.corner[i] + 1];
            for (std::size_t j = 0; j < 3; ++j) {
                at[3 * i + j] = static_cast<std::uint32_t>(
                    std::lower_bound(first, last, t.corner[j]) - shell.column.begin());
            }
        }
    }
}

void add_around(std::size_t corners, TriangleShell& shell)
{
    std::vector<std::vector<std::uint32_t>> around(corners);
    for (std::uint32_t t = 0; t < shell.triangle.size(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            around[shell.triangle[t].corner[i]].push_back(3 * t + i);
        }
    }
    for (const auto& all : around) {
        shell.of_corner.push_back(static_cast<std::uint32_t>(shell.around.size()));
        shell.around.insert(shell.around.end(), all.begin(), all.end());
    }
    shell.of_corner.push_back(static_cast<std::uint32_t>(shell.around.size()));
}

}  // namespace

TriangleShell make_triangle_shell(const std::vector<TrianglePlan>& triangles, const double* rest,
                                  std::size_t corners, double stretch, double bend)
{
    std::vector<AtRest> at;
    for (const TrianglePlan& plan : triangles) at.push_back(at_rest(plan, rest));
    Sides sides = sides_of(triangles, at);
    TriangleShell out;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        ShellTriangle& to = out.triangle.emplace_back();
        to.corner = triangles[t].corner;
        to.gradient = gradient_of(at[t]);
        add_matter(triangles[t], at[t].area, stretch, bend, to);
        add_bending(at[t], t, sides, at, to);
        to.joined = to.by_place.transpose() * to.plate * to.by_slope;
        to.turned = to.by_slope.transpose() * to.plate * to.curved;
        out.even &= to.damping == out.triangle[0].damping;
        out.most_damping = std::max(out.most_damping, to.damping);
    }
    out.side = std::move(sides.of);
    add_around(corners, out);
    add_rows(corners, out);
    return out;
}

std::vector<Vec3> middles_of_sides(const TriangleShell& shell, const double* x)
{
    std::vector<Vec3> out;
    out.reserve(shell.side.size());
    for (const auto& uses : shell.side) {
        const auto& k = shell.triangle[uses[0] / 3].corner;
        const std::size_t side = uses[0] % 3;
        out.push_back((place_of(x, k[side]) + place_of(x, k[(side + 1) % 3])) / 2);
    }
    return out;
}

std::size_t TriangleShell::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    return sizeof *this + of(triangle, of_corner, around, side, row, column, block_at);
}

}  // namespace physics
