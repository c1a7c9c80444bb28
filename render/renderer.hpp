#pragma once

#include "render/draw_list.hpp"
#include "render/gl_context.hpp"
#include "render/image.hpp"

namespace render {

// Draws lists with one OpenGL context, whose compiled shaders and buffers it keeps from one picture
// to the next: the first costs a tenth of a second more. For one thread at a time.
class Renderer {
public:
    Renderer();
    ~Renderer();
    Image draw(const DrawList& list, const Look& look);

private:
    struct Gl;
    GlContext context_;
    std::unique_ptr<Gl> gl_;
};

}  // namespace render
