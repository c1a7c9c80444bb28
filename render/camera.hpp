#pragma once

// The pinhole camera, and how one is fitted to what it should show.

#include "geometry/base/vec.hpp"

#include <optional>
#include <span>
#include <vector>

namespace render {

using geometry::Box;
using geometry::Vec3;
using geometry::Vec3f;

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

// The same for points, which are met on at least two sides of the picture: what lies between them
// is held too. None are taken for an empty box.
Camera fit(std::span<const Vec3f> points, double azimuth, double elevation, double field_of_view,
           double aspect, double margin, double right_free = 0);

// `points` turned about the upright axis through the middle of their box, 24 times: a camera
// that fits them stays at one distance while it goes round.
std::vector<Vec3f> turned_about(std::span<const Vec3f> points);

// Radians: so narrow that it stands for a parallel projection, to a third of a pixel of 540.
inline constexpr double parallel_view = 0.002;

// The camera that sees in parallel what `camera` sees of the plane through its target, from the
// same direction. One that stands at its target stays there.
Camera parallel_from(const Camera& camera);

// Where right, up and ahead are in the picture: rows of length 1, across each other. The camera
// must not stand at its target; one that looks along `up` has some direction to its right.
geometry::Mat3 camera_axes(const Camera& camera);

// Where a point lies in the camera's picture of `aspect`: x and y from 0 at the upper left corner
// to 1 at the lower right one, and z, how many of the picture's heights a metre is there. Nothing
// of a point that is not before the camera.
std::optional<Vec3> place_in_picture(const Camera& camera, const Vec3& point, double aspect);

// Whether some of `box` may lie in the camera's picture of `aspect`: not where all of it is behind
// the camera or beyond one and the same side of the picture.
bool may_see(const Camera& camera, const Box& box, double aspect);

}  // namespace render
