#include "render/draw_clear.hpp"

#include "render/gl_passes.hpp"

namespace render {

void draw_clear(GlObjects& gl, const DrawJob& job)
{
    const LitPrograms& p = lit_programs(gl, job.numbers);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_NOTEQUAL, is_body, all_bits);
    for (const Batch& batch : job.clear) {
        (batch.ghost ? glEnable : glDisable)(GL_STENCIL_TEST);
        const bool textured = batch.cover.any();
        glUseProgram(textured ? p.clear_textured : p.clear);
        if (textured) use_cover(gl.textures, job, batch.cover, unit_texture, LaidFor::picture);
        glUniform1i(5, 0);
        glUniform1i(3, batch.mapped);
        glUniform1f(4, (float(batch.map) + 0.5f) / map_count);
        glDrawElements(GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT, at_index(batch.first));
    }
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
}

}  // namespace render
