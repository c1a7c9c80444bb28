#pragma once

// Springs that hold the material of cubes within a place, wherever cubes lie. A corner is held or
// it is not, so that a clamp of corners ends up to a cube from where it was asked to; the material
// within the place is known much finer.
//
// Points q of the material, spread evenly over each cube, are tied to where they are to be:
//   energy 1/2 sum_q k_q |y_q - t_q|^2,   y_q = sum_a w_a(q) x_a,   t_q = sum_a w_a(q) t_a
// by the trilinear weights w of their cube's corners. Targets of corners that move as one rigid
// body move the points with them. The stiffness of a volume V is
//   k = held_stiffness * E V / h^2
// so that what is held gives way over sqrt(1 / held_stiffness) = 0.29 of a cube behind the border
// of the place. That is on purpose: a cube that the border cuts has a trilinear field, and to hold
// a part of it without any give is to hold all of it, up to a cube too far. A cantilever of cubes
// as large as its thickness, held at places all through a cube, sags 0.98 to 1.04 of what it should
// with 12; stiffer springs (1,000) give 0.88 to 1.00, softer ones (3) 1.04 to 1.09, corners 1.00 to
// 1.15. It is little more than what the cubes resist themselves: solvers take no longer.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "physics/state/choose_corners.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <functional>
#include <optional>
#include <string>

namespace physics {

inline constexpr double held_stiffness = 12;

// How far a point is outside of a place, m; 0 or less within. No two points differ by more than
// they are apart.
using Outside = std::function<double(const Vec3&)>;

Outside outside_box(const geometry::Box& box);
Outside outside_sphere(const Vec3& centre, double radius);
Outside outside_below(double height);
// Within `distance` of the faces of a material or group, as corners_near_material().
Outside outside_of_material(const geometry::TriMesh& mesh, const std::string& name,
                            double distance);
// Outside of the outermost `layers` of cubes, as corners_at_end().
Outside outside_end(const geometry::Cubes& cubes, int axis, End end, int layers);

// The material within a place, held along `axes` of the world, with no targets yet. A point is
// material where it is inside `mesh`; where the mesh is null, or a cube holds none of its inside
// (sheets have none), the material is spread evenly over the cube, or over its quarters.
HeldMatter matter_within(const geometry::Cubes& cubes, const Outside& outside,
                         const geometry::TriangleBvh* mesh, std::uint8_t axes);

// Pins that hold it where `motion` takes it, or where its cubes would have it with their corners at
// `places` (one for each corner of the cubes). `pivot`: as that of pins_at().
Pins matter_at(const geometry::Cubes& cubes, HeldMatter matter, const Transform& motion,
               const std::optional<Vec3>& pivot = {});
Pins matter_on(const geometry::Cubes& cubes, HeldMatter matter,
               const std::vector<geometry::Vec3f>& places);

// Throws std::invalid_argument where cubes that are held are no cubes of these, or have other
// corners there.
void check_held(const geometry::Cubes& cubes, const HeldMatter& matter);

// m, the middle of what is held in a cube, where it is to be.
Vec3 middle_of(const HeldMatter& matter, const HeldCube& cube);

// N/m, of corners a and b.
inline double stiffness_at(const HeldCube& cube, std::size_t a, std::size_t b)
{
    return double(a < b ? cube.stiffness[b * (b + 1) / 2 + a]
                        : cube.stiffness[a * (a + 1) / 2 + b]);
}

// Where the targets of held points were when the frame began: as the state has them, and with the
// corners where they are for those that it does not know.
std::vector<geometry::Vec3> targets_before(const HeldMatter& matter, const State& state);

}  // namespace physics
