#include "physics/body/part_gap.hpp"

#include "geometry/cubes/cube_finder.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// A point's own surface faces a side that it comes to by at most this cosine; corners of blocks
// face their neighbours at -0.58.
constexpr double facing = -0.3;

// `distance` (m) along the unit normal at rest, as the bent cube has it.
std::optional<Gap> bent(const AtRest& rest, double distance, const Vec3& normal)
{
    const Vec3 turned = rest.back.transpose() * normal;
    const double length = turned.norm();
    if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
    return Gap{distance / length, turned / length, Vec3::Zero()};
}

}  // namespace

AtRest::AtRest(const PartShapes& shapes, std::uint32_t part, std::uint32_t cube, const InCube& in)
    : shape(shapes.shape[part]), faces(shapes.faces(part)), size(shapes.size_of(part)),
      winding(shapes.winding[cube]), inner(shapes.inner_place(part, cube)),
      back((in.axes / size).inverse()),
      place(shapes.grid[part].origin + size * (shapes.cell[cube].cast<double>() + in.u)),
      low(place - size * in.u),
      quarters(shapes.quarters.empty() ? ~std::uint64_t{0} : shapes.quarters[cube])
{}

bool AtRest::holds(const Vec3& where) const
{
    constexpr double rounding = 1e-5;  // cubes
    const geometry::Vec3 u = (where - low) / size;
    if (u.minCoeff() < -rounding || u.maxCoeff() > 1 + rounding) return false;
    return geometry::quarters_hold(quarters, u);
}

bool AtRest::inside() const
{
    if (winding != unknown_winding) {
        if (const auto gained = shape.crossings(inner, place)) return winding + *gained != 0;
    }
    return shape.inside(place);
}

std::optional<Gap> find_gap(const AtRest& rest, const Approach& approach)
{
    constexpr double deep = 0.25;  // cubes; from there on any side is better than none
    constexpr double half = 0.5;   // cubes: no longer way out but for what came as far
    const auto& [shape, faces, size, winding, inner, back, place, low, quarters] = rest;
    if (approach.own && !rest.holds(place)) return std::nullopt;
    if (!rest.inside()) return std::nullopt;
    const auto hit = faces.closest(place);
    if (!hit) return std::nullopt;
    double depth = hit.distance;
    Vec3 normal = hit.normal;
    if (depth > 1e-9 * size) normal = (hit.point - place) / depth;
    const Vec3 came = (1 + 1e-6) * (back * approach.way);
    const Vec3 outward = (back * approach.outward).normalized();
    const auto faces_it = [&](const Vec3& n) {
        return outward.dot(n) <= facing || approach.outward.isZero(0);
    };
    const bool through = came.norm() > depth && came.dot(normal) > 0;
    if (through || !faces_it(normal)) {
        const double most = std::max(half * size, came.norm());
        const auto left_along = [&](const Vec3& from) {
            const auto entry = rest.faces.entry(rest.place - from, rest.place);
            if (!entry || !faces_it(entry.normal)) return false;
            const double way_out = (entry.point - rest.place).dot(entry.normal);
            if (way_out > most) return false;
            normal = entry.normal;
            depth = std::max(0.0, way_out);
            return true;
        };
        const bool left = (through && left_along(came)) || left_along(2 * size * outward);
        if (!left && depth < deep * size) return std::nullopt;
    }
    return depth > 0 ? bent(rest, -depth, normal) : std::nullopt;
}

std::optional<Gap> find_distance(const AtRest& rest, const Vec3& outward, double reach, bool own)
{
    constexpr double upright = 0.99;   // cosine
    constexpr double rounding = 1e-5;  // cubes
    const auto hit = rest.faces.closest(rest.place, reach);
    if (!hit) return std::nullopt;
    const Vec3 turned_in = rest.back * outward;
    const bool on_it = hit.distance < rounding * rest.size;
    if (own && !rest.holds(hit.point)) return std::nullopt;
    Vec3 normal = hit.normal;
    if (on_it) {
        if (normal.dot(turned_in) > 0) normal = -normal;  // the triangles may all face inward
    } else {
        normal = (rest.place - hit.point) / hit.distance;
        if (std::abs(normal.dot(hit.normal)) < upright) return std::nullopt;
    }
    if (turned_in.dot(normal) > facing * turned_in.norm()) return std::nullopt;
    if (!on_it && rest.inside()) return std::nullopt;
    return bent(rest, hit.distance, normal);
}

}  // namespace physics
