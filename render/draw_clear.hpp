#pragma once

// The pass of transparent triangles, lit and laid over what is there: in the order of the job, by
// whole triangles, or where they may cut through each other, the nearest layers in each sample.
//   Everitt, Interactive order-independent transparency, NVIDIA 2001 (depth peeling).
// Faces that lie on each other are of one layer, in which they are blended in the scene's order.

#include "render/draw_job.hpp"
#include "render/gl_objects.hpp"

namespace render {

// Into the pass of light, which is bound and has the depths and stencil of the layer.
void draw_clear(GlObjects& gl, const DrawJob& job);

}  // namespace render
