#pragma once

#include "geometry/vec.hpp"

namespace render {

using geometry::Box;
using geometry::Vec3;

// A pinhole that looks at `target`. World coordinates, metres.
struct Camera {
    Vec3 eye{0, 0, 5}, target{0, 0, 0}, up{0, 1, 0};
    double field_of_view = 0.6;  // radians, of the picture's height
};

// From where the camera stands, seen from the target: azimuth 0 looks along -z (the camera stands
// towards +z), growing counter-clockwise seen from above; elevation above the horizon. Radians.
Vec3 direction(double azimuth, double elevation);

// One of the 8 corners of a box that is not empty, k = 0 .. 7.
Vec3 corner_of(const Box& box, int k);

// The nearest camera, looking against direction(azimuth, elevation), whose picture of `aspect`
// (width / height) holds all of `box` with `margin` (a share of the picture's size, 0..0.45) free
// on each side, and `right_free` (a share of its width, up to 0.45) on the right where that is
// more; the box is in the middle as far as there is room for it. An empty box is taken for a point
// at the origin, a point for a box 1 m wide. Throws std::invalid_argument for a box that is not
// finite.
Camera fit(const Box& box, double azimuth, double elevation, double field_of_view, double aspect,
           double margin, double right_free = 0);

// Where right, up and ahead are in the picture: rows of length 1, across each other. The camera
// must not stand at its target; one that looks along `up` has some direction to its right.
geometry::Mat3 camera_axes(const Camera& camera);

// Whether some of `box` may lie in the camera's picture of `aspect`: not where all of it is behind
// the camera or beyond one and the same side of the picture.
bool may_see(const Camera& camera, const Box& box, double aspect);

}  // namespace render
