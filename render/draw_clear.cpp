#include "render/draw_clear.hpp"

#include "render/drawn_part.hpp"
#include "render/gl_passes.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace render {

namespace {

constexpr int peeled_layers = 4;

// Which triangles are drawn where they are seen, and what of them.
struct Drawn {
    std::span<const Batch> batches;  // in their order
    bool behind = false;             // the layer that is bound as unit_peeled_before
    bool up_to_layer = false;        // no farther than the layer that is bound as unit_peeled
    bool depths_alone = false;
};

void draw_triangles(GlObjects& gl, const DrawJob& job, const Drawn& drawn)
{
    const LitPrograms& p = lit_programs(gl, job.numbers);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_NOTEQUAL, is_body, all_bits);
    for (const Batch& batch : drawn.batches) {
        (batch.ghost ? glEnable : glDisable)(GL_STENCIL_TEST);
        const bool textured = batch.cover.any();
        if (drawn.depths_alone) {
            glUseProgram(textured ? p.peel_textured : p.peel);
        } else {
            glUseProgram(textured ? p.clear_textured : p.clear);
            glUniform1i(3, batch.mapped);
            glUniform1f(4, (float(batch.map) + 0.5f) / map_count);
        }
        const auto laid_for = drawn.depths_alone ? LaidFor::depth : LaidFor::picture;
        if (textured) use_cover(gl.textures, job, batch.cover, unit_texture, laid_for);
        if (job.numbers.layered > 0) glUniform1i(8, drawn.behind);
        if (job.numbers.layered > 0 && !drawn.depths_alone) glUniform1i(9, drawn.up_to_layer);
        glUniform1i(5, 0);
        glDrawElements(GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT, at_index(batch.first));
    }
    glDisable(GL_STENCIL_TEST);
}

void blend_triangles(GlObjects& gl, const DrawJob& job, const Drawn& drawn)
{
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    draw_triangles(gl, job, drawn);
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

// Into the bound framebuffer of depths. False where there is nothing.
bool find_nearest(GlObjects& gl, const DrawJob& job, const Drawn& drawn)
{
    glBeginQuery(GL_ANY_SAMPLES_PASSED, gl.peel.any);
    draw_triangles(gl, job, drawn);
    glEndQuery(GL_ANY_SAMPLES_PASSED);
    GLuint any = 0;
    glGetQueryObjectuiv(gl.peel.any, GL_QUERY_RESULT, &any);
    return any != 0;
}

// The nearest layers from near to far, each under those before it; then what lies behind them, and
// they over that. Of a layer the depths are found first, and then all that lies there is blended.
void draw_peeled(GlObjects& gl, const DrawJob& job)
{
    Peel& peel = gl.peel;
    const int width = gl.light.width, height = gl.light.height;
    peel.fit(width, height, gl.layer.depths);
    const DrawnPart part = drawn_part(job);  // nothing is clear elsewhere
    const int samples = width / job.numbers.width;
    const auto sorted = job.clear.subspan(job.numbers.layered);
    const auto as_in_scene = job.clear.first(job.numbers.layered);
    glEnable(GL_SCISSOR_TEST);
    glScissor(samples * part.x, samples * part.y, samples * part.width, samples * part.height);
    clear_colours(peel.sum_pass);
    bool more = true;
    for (std::size_t k = 0; k < peeled_layers; ++k) {
        const GLuint pass = peel.depth_passes[k % 2];
        // What is nearest of the rest is found among the depths of what is opaque.
        glBlitNamedFramebuffer(gl.layer.framebuffer, pass, 0, 0, width, height, 0, 0, width, height,
                               GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT, GL_NEAREST);
        bind(pass, peel.depths[k % 2]);
        glBindTextureUnit(unit_peeled_before, peel.depths[(k + 1) % 2].name);
        more = find_nearest(gl, job, {as_in_scene, k > 0, false, true});
        if (!more) break;
        clear_colours(peel.layer_pass);
        bind(peel.layer_pass, peel.layer);
        glBindTextureUnit(unit_peeled, peel.depths[k % 2].name);
        blend_triangles(gl, job, {as_in_scene, k > 0, true});
        bind(peel.sum_pass, peel.sum);
        lay(gl, peel.layer, GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    }
    bind(gl.light_pass, gl.light);
    glBindTextureUnit(unit_peeled_before, peel.depths[(peeled_layers - 1) % 2].name);
    if (more) blend_triangles(gl, job, {sorted, true});
    lay(gl, peel.sum, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glDisable(GL_SCISSOR_TEST);
}

}  // namespace

void draw_clear(GlObjects& gl, const DrawJob& job)
{
    if (job.numbers.layered > 0) {
        draw_peeled(gl, job);
    } else {
        blend_triangles(gl, job, {job.clear});
    }
}

}  // namespace render
