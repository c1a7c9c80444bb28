#include "physics/body/force_shares.hpp"

#include "physics/body/four_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

namespace physics {
namespace {

Vec3 rest_at(const CornerBody& body, std::size_t slot)
{
    return Eigen::Map<const Vec3>(body.rest.data() + 4 * slot);
}

double falloff(double distance_sq, double radius)
{
    const double s = std::max(0.0, 1 - distance_sq / (radius * radius));
    return s * s;
}

// Trilinear, by place in the cube from 0 to 1; beyond it they go on as they are.
double weight(unsigned a, const Vec3& place)
{
    double w = 1;
    for (unsigned i = 0; i < 3; ++i) {
        const double at = place[static_cast<Eigen::Index>(i)];
        w *= (a >> i & 1) ? at : 1 - at;
    }
    return w;
}

// A corner of a triangle and the two sides that start there.
struct Piece {
    Vec3 corner, p, q;
};

// The integral of the falloff over one triangle of the surface, by the middles of the sides of
// triangles so small that the falloff is smooth over each: add(force, place, share of p, of q).
template <class Add>
void press(const Piece& piece, double area, const Vec3& centre, double radius, const Add& add)
{
    const Vec3 &corner = piece.corner, &p = piece.p, &q = piece.q;
    const double longest = std::max({p.norm(), q.norm(), (p - q).norm()});
    const Vec3 middle = corner + (p + q) / 3;
    if ((middle - centre).norm() > radius + longest) return;
    const int cuts = static_cast<int>(std::clamp(std::ceil(8 * longest / radius), 1.0, 64.0));
    const double each = area / (3.0 * cuts * cuts);
    const auto take = [&](double along_p, double along_q) {
        const Vec3 place = corner + (along_p * p + along_q * q) / cuts;
        const double force = each * falloff((place - centre).squaredNorm(), radius);
        if (force != 0) add(force, place, along_p / cuts, along_q / cuts);
    };
    for (int i = 0; i < cuts; ++i) {
        for (int j = 0; i + j < cuts; ++j) {
            take(i + 0.5, j), take(i, j + 0.5), take(i + 0.5, j + 0.5);
            if (i + j + 1 == cuts) continue;  // no triangle on its tip here
            take(i + 0.5, j + 1), take(i + 1, j + 0.5), take(i + 0.5, j + 0.5);
        }
    }
}

void press_cube(const CornerBody& body, std::size_t c, std::uint32_t first, const Force& force,
                std::array<double, 8>& shares)
{
    const ContactSurface& surface = body.skin;
    const Vec3 origin = rest_at(body, first);
    const double h = body.edge_at(first);
    const double reach = force.radius + 4 * h;  // pieces lie in their cube, or by one cube off
    if ((origin - force.position).squaredNorm() > reach * reach) return;
    const Vec3 centre = (force.position - origin) / h;
    const auto add = [&](double part, const Vec3& place, double, double) {
        for (unsigned a = 0; a < 8; ++a) shares[a] += part * weight(a, place);
    };
    for (auto i = surface.on(c).area; i < surface.on(c).areas_end; ++i) {
        const auto& piece = surface.piece[i];
        press({piece[0].cast<double>(), piece[1].cast<double>(), piece[2].cast<double>()},
              surface.area[i].cast<double>().norm(), centre, force.radius / h, add);
    }
}

void press_triangle(const CornerBody& body, const CornerRuns::Corners& corners, const Force& force,
                    std::array<double, 8>& shares)
{
    const Vec3 first = rest_at(body, corners[0]);
    const Vec3 p = rest_at(body, corners[1]) - first, q = rest_at(body, corners[2]) - first;
    press({first, p, q}, p.cross(q).norm() / 2, force.position, force.radius,
          [&](double part, const Vec3&, double along_p, double along_q) {
              shares[0] += part * (1 - along_p - along_q);
              shares[1] += part * along_p;
              shares[2] += part * along_q;
          });
}

ForceShares shares_on_surface(const CornerBody& body, const Force& force)
{
    ForceShares out;
    const ContactSurface& surface = body.skin;
    surface.corners.for_each(0, surface.corners.size(), [&](std::size_t c, const auto& corners) {
        std::array<double, 8> shares{};
        if (geometry::is_triangle(corners)) {
            press_triangle(body, corners, force, shares);
        } else {
            press_cube(body, c, corners[0], force, shares);
        }
        for (std::size_t a = 0; a < 8; ++a) {
            if (shares[a] != 0) out.emplace_back(corners[a], shares[a]);
        }
    });
    return out;
}

ForceShares shares_of_material(const CornerBody& body, const Force& force)
{
    ForceShares out;
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        const double d_sq = (rest_at(body, k) - force.position).squaredNorm();
        if (!(d_sq < force.radius * force.radius)) continue;
        out.emplace_back(k, body.mass[k] * falloff(d_sq, force.radius));
    }
    return out;
}

// Shares of what is nearest to a place, and how far away that is, m.
struct Nearest {
    ForceShares shares;
    double distance = std::numeric_limits<double>::infinity();
};

// By the place of triangles that is nearest, linear in its triangle; none where there are none.
Nearest nearest_triangle(const CornerBody& body, const Vec3& place)
{
    Nearest out;
    body.skin.corners.for_each(0, body.skin.corners.size(), [&](std::size_t, const auto& corners) {
        if (!geometry::is_triangle(corners)) return;
        const FourPoints x{place, rest_at(body, corners[0]), rest_at(body, corners[1]),
                           rest_at(body, corners[2])};
        const auto stand = stand_of(Four::point, x);
        if (stand && std::abs(stand->distance) < out.distance) {
            out.distance = std::abs(stand->distance);
            out.shares.clear();
            for (std::size_t i = 0; i < 3; ++i) {
                out.shares.emplace_back(corners[i], -stand->weight[i + 1]);
            }
        }
        for (std::size_t i = 0; i < 3 && !stand; ++i) {
            const std::size_t j = (i + 1) % 3;
            const Vec3 side = x[j + 1] - x[i + 1];
            const double share =
                std::clamp((place - x[i + 1]).dot(side) / side.squaredNorm(), 0.0, 1.0);
            const double away = (place - x[i + 1] - share * side).norm();
            if (!(away < out.distance)) continue;
            out = {{{corners[i], 1 - share}, {corners[j], share}}, away};
        }
    });
    return out;
}

// 1 for corners of triangles.
std::vector<std::uint8_t> corners_of_triangles(const CornerBody& body)
{
    std::vector<std::uint8_t> out(body.corners, 0);
    if (body.on_lattice) return out;
    body.skin.corners.for_each(0, body.skin.corners.size(), [&](std::size_t, const auto& corners) {
        if (!geometry::is_triangle(corners)) return;
        for (std::size_t i = 0; i < 3; ++i) out[corners[i]] = 1;
    });
    return out;
}

// Trilinear in the cube that holds the place, all to the nearest corner where none is within a
// cube. Of parts that are as near, the one with the most mass there.
Nearest nearest_cube(const CornerBody& body, const Vec3& place)
{
    constexpr double same = 1e-6, on_it = 1e-3;  // of a cube
    struct Part {
        ForceShares shares;
        double sum = 0, mass = 0;  // of the weights: 1 in a cube; kg
    };
    const auto triangles = corners_of_triangles(body);
    std::map<std::size_t, Part> parts;
    Nearest out;
    double edge = 0;
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        if (triangles[k] != 0) continue;
        const Vec3 away = rest_at(body, k) - place;
        if (away.norm() < out.distance) {
            out = {{{k, 1.0}}, away.norm()};
            edge = body.edge_at(k);
        }
        const Vec3 near = Vec3::Ones() - away.cwiseAbs() / body.edge_at(k);
        if (!(near.minCoeff() > 0)) continue;
        Part& part = parts[body.part_of(k)];
        part.shares.emplace_back(k, near.prod());
        part.sum += near.prod();
        part.mass += near.prod() * body.mass[k];
    }
    const Part* best = nullptr;
    for (const auto& [number, part] : parts) {
        const double more = best ? part.sum - best->sum : 1;
        if (more > same || (more > -same && part.mass > best->mass)) best = &part;
    }
    if (!best) return out;
    out.shares = best->shares;
    if (best->sum > 1 - same) out.distance = on_it * edge;  // what lies on it may be nearer
    return out;
}

}  // namespace

ForceShares force_shares(const CornerBody& body, const Force& force)
{
    ForceShares shares;
    if (force.radius > 0) shares = shares_on_surface(body, force);
    if (shares.empty()) shares = shares_of_material(body, force);
    if (shares.empty()) {
        Nearest nearest = nearest_cube(body, force.position);
        Nearest other;
        if (!body.on_lattice) other = nearest_triangle(body, force.position);
        shares = std::move(other.distance < nearest.distance ? other.shares : nearest.shares);
    }
    double total = 0;
    for (const auto& [slot, share] : shares) total += share;
    for (auto& [slot, share] : shares) share /= total;
    return shares;
}

}  // namespace physics
