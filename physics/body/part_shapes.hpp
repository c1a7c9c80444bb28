#pragma once

// What parts of one body need to know of each other to touch: the shape of each part at rest, and
// which cubes, corners and points of the surface are its own. A part is a set of cubes that hang
// together by corners. Contact itself is found by part_contact.hpp.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace physics {

// Contact between parts, and of a part with itself.
struct PartContactOptions {
    bool on = true;
    bool self = false;
    double friction = 0.5;  // Coulomb coefficient
    double bounce = 0;      // share of the speed that parts come apart with
};

constexpr std::int16_t unknown_winding = std::numeric_limits<std::int16_t>::max();

// Two parts, a < b, or a part and itself.
struct PartPair {
    std::uint32_t a = 0, b = 0;

    auto operator<=>(const PartPair&) const = default;
};

// Numbers of several lists, one after another.
struct PartLists {
    std::vector<std::uint32_t> at;    // lists + 1, into item
    std::vector<std::uint32_t> item;  // ascending within a list

    std::span<const std::uint32_t> operator[](std::size_t list) const
    {
        return std::span(item).subspan(at[list], at[list + 1] - at[list]);
    }
};

// The items 0 .. list_of.size() by the list that each is in.
PartLists make_part_lists(const std::vector<std::uint32_t>& list_of, std::size_t lists);

// For each of some cubes: all within two steps of it, itself included, ascending. A step leads to a
// cube that shares a corner (slot).
PartLists cubes_around(const std::vector<std::array<std::uint32_t, 8>>& corners,
                       const std::vector<std::uint32_t>& of, std::size_t slots);

// A place on a part's shape that stands for a bit of its area.
struct ShapePoint {
    geometry::Vec3f place;   // in its cube, 0..1
    geometry::Vec3f normal;  // unit, outward at rest
    float area = 0;          // m^2
};

// Cube c of a part fills origin + size * (cell[c] .. cell[c] + 1) at rest.
struct PartGrid {
    double size = 0;  // m, edge of a cube
    geometry::Vec3 origin = geometry::Vec3::Zero();
};

struct PartShapes {
    double friction = 0.5, bounce = 0;
    double mass_of_all = 0;      // kg
    double least_size = 0;       // m, of all parts
    std::vector<PartGrid> grid;  // of each part

    std::vector<geometry::Vec3i> cell;                  // C, of the grid of its part
    std::vector<std::array<std::uint32_t, 8>> corners;  // C, slots
    std::vector<float> stiffness;                       // C, Pa, Young's modulus times fill
    std::vector<float> mass;                            // C, kg
    PartLists cubes, slots;                             // of each part

    std::vector<geometry::TriangleBvh> shape;  // of each part at rest, closed, m
    // Of each part, its faces on the outside of all its pieces (outer_faces.hpp); empty: all are.
    std::vector<geometry::TriangleBvh> outer;
    // C: the winding number of its part's shape at inner_place() of the cube; unknown_winding.
    std::vector<std::int16_t> winding;
    std::vector<ShapePoint> point;        // cube by cube
    std::vector<std::uint32_t> holder;    // H, cubes with points, ascending
    std::vector<std::uint32_t> point_at;  // H + 1, into point
    PartLists holders;                    // of each part
    // Of each of the H: cubes within two steps over shared corners, ascending. Its points do not
    // touch them. No lists: parts do not touch themselves.
    PartLists around;
    std::vector<std::uint64_t> quarters;  // C, as Cubes::part; empty: cubes have all of their cells
    std::vector<PartPair> overlapping;    // at rest, ascending: these do not touch each other
    std::vector<geometry::Vec3> overlap_at;  // m, where each of those pairs lies deepest

    std::size_t parts() const { return shape.size(); }
    const geometry::TriangleBvh& faces(std::uint32_t part) const
    {
        return outer[part].triangle_count() > 0 ? outer[part] : shape[part];
    }
    geometry::Vec3 inner_place(std::uint32_t part, std::uint32_t cube) const;  // m, at rest
    double size_of(std::uint32_t part) const { return grid[part].size; }
    bool touch_themselves() const { return !around.at.empty(); }
    std::size_t bytes() const;
};

// Fills in `winding`, of parts, cubes and shapes.
void find_windings(PartShapes& shapes);

}  // namespace physics
