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

GLuint program_for(const ShadowPrograms& p, bool cut, bool glass)
{
    if (glass) return cut ? p.clear_textured : p.clear;
    return cut ? p.textured : p.plain;
}

// All that casts a shadow, into the bound map.
void draw_casters(const GlObjects& gl, const DrawJob& job, const ShadowPrograms& programs)
{
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glClearDepth(1);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 0);
    glEnable(GL_DEPTH_CLAMP);  // what lies before the map's box casts a shadow into it all the same
    for (const bool clear : {false, true}) {
        const bool glass = clear && job.numbers.frame.backdrop_horizon[3] == 1;
        for (const Batch& batch : clear ? job.clear.subspan(job.numbers.layered) : job.opaque) {
            if (!batch.shadow || batch.shape == Batch::Shape::lines) continue;
            const bool round = batch.shape == Batch::Shape::balls;
            const bool cut = batch.cover.texture >= 0 &&
                             batch.cover.use.alpha != geometry::TextureUse::Alpha::ignored;
            glUseProgram(round ? programs.balls : program_for(programs, cut, glass));
            if (round) glUniform1i(1, 1);
            const auto laid_for = glass ? LaidFor::depth : LaidFor::shadow;
            if (cut) use_cover(gl.textures, job, batch.cover, unit_texture, laid_for);
            glDrawElements(round ? GL_POINTS : GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT,
                           at_index(batch.first));
        }
    }
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_POLYGON_OFFSET_FILL);
}

void fit_map(Target& map, GLuint pass, int width, int height)
{
    if (!map.fit(std::max(width, 1), std::max(height, 1))) return;
    glTextureParameteri(map.name, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTextureParameteri(map.name, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glNamedFramebufferTexture(pass, GL_DEPTH_ATTACHMENT, map.name, 0);
}

}  // namespace

void draw_shadow(GlObjects& gl, const DrawJob& job)
{
    const PictureNumbers& n = job.numbers;
    fit_map(gl.shadow_map, gl.shadow_pass, n.shadow_width, n.shadow_height);
    fit_map(gl.far_map, gl.far_pass, n.far_width, n.far_height);
    if (n.shadow_width == 0) return;
    bind(gl.shadow_pass, gl.shadow_map);
    draw_casters(gl, job, gl.programs.shadow);
    draw_traced_shadow(gl, job);
    if (n.far_width == 0) return;
    bind(gl.far_pass, gl.far_map);
    draw_casters(gl, job, far_shadow_programs(gl));
}

}  // namespace render
