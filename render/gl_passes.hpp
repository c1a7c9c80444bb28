#pragma once

// What the passes of the renderer share: where their textures are bound, what the stencil says, and
// how a pass begins.

#include "render/gl_objects.hpp"

#include <cstdint>

namespace render {

enum Unit : GLuint {
    unit_first,
    unit_depths,
    unit_shadow,
    unit_maps,
    unit_seen,
    unit_plain_depths,
    unit_smooth_depths,
    unit_fine,
    unit_fine_depths,
    unit_texture,
    unit_normals,  // see use_cover()
    unit_far,
    unit_peeled,  // depths of a layer of what is clear, and of the one before it
    unit_peeled_before
};

// What the stencil says of a pixel. Of a body, which is an object, it says that ghosts spare it.
enum Stencil : GLint { is_backdrop, is_object, is_floor, is_uneven, is_body = 0x80 | is_object };
constexpr GLuint all_bits = 0xff, without_body = 0x7f;

inline void bind(GLuint framebuffer, const Target& target)
{
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, target.width, target.height);
}

inline void fill_screen(GLuint with_program)
{
    glUseProgram(with_program);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

inline const void* at_index(std::uint32_t i)
{
    return reinterpret_cast<const void*>(std::uintptr_t{i} * sizeof(std::uint32_t));
}

}  // namespace render
