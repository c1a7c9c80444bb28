#include "physics/layers/geodesic_sphere.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace physics {

using geometry::Vec3;

GeodesicSphere geodesic_sphere(int n)
{
    const double g = std::numbers::phi;
    const std::vector<Vec3> corners{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                    {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                    {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    const int faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                              {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                              {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                              {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    GeodesicSphere sphere;
    // A point inside a face is its own; on edges and corners it is shared: named by the corners it
    // mixes and how much of each.
    std::map<std::array<int, 6>, std::uint32_t> shared;
    const auto side = static_cast<std::size_t>(n) + 1;
    std::vector<std::uint32_t> known;  // side x side, of a face, by a and b
    geometry::StopCheck check;
    for (const auto& face : faces) {
        known.assign(side * side, geometry::no_index);
        const auto point = [&](int a, int b) {
            std::uint32_t& at = known[static_cast<std::size_t>(a) * side + std::size_t(b)];
            if (at != geometry::no_index) return at;
            const int share[3] = {n - a - b, a, b};
            std::array<std::array<int, 2>, 3> parts;
            for (std::size_t i = 0; i < 3; ++i) {
                parts[i] = share[i] > 0 ? std::array{face[i], share[i]} : std::array{-1, 0};
            }
            std::sort(parts.begin(), parts.end());
            const std::array<int, 6> name{parts[0][0], parts[0][1], parts[1][0],
                                          parts[1][1], parts[2][0], parts[2][1]};
            at = static_cast<std::uint32_t>(sphere.points.size());
            if (parts[0][1] == 0) {
                const auto [found, fresh] = shared.emplace(name, at);
                if (!fresh) return at = found->second;
            }
            Vec3 sum = Vec3::Zero();  // in the order of corners, the same from every face
            for (const auto& [corner, times] : parts) {
                if (times > 0) sum += times * corners[static_cast<std::size_t>(corner)];
            }
            sphere.points.push_back(sum.normalized());
            return at;
        };
        for (int a = 0; a < n; ++a) {
            for (int b = 0; a + b < n; ++b) {
                check();
                sphere.faces.push_back({point(a, b), point(a + 1, b), point(a, b + 1)});
                if (a + b + 1 < n) {
                    sphere.faces.push_back({point(a + 1, b), point(a + 1, b + 1), point(a, b + 1)});
                }
            }
        }
    }
    return sphere;
}

Eigen::Matrix<double, 6, 1> solid_angles(const std::array<Vec3, 6>& points)
{
    using Vec2 = Eigen::Vector2d;
    using Vec6 = Eigen::Matrix<double, 6, 1>;
    const Vec3 middle = (points[0] + points[1] + points[2]).normalized();
    const Vec3 u = middle.unitOrthogonal(), v = middle.cross(u);
    std::array<Vec2, 6> x;
    for (std::size_t j = 0; j < 6; ++j) {
        x[j] = Vec2(points[j].dot(u), points[j].dot(v)) / points[j].dot(middle);
    }
    const double size = x[0].norm();
    Eigen::Matrix<double, 6, 6> monomials;  // a row each
    Vec6 measure;
    for (std::size_t j = 0; j < 6; ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        measure[column] = std::pow(1 + x[j].squaredNorm(), -1.5);
        x[j] /= size;
        const double a = x[j].x(), b = x[j].y();
        monomials.col(column) << 1, a, b, a * a, a * b, b * b;
    }
    // Means over the triangle: of x_a x_b, (sum x_a x_b + sum x_a sum x_b) / 12.
    const Vec2 sum = x[0] + x[1] + x[2];
    const Eigen::Matrix2d second = (x[0] * x[0].transpose() + x[1] * x[1].transpose() +
                                    x[2] * x[2].transpose() + sum * sum.transpose()) /
                                   12;
    Vec6 mean;
    mean << 1, sum / 3, second(0, 0), second(0, 1), second(1, 1);
    const Vec2 ab = x[1] - x[0], ac = x[2] - x[0];
    const double area = 0.5 * size * size * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
    return area * monomials.partialPivLu().solve(mean).cwiseProduct(measure);
}

}  // namespace physics
