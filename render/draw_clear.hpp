#pragma once

// The pass of transparent triangles, lit and laid over what is there.

#include "render/draw_job.hpp"
#include "render/gl_objects.hpp"

namespace render {

// Into the bound framebuffer, which has linear light and the depths and stencil of the layer.
void draw_clear(GlObjects& gl, const DrawJob& job);

}  // namespace render
