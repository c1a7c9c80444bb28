#pragma once

// Where rays meet the surface of a field first, to a tolerance, and its gradient there.
//
//           |<- proven ->|<- h ->|
//   f  0 ---+------------+-------+--.--
//          o|                   o .'
//           |                  .'
//
// From a sample outside (f < 0) the ray goes on as far as the slopes' bounds prove that there is no
// surface (iso_cells.hpp), and from there to where Newton's step leads, by a quarter of a cell (h)
// at most; where f may jump, by a sixteenth. Where f changes its sign the crossing is closed in.
//
// Between two samples outside, of which the first comes nearer and the second goes away, the
// surface may have been grazed. A field that is concave between them stays below both tangents;
// where lines four times as steep meet above 0 the highest point is looked for.
//
// All rays of a call go on together, so that each step asks the field at a whole block of points.
// Their results do not depend on each other.

#include "geometry/fields/iso_cells.hpp"

#include <limits>
#include <span>

namespace geometry {

// origin + t * direction, begin <= t <= end. The direction may have any length but 0.
struct Ray {
    Vec3 origin = Vec3::Zero(), direction = Vec3::UnitZ();
    double begin = 0, end = std::numeric_limits<double>::infinity();
};

struct RayHit {
    double t = std::numeric_limits<double>::infinity();  // of the ray; infinite: it meets nothing
    Vec3 normal = Vec3::Zero();                          // unit, out of the solid

    bool there() const { return t < std::numeric_limits<double>::infinity(); }
};

// The first crossing of each ray, from the outside in, or from the inside out where it starts
// inside. `tolerance`: m, along the ray. As many hits as rays.
void trace(const IsoField& field, const IsoCells& cells, std::span<const Ray> rays,
           double tolerance, std::span<RayHit> hits);

}  // namespace geometry
