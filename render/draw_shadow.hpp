#pragma once

// The first pass: depths as the key light sees them, into the shadow map, and into a coarser one of
// what lies beyond it.

#include "render/draw_job.hpp"
#include "render/gl_objects.hpp"

namespace render {

// The job's vertices and indices must be in OpenGL's buffers, and the numbers of its frame.
void draw_shadow(GlObjects& gl, const DrawJob& job);

}  // namespace render
