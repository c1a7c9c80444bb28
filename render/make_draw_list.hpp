#pragma once

// A scene, a camera and a look as a draw list: in stage units, with its view, its shadow's box and
// its floor.

#include "render/camera.hpp"
#include "render/draw_list.hpp"
#include "render/look.hpp"
#include "render/scene.hpp"

namespace render {

// Throws std::invalid_argument for sizes, cameras and stages that no picture can be made of. Shapes
// that cannot be drawn (not finite, naming vertices that are not there) are left out with a
// warning.
DrawList make_draw_list(const Scene& scene, const Camera& camera, const Look& look);

}  // namespace render
