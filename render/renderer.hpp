#pragma once

// Fills in a picture with OpenGL, in these passes:
//
//   shadow    depths as the key light sees them                         -> shadow map, far map
//   batches   what is nearest in each pixel: normal, colour, depth      -> layer
//   seen      with soft light: which shares of it reach what is seen    -> seen
//   light     floor, backdrop and objects lit, each where it is seen    -> picture, or light
//   edges     with samples4: again at four places of a pixel, where these differ
//   clear     transparent triangles over the light, from far to near (layer by layer where they may
//             cut through each other); then the finish
//
// With samples16 all of it is done sixteen times, each time with the samples in other places of
// their pixels. Linear light, where it is asked for, is drawn after that and by itself. The shaders
// in render/shaders/ say what each computes.

#include "render/draw_job.hpp"
#include "render/gl_context.hpp"

#include <cstdint>
#include <memory>
#include <span>

namespace render {

struct GlObjects;

// Draws with one OpenGL context, whose compiled shaders and buffers it keeps from one picture to
// the next: the first costs a tenth of a second more. For one thread at a time.
class Renderer {
public:
    Renderer();
    ~Renderer();

    // Writes sRGB colours, and in their alpha each pixel's brightness as the eye sees it, for
    // smooth_edges; and the light before that, where the job asks for it. Throws
    // std::runtime_error where OpenGL reports an error.
    void draw(const DrawJob& job, const Pixels& to);

private:
    GlContext context_;
    std::unique_ptr<GlObjects> gl_;
};

}  // namespace render
