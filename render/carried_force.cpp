#include "render/carried_force.hpp"

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/math/polar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace render {

using geometry::Mat3;
using geometry::Transform;
using geometry::Vec3;

namespace {

// A place of the rest shape, and where it is now.
struct Anchor {
    Vec3 rest, now;
};

// m, of the nearest four points, or of all.
double reach_of_four(const CarriedPoints& points, const Vec3& place)
{
    std::vector<double> away;
    away.reserve(points.rest.size());
    for (const Vec3& p : points.rest) away.push_back((p - place).norm());
    const auto fourth = away.begin() + std::min<std::ptrdiff_t>(3, std::ssize(away) - 1);
    std::nth_element(away.begin(), fourth, away.end());
    return *fourth;
}

// As physics/body/following_forces.hpp has it: R of sum w (x - c) (X - C)^T.
Mat3 rotation_near(const CarriedPoints& points, const Vec3& place, double radius)
{
    const double reach = std::max(radius, 2 * reach_of_four(points, place));
    std::vector<std::pair<std::size_t, double>> near;
    double sum = 0;
    Vec3 before = Vec3::Zero(), now = Vec3::Zero();
    for (std::size_t i = 0; i < points.rest.size(); ++i) {
        const double share = (points.rest[i] - place).squaredNorm() / (reach * reach);
        if (!(share < 1)) continue;
        const double weight = (1 - share) * (1 - share);
        near.emplace_back(i, weight);
        sum += weight;
        before += weight * points.rest[i];
        now += weight * points.now[i];
    }
    if (!(sum > 0)) return Mat3::Identity();
    before /= sum, now /= sum;
    Mat3 spread = Mat3::Zero();
    for (const auto& [i, weight] : near) {
        spread += weight * (points.now[i] - now) * (points.rest[i] - before).transpose();
    }
    if (!spread.allFinite()) return Mat3::Identity();
    const physics::Polar polar = physics::polar_of(spread);
    return polar.stretch[1] > 1e-9 * polar.stretch[0] ? polar.R : Mat3(Mat3::Identity());
}

Transform motion_about(const Anchor& anchor, const Mat3& turn)
{
    Transform motion = Transform::Identity();
    motion.linear() = turn;
    motion.translation() = anchor.now - turn * anchor.rest;
    return motion;
}

Anchor nearest_point(const CarriedPoints& points, const Vec3& place)
{
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < points.rest.size(); ++i) {
        const double away = (points.rest[i] - place).squaredNorm();
        if (away < (points.rest[nearest] - place).squaredNorm()) nearest = i;
    }
    return {points.rest[nearest], points.now[nearest]};
}

// The place in a cube that is nearest to `place`.
Anchor nearest_in(const geometry::Cubes& cubes, std::uint32_t cube, const CarriedPoints& corners,
                  const Vec3& place)
{
    const Vec3 first = corners.rest[cubes.corners[cube][0]];
    const Vec3 at = ((place - first) / cubes.size).cwiseMax(0.0).cwiseMin(1.0);
    const std::array<double, 8> weight = geometry::trilinear_weights(at);
    Anchor out{Vec3::Zero(), Vec3::Zero()};
    for (std::size_t a = 0; a < 8; ++a) {
        const std::uint32_t corner = cubes.corners[cube][a];
        out.rest += weight[a] * corners.rest[corner];
        out.now += weight[a] * corners.now[corner];
    }
    return out;
}

}  // namespace

Transform motion_at(const CarriedPoints& points, const Vec3& place, double radius)
{
    return motion_about(nearest_point(points, place), rotation_near(points, place, radius));
}

std::optional<Transform> motion_at(const geometry::Cubes& cubes, const CarriedPoints& corners,
                                   const Vec3& place, double radius, bool only_near)
{
    const geometry::NearestCube nearest = geometry::nearest_cube(cubes, place);
    if (only_near && nearest.distance > radius + std::sqrt(3.0) * cubes.size) return std::nullopt;
    if (cubes.is_sheet()) return motion_at(corners, place, radius);
    return motion_about(nearest_in(cubes, nearest.cube, corners, place),
                        rotation_near(corners, place, radius));
}

physics::Force carried(physics::Force force, const Transform& motion)
{
    force.position = motion * force.position;
    if (force.follow) {
        force.force = motion.linear() * force.force;
        force.torque = motion.linear() * force.torque;
    }
    return force;
}

}  // namespace render
