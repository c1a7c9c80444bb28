#pragma once

// One picture in four parts, as modelling programs have them:
//
//   top    camera        top and front, front and right side stand in line, at one scale, and
//   front  side          parallel; the fourth is what the camera sees
//
// The views are those of the third angle: the top view lies above the front view.

#include "render/camera.hpp"
#include "render/draw.hpp"

#include <array>
#include <functional>

namespace render {

enum class FourthView { top, camera, front, side };

// Width and height of each part, pixels, in a picture of this size.
std::array<int, 2> fourth_size(int width, int height);

// Cameras of the three parallel views of `box`, which lies in the middle of all with `margin` free
// where it is largest; of pictures of `aspect`. In the order of FourthView, that of the camera as
// it is given.
std::array<Camera, 4> four_cameras(const Box& box, const Camera& camera, double aspect,
                                   double margin);

// Such a picture of `look`'s size; a light line parts the four. Legend and notes are in the part of
// the camera, the label in the lower left one. `margin`: of the parallel views. Throws
// std::invalid_argument for pictures below 16 x 16 pixels, and as draw() does.
Image four_views(const Scene& scene, const Box& box, const Camera& camera, double margin,
                 const Look& look, std::vector<std::string>* warnings = nullptr,
                 const std::function<void()>& check = {});

// Copies all of `part` into `whole`, whose linear light and depth `part` has too, where it has any,
// with its upper left corner at (x, y).
void paste(Image& whole, const Image& part, int x, int y);

}  // namespace render
