#include "render/draw_clear.hpp"

#include "render/drawn_part.hpp"
#include "render/gl_passes.hpp"

#include <array>
#include <cstddef>

namespace render {

namespace {

constexpr int peeled_layers = 4;

// The triangles where they are seen, in the job's order. `behind`: only what lies behind the layer
// that is bound as unit_peeled.
void draw_triangles(GlObjects& gl, const DrawJob& job, bool behind)
{
    const LitPrograms& p = lit_programs(gl, job.numbers);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_NOTEQUAL, is_body, all_bits);
    for (const Batch& batch : job.clear) {
        (batch.ghost ? glEnable : glDisable)(GL_STENCIL_TEST);
        const bool textured = batch.cover.any();
        glUseProgram(textured ? p.clear_textured : p.clear);
        if (textured) use_cover(gl.textures, job, batch.cover, unit_texture, LaidFor::picture);
        if (job.numbers.peel) glUniform1i(8, behind);
        glUniform1i(5, 0);
        glUniform1i(3, batch.mapped);
        glUniform1f(4, (float(batch.map) + 0.5f) / map_count);
        glDrawElements(GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT, at_index(batch.first));
    }
    glDisable(GL_STENCIL_TEST);
}

void blend_triangles(GlObjects& gl, const DrawJob& job, bool behind)
{
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    draw_triangles(gl, job, behind);
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
}

// What `from` holds, into the bound framebuffer.
void lay(const GlObjects& gl, const Target& from, GLenum share, GLenum share_there)
{
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(share, share_there);
    glBindTextureUnit(unit_first, from.name);
    fill_screen(gl.programs.laid);
    glDisable(GL_BLEND);
}

void clear_colours(GLuint pass)
{
    constexpr std::array<float, 4> none{};
    glClearNamedFramebufferfv(pass, GL_COLOR, 0, none.data());
}

// The nearest layers from near to far, each under those before it; then what lies behind them, and
// they over that.
void draw_peeled(GlObjects& gl, const DrawJob& job)
{
    Peel& peel = gl.peel;
    const int width = gl.light.width, height = gl.light.height;
    peel.fit(width, height);
    const DrawnPart part = drawn_part(job);  // nothing is clear elsewhere
    const int samples = width / job.numbers.width;
    glEnable(GL_SCISSOR_TEST);
    glScissor(samples * part.x, samples * part.y, samples * part.width, samples * part.height);
    clear_colours(peel.sum_pass);
    for (std::size_t k = 0; k < peeled_layers; ++k) {
        const GLuint pass = peel.passes[k % 2];
        // What is nearest of the rest is found among the depths of what is opaque.
        glBlitNamedFramebuffer(gl.layer.framebuffer, pass, 0, 0, width, height, 0, 0, width, height,
                               GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT, GL_NEAREST);
        clear_colours(pass);
        bind(pass, peel.layer);
        glBindTextureUnit(unit_peeled, peel.depths[(k + 1) % 2].name);
        draw_triangles(gl, job, k > 0);
        bind(peel.sum_pass, peel.sum);
        lay(gl, peel.layer, GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    }
    bind(gl.light_pass, gl.light);
    glBindTextureUnit(unit_peeled, peel.depths[(peeled_layers - 1) % 2].name);
    blend_triangles(gl, job, true);
    lay(gl, peel.sum, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glDisable(GL_SCISSOR_TEST);
}

}  // namespace

void draw_clear(GlObjects& gl, const DrawJob& job)
{
    if (job.numbers.peel) {
        draw_peeled(gl, job);
    } else {
        blend_triangles(gl, job, false);
    }
}

}  // namespace render
