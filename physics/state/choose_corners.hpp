#pragma once

// Which corners of a set of cubes lie somewhere, at rest. All return sorted indices. Of pieces that
// share cells (Cubes::part), the corners are those of pieces that come into the region.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/state/loads.hpp"

#include <optional>
#include <string>
#include <vector>

namespace physics {

std::vector<std::uint32_t> corners_in_box(const geometry::Cubes& cubes, const geometry::Box& box);
std::vector<std::uint32_t> corners_in_sphere(const geometry::Cubes& cubes, const Vec3& centre,
                                             double radius);
std::vector<std::uint32_t> corners_below(const geometry::Cubes& cubes, double height);

// The outermost `layers` + 1 planes of corners along an axis (0..2), that is the corners of the
// outermost `layers` layers of cubes; at its low end, its high end or both. Without layers, not
// those of pieces that end half a cube or more before others.
enum class End { both, low, high };
std::vector<std::uint32_t> corners_at_end(const geometry::Cubes& cubes, int axis, End end,
                                          int layers);

// Corners within `distance` (m) of the mesh's faces of the material, or of the group, of that name.
// Throws std::invalid_argument, with the names there are, when there is neither.
std::vector<std::uint32_t> corners_near_material(const geometry::Cubes& cubes,
                                                 const geometry::TriMesh& mesh,
                                                 const std::string& name, double distance);

// The mesh's triangles of that name, and the mesh with these alone. Throw likewise.
std::vector<std::uint32_t> faces_called(const geometry::TriMesh& mesh, const std::string& name);
geometry::TriMesh faces_of(const geometry::TriMesh& mesh, const std::string& name);

// Corners on the outside: those that have less than eight cubes around them, or on a plane less
// than four cells, its border and that of its holes.
std::vector<std::uint32_t> corners_at_rim(const geometry::Cubes& cubes);

// Pins that hold those corners where `motion` takes their rest positions. On their way they turn
// about `pivot`, a place at rest; without one, about their middle.
Pins pins_at(const geometry::Cubes& cubes, std::vector<std::uint32_t> corners,
             const Transform& motion, const std::optional<Vec3>& pivot = {});

// Throws std::invalid_argument when there are not as many places as corners.
void require_a_place_a_corner(const geometry::Cubes& cubes,
                              const std::vector<geometry::Vec3f>& places);

// Pins that hold those corners where `places` (one for each corner of the cubes) has them. Throws
// std::invalid_argument when there are not as many.
Pins pins_on(const geometry::Cubes& cubes, std::vector<std::uint32_t> corners,
             const std::vector<geometry::Vec3f>& places);

}  // namespace physics
