#pragma once

// How deep a point lies in a part of a body, or how far before it, by the part's shape at rest (see
// part_contact.hpp).

#include "physics/body/bent_cube.hpp"
#include "physics/body/part_shapes.hpp"
#include "physics/body/point_contact.hpp"

#include <optional>

namespace physics {

// A place in a cube of a part where that is at rest.
struct AtRest {
    AtRest(const PartShapes& shapes, std::uint32_t part, std::uint32_t cube, const InCube& in);

    const geometry::TriangleBvh& shape;
    const geometry::TriangleBvh& faces;  // those of it that lead out
    double size;                         // m, of a cube
    int winding;                         // of the shape at `inner`; unknown_winding
    Vec3 inner;                          // m, a place in the cube
    Mat3 back;                           // F^-1
    Vec3 place;                          // m
    Vec3 low;                            // m, the least corner of the cube
    std::uint64_t quarters;              // of its cell, that its material lies in

    // Whether the cube's own material may lie at `where` (m), in its cell. Others may share it.
    bool holds(const Vec3& where) const;
    // Whether `place` is inside of the shape.
    bool inside() const;
};

// Of a point in a part's matter: how it came there in this step, which way its own surface faces
// (0: any), and whether it is of the same part.
struct Approach {
    Vec3 way, outward;  // m, unit
    bool own = false;
};

// How deep the point that is in a cube of a part lies in that part's shape. It leaves through the
// nearest side, but not through one that faces as its own surface does, as the side of a block does
// for the lower rim of what stands on it, and not through the far one if it came fast. None where
// it is not inside.
std::optional<Gap> find_gap(const AtRest& rest, const Approach& approach);

// How far the point before a face of a part is from it, as the cube nearby would be bent there.
// None where it is further than `reach` (m), in the part, or before an edge. A point of the part's
// `own` is before a face of the cube's own material only: the nearest face may be the one that it
// is on itself.
std::optional<Gap> find_distance(const AtRest& rest, const Vec3& outward, double reach, bool own);

}  // namespace physics
