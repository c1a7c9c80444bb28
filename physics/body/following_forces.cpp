#include "physics/body/following_forces.hpp"

#include "physics/state/pressed_surface.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace physics {
namespace {

using geometry::Mat3;

Vec3 place_of(const double* x, std::size_t slot)
{
    return Eigen::Map<const Vec3>(x + 4 * slot);
}

void push(Aligned<double>& f, std::size_t slot, const Vec3& force)
{
    for (std::size_t i = 0; i < 3; ++i) f[4 * slot + i] += force[static_cast<Eigen::Index>(i)];
}

Vec3 centre_of(const ForceShares& shares, const double* x)
{
    Vec3 sum = Vec3::Zero();
    for (const auto& [slot, share] : shares) sum += share * place_of(x, slot);
    return sum;
}

// sum s (r . r I - r r^T), m^2
Mat3 arms_of(const ForceShares& shares, const double* x)
{
    const Vec3 centre = centre_of(shares, x);
    Mat3 spread = Mat3::Zero();
    for (const auto& [slot, share] : shares) {
        const Vec3 r = place_of(x, slot) - centre;
        spread += share * r * r.transpose();
    }
    return spread.trace() * Mat3::Identity() - spread;
}

// The rotation of a region from rest. One that is a line at rest does not turn.
Mat3 rotation_of(const ForceShares& shares, const CornerBody& body, const double* x)
{
    const Vec3 before = centre_of(shares, body.rest.data()), now = centre_of(shares, x);
    Mat3 sum = Mat3::Zero();
    for (const auto& [slot, share] : shares) {
        sum += share * (place_of(x, slot) - now) *
               (place_of(body.rest.data(), slot) - before).transpose();
    }
    const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Vec3& size = svd.singularValues();
    if (!(size[1] > 1e-9 * size[0])) return Mat3::Identity();
    const double way = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    const Vec3 signs(1, 1, way < 0 ? -1 : 1);
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

void add_region(const FollowingForces::Region& region, const CornerBody& body, const double* x,
                Aligned<double>& f)
{
    const Force& force = *region.force;
    const Mat3 turn = force.follow ? rotation_of(region.shares, body, x) : Mat3::Identity();
    if (force.kind == Force::Kind::point) {
        const Vec3 turned = turn * force.force;
        for (const auto& [slot, share] : region.shares) push(f, slot, share * turned);
        return;
    }
    const Vec3 centre = centre_of(region.shares, x);
    const Vec3 a = arms_of(region.shares, x).ldlt().solve(turn * force.torque);
    for (const auto& [slot, share] : region.shares) {
        push(f, slot, share * a.cross(place_of(x, slot) - centre));
    }
}

// Where a face is integrated, exactly for polynomials of degree 4: Dunavant. High degree efficient
// symmetrical Gaussian quadrature rules for the triangle. IJNME 1985.
struct FacePoint {
    double weight;                // of the area 1/2 of the triangle u, v >= 0, u + v <= 1
    std::array<double, 6> value;  // of each node's phi
    std::array<double, 6> along_u, along_v;
};

FacePoint face_point(double u, double v, double weight)
{
    const double w = 1 - u - v;
    return {weight / 2,
            {w * (2 * w - 1), u * (2 * u - 1), v * (2 * v - 1), 4 * w * u, 4 * u * v, 4 * v * w},
            {1 - 4 * w, 4 * u - 1, 0, 4 * (w - u), 4 * v, -4 * v},
            {1 - 4 * w, 0, 4 * v - 1, -4 * u, 4 * u, 4 * (w - v)}};
}

std::array<FacePoint, 6> face_points()
{
    constexpr double a = 0.44594849091596488632, b = 0.09157621350977074346;
    constexpr double of_a = 0.22338158967801146570, of_b = 0.10995174365532186764;
    return {face_point(a, a, of_a), face_point(1 - 2 * a, a, of_a), face_point(a, 1 - 2 * a, of_a),
            face_point(b, b, of_b), face_point(1 - 2 * b, b, of_b), face_point(b, 1 - 2 * b, of_b)};
}

void add_pressure(const Force& force, const CornerBody& body, const double* x, Aligned<double>& f)
{
    const PressedSurface& surface = *force.surface;
    const std::size_t n = surface.corners.size();
    const auto slot = [&](std::uint32_t corner) {
        return body.slot_of(std::size_t{force.first_corner} + corner);
    };
    std::vector<Vec3> node(n, Vec3::Zero()), pushed(n, Vec3::Zero());
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < 8; ++k) {
            node[i] += surface.weight[i][k] * place_of(x, slot(surface.corners[i][k]));
        }
    }
    const std::array<FacePoint, 6> points = face_points();
    for (const auto& face : surface.faces) {
        for (const FacePoint& point : points) {
            Vec3 along_u = Vec3::Zero(), along_v = Vec3::Zero();
            for (std::size_t i = 0; i < 6; ++i) {
                along_u += point.along_u[i] * node[face[i]];
                along_v += point.along_v[i] * node[face[i]];
            }
            const Vec3 area = point.weight * along_u.cross(along_v);
            for (std::size_t i = 0; i < 6; ++i) {
                pushed[face[i]] -= force.pressure * point.value[i] * area;
            }
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < 8; ++k) {
            push(f, slot(surface.corners[i][k]), surface.weight[i][k] * pushed[i]);
        }
    }
}

void check_surface(const Force& force, const CornerBody& body)
{
    if (!force.surface) {
        throw std::invalid_argument("pressure without a surface: make it with node Pressure");
    }
    for (const auto& eight : force.surface->corners) {
        for (const auto k : eight) {
            if (std::size_t{force.first_corner} + k < body.corners) continue;
            throw std::invalid_argument("the surface of a pressure has corners that the body does "
                                        "not: link Pressure to the cubes that are simulated");
        }
    }
}

void check_region(const FollowingForces::Region& region, const CornerBody& body)
{
    const Eigen::SelfAdjointEigenSolver<Mat3> arms(arms_of(region.shares, body.rest.data()));
    if (arms.eigenvalues()[0] > 1e-9 * body.h * body.h) return;
    const Force& force = *region.force;
    const Vec3& at = force.position;
    throw std::invalid_argument(fmt::format(
        "a {} at ({:.6g}, {:.6g}, {:.6g}) of radius {:.6g} m reaches only a point or a line of the "
        "body at rest, {}: move it to the body, or raise its radius",
        force.kind == Force::Kind::torque ? "torque" : "force that follows", at.x(), at.y(), at.z(),
        force.radius,
        force.kind == Force::Kind::torque ? "which it cannot turn" : "whose turn cannot be told"));
}

}  // namespace

bool follows(const Force& force)
{
    return force.kind == Force::Kind::torque || force.kind == Force::Kind::pressure ||
           (force.kind == Force::Kind::point && force.follow);
}

FollowingForces following_forces(const CornerBody& body, std::span<const Force> forces)
{
    FollowingForces out;
    for (const Force& force : forces) {
        if (force.kind == Force::Kind::pressure) {
            check_surface(force, body);
            if (force.pressure != 0) out.pressures.push_back(&force);
        } else if (follows(force)) {
            const bool torque = force.kind == Force::Kind::torque;
            if ((torque ? force.torque : force.force).isZero(0)) continue;
            out.regions.push_back({&force, force_shares(body, force)});
            check_region(out.regions.back(), body);
        }
    }
    return out;
}

void add_following_forces(const FollowingForces& forces, const CornerBody& body, const double* x,
                          Aligned<double>& f)
{
    for (const auto& region : forces.regions) add_region(region, body, x, f);
    for (const Force* pressure : forces.pressures) add_pressure(*pressure, body, x, f);
}

void require_no_following(std::span<const Force> forces, const std::string& who)
{
    if (std::none_of(forces.begin(), forces.end(), follows)) return;
    throw std::invalid_argument(
        who + " does not take torques, pressure or forces that follow: unlink the "
              "force, or use Simulate with method bricks or springs");
}

}  // namespace physics
