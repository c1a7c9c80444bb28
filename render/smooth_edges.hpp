#pragma once

// Antialiasing of a finished picture.

#include "render/image.hpp"

namespace render {

// Smooths the stairs along edges of a finished picture, whose alpha is each pixel's brightness as
// the eye sees it. After the idea of Lottes, FXAA, NVIDIA 2009: find on which side of a pixel an
// edge in brightness runs, follow it both ways to its ends, and mix in the other side by how far
// along the stair the pixel is. On the processor that OpenGL runs on too, a loop over bytes costs a
// quarter of a shader. Alpha stays as it is.
void smooth_edges(Image& image);

}  // namespace render
