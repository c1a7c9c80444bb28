#include "render/draw_shadow.hpp"

#include "render/gl_passes.hpp"

#include <algorithm>

namespace render {
namespace {

void draw_traced_shadow(const GlObjects& gl, const DrawJob& job)
{
    if (job.traced_shadow.empty()) return;
    const auto [x, y, width, height] = job.numbers.traced_shadow;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, gl.traced_shadow);
    glProgramUniform4i(gl.programs.traced_shadow, 1, x, y, width, height);
    fill_screen(gl.programs.traced_shadow);
}

GLuint shadow_program(const GlObjects& gl, bool cut, bool glass)
{
    const auto& p = gl.programs;
    if (glass) return cut ? p.shadow_clear_textured : p.shadow_clear;
    return cut ? p.shadow_textured : p.shadow;
}

}  // namespace

void draw_shadow(GlObjects& gl, const DrawJob& job)
{
    const int width = job.numbers.shadow_width, height = job.numbers.shadow_height;
    if (gl.shadow_map.fit(std::max(width, 1), std::max(height, 1))) {
        const GLuint name = gl.shadow_map.name;
        glTextureParameteri(name, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glTextureParameteri(name, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
        glNamedFramebufferTexture(gl.shadow_pass, GL_DEPTH_ATTACHMENT, name, 0);
    }
    if (width == 0) return;
    bind(gl.shadow_pass, gl.shadow_map);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glClearDepth(1);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 0);
    glEnable(GL_DEPTH_CLAMP);  // what lies before the map's box casts a shadow into it all the same
    for (const bool clear : {false, true}) {
        const bool glass = clear && job.numbers.frame.backdrop_horizon[3] == 1;
        for (const Batch& batch : clear ? job.clear : job.opaque) {
            if (!batch.shadow || batch.shape == Batch::Shape::lines) continue;
            const bool round = batch.shape == Batch::Shape::balls;
            const bool cut = batch.cover.texture >= 0 &&
                             batch.cover.use.alpha != geometry::TextureUse::Alpha::ignored;
            glUseProgram(round ? gl.programs.balls_shadow : shadow_program(gl, cut, glass));
            if (round) glUniform1i(1, 1);
            const auto laid_for = glass ? LaidFor::clear_shadow : LaidFor::shadow;
            if (cut) use_cover(gl.textures, job, batch.cover, unit_texture, laid_for);
            glDrawElements(round ? GL_POINTS : GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT,
                           at_index(batch.first));
        }
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_POLYGON_OFFSET_FILL);
    draw_traced_shadow(gl, job);
}

}  // namespace render
