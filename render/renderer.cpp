#include "render/renderer.hpp"

#include "render/colour.hpp"
#include "render/draw_clear.hpp"
#include "render/draw_shadow.hpp"
#include "render/drawn_part.hpp"
#include "render/gl_passes.hpp"
#include "render/image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace render {
namespace {

constexpr int alike = 64;  // see shaders/uneven.frag

// Runs `with_program` on those pixels of a part only that `mark` does not discard.
void fill_marked(GLuint mark, GLuint with_program, const DrawnPart& part)
{
    glEnable(GL_SCISSOR_TEST);
    glScissor(part.x, part.y, part.width, part.height);
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_STENCIL_TEST);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glStencilFunc(GL_ALWAYS, is_uneven, all_bits);
    fill_screen(mark);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_EQUAL, is_uneven, all_bits);
    fill_screen(with_program);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_SCISSOR_TEST);
}

void upload(const GlObjects& gl, const DrawJob& job)
{
    const auto fill = [](GLuint buffer, const auto& data) {
        glNamedBufferData(buffer, GLsizeiptr(data.size_bytes()), data.data(), GL_STREAM_DRAW);
    };
    fill(gl.vertices, job.vertices);
    fill(gl.indices, job.indices);
    if (!job.uvs.empty()) fill(gl.uvs, job.uvs);
    fill(gl.traced, job.traced);
    fill(gl.traced_samples, job.traced_samples);
    fill(gl.traced_shadow, job.traced_shadow);
    glBindVertexArray(job.uvs.empty() ? gl.vertex_array : gl.textured_array);
}

// Moves what is drawn so that the middle of each pixel shows what lies at `place`.
void move_samples(FrameNumbers& f, const SamplePlace& place)
{
    for (std::size_t k = 0; k < 3; ++k) f.corner[k] += place.x * f.across[k] + place.y * f.down[k];
    for (std::size_t column = 0; column < 4; ++column) {
        float* const row = &f.clip_from_stage[4 * column];
        row[0] -= 2 * place.x / f.across[3] * row[3];
        row[1] -= 2 * place.y / f.down[3] * row[3];
    }
    f.drawn_low[3] = place.turn;
}

// `samples` along each side of a pixel.
void set_numbers(const GlObjects& gl, const DrawJob& job, int samples, const SamplePlace& place)
{
    FrameNumbers numbers = job.numbers.frame;
    numbers.floor_colour[3] = float(samples);
    move_samples(numbers, place);
    glNamedBufferData(gl.frame, sizeof(numbers), &numbers, GL_STREAM_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, gl.frame);
}

// What rays found, into the bound framebuffer: the samples number `which`, at `place`.
void draw_traced(const GlObjects& gl, const DrawJob& job, int samples, int which,
                 const SamplePlace& place)
{
    if (job.traced.empty()) return;
    const auto [x, y, width, height] = job.numbers.traced;
    glEnable(GL_SCISSOR_TEST);
    glScissor(samples * x, samples * y, samples * width, samples * height);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, gl.traced);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, gl.traced_samples);
    glProgramUniform4i(gl.programs.traced, 1, x, y, width, height);
    glProgramUniform1i(gl.programs.traced, 2, which);
    glProgramUniform2f(gl.programs.traced, 3, place.x, place.y);
    fill_screen(gl.programs.traced);
    glDisable(GL_SCISSOR_TEST);
}

// Into the bound framebuffer. `which`: the number of the samples at `place`; -1: all middles.
void draw_batches(const GlObjects& gl, const DrawJob& job, int samples, int which = -1,
                  const SamplePlace& place = {})
{
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glClearDepth(0);
    glClearStencil(is_backdrop);
    // What the pixels hold matters only where something was drawn.
    glClear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    glEnable(GL_STENCIL_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glBindTextureUnit(unit_maps, gl.maps.name);
    for (const Batch& batch : job.opaque) {
        glStencilFunc(GL_ALWAYS, batch.body ? is_body : is_object, all_bits);
        GLenum mode = GL_TRIANGLES;
        if (batch.shape == Batch::Shape::balls) {
            mode = GL_POINTS;
            glUseProgram(gl.programs.balls);
            glUniform1f(0, batch.size);
            glUniform1i(1, 0);
        } else {
            const bool lines = batch.shape == Batch::Shape::lines;
            if (lines) {
                mode = GL_LINES;
                glLineWidth(std::max(1.0f, batch.size * float(samples)));
            }
            const bool textured = batch.cover.any();
            glUseProgram(textured ? gl.programs.surface_textured : gl.programs.surface);
            glUniform1i(5, lines);
            glUniform1i(3, batch.mapped);
            glUniform1f(4, (float(batch.map) + 0.5f) / map_count);
            if (textured) use_cover(gl.textures, job, batch.cover, unit_texture, LaidFor::picture);
        }
        glDrawElements(mode, GLsizei(batch.count), GL_UNSIGNED_INT, at_index(batch.first));
    }
    glStencilFunc(GL_ALWAYS, is_object, all_bits);
    draw_traced(gl, job, samples, which, place);
    glDisable(GL_STENCIL_TEST);
}

// Which shares of the light reach what the layer holds.
void draw_seen(GlObjects& gl, const DrawJob& job)
{
    const int width = (job.numbers.width + 1) / 2, height = (job.numbers.height + 1) / 2;
    for (std::size_t k = 0; k < 2; ++k) {
        if (!gl.seen[k].fit(width, height)) continue;
        glNamedFramebufferTexture(gl.seen_pass[k], GL_COLOR_ATTACHMENT0, gl.seen[k].name, 0);
    }
    glDisable(GL_DEPTH_TEST);
    glBindTextureUnit(unit_first, gl.layer.pixels.name);
    glBindTextureUnit(unit_depths, gl.layer.depths.name);
    for (const GLuint unit : {unit_plain_depths, unit_smooth_depths}) {
        glBindTextureUnit(unit, gl.shadow_map.name);
        glBindSampler(unit, unit == unit_plain_depths ? gl.plain_depths : gl.smooth_depths);
    }
    bind(gl.seen_pass[0], gl.seen[0]);
    fill_screen(lit_programs(gl, job.numbers).seen);
    for (std::size_t k = 0; k < 2; ++k) {
        bind(gl.seen_pass[1 - k], gl.seen[1 - k]);
        glBindTextureUnit(unit_seen, gl.seen[k].name);
        glProgramUniform2i(gl.programs.soften, 1, k == 0, k == 1);
        fill_screen(gl.programs.soften);
    }
    glBindTextureUnit(unit_seen, gl.seen[0].name);
}

// Light for what the layer holds, into the bound framebuffer, which has the layer's depth and
// stencil. The stencil is tested before a pixel is shaded: each shader runs only where it is
// needed.
void draw_light(GlObjects& gl, const DrawJob& job, Linear linear)
{
    const LitPrograms& p = lit_programs(gl, job.numbers);
    for (const GLuint program : {p.object, p.floor_lit, p.floor_shadowed, p.backdrop}) {
        glProgramUniform1i(program, 0, int(linear));
    }
    glEnable(GL_STENCIL_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    const auto draw_floor = [](GLuint with_program, const FloorPiece& piece) {
        if (!piece.there) return;
        glUseProgram(with_program);
        glUniform3fv(1, 4, piece.corners.data());
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    };
    glStencilFunc(GL_ALWAYS, is_floor, all_bits);
    draw_floor(p.floor_shadowed, job.numbers.shadowed_floor);
    glStencilFunc(GL_NOTEQUAL, is_floor, all_bits);  // depths of the two differ by rounding
    draw_floor(p.floor_lit, job.numbers.floor);

    glDisable(GL_DEPTH_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_EQUAL, is_backdrop, all_bits);
    fill_screen(p.backdrop);
    // Depths are read while they are attached, though not written.
    glTextureBarrier();
    glBindTextureUnit(unit_first, gl.layer.pixels.name);
    glBindTextureUnit(unit_depths, gl.layer.depths.name);
    glStencilFunc(GL_EQUAL, is_object, without_body);
    fill_screen(p.object);
    glDisable(GL_STENCIL_TEST);
}

// Where the four samples of a pixel do not agree, each gets its own light. `pass` has the layer's
// stencil.
void draw_edges(GlObjects& gl, const DrawJob& job, GLuint pass, const Target& to, Linear linear)
{
    gl.fine.fit(job.numbers.width, job.numbers.height);
    for (std::size_t k = 0; k < in_a_square.size(); ++k) {
        set_numbers(gl, job, 1, in_a_square[k]);
        glBindFramebuffer(GL_FRAMEBUFFER, gl.fine.framebuffers[k]);
        glViewport(0, 0, job.numbers.width, job.numbers.height);
        draw_batches(gl, job, 1, int(k), in_a_square[k]);
    }
    set_numbers(gl, job, 1, {});
    bind(pass, to);
    glBindTextureUnit(unit_fine, gl.fine.pixels);
    glBindTextureUnit(unit_fine_depths, gl.fine.depths);
    glProgramUniform1i(gl.programs.uneven, 1, job.textures.empty() ? 0 : alike);
    const GLuint edges = lit_programs(gl, job.numbers).edges;
    glProgramUniform1i(edges, 0, int(linear));
    fill_marked(gl.programs.uneven, edges, drawn_part(job));
}

// The edges of a diagram carry ink, which a second look would wash away.
bool has_edges(const DrawJob& job)
{
    return job.numbers.samples4 && job.clear.empty() && job.numbers.style != Style::diagram;
}

// Transparent things lie over whatever there is: then every pixel has all its samples.
int samples_along(const DrawJob& job)
{
    return job.numbers.samples4 && !job.clear.empty() ? 2 : 1;
}

// All that is opaque, straight into the picture.
void finish_opaque(GlObjects& gl, const DrawJob& job)
{
    glNamedFramebufferTexture(gl.finish_pass, GL_DEPTH_STENCIL_ATTACHMENT, gl.layer.depths.name, 0);
    bind(gl.finish_pass, gl.picture);
    draw_light(gl, job, Linear::none);
    if (has_edges(job)) draw_edges(gl, job, gl.finish_pass, gl.picture, Linear::none);
}

// Linear light of as many samples as the layer has, transparent things over it.
void draw_linear_light(GlObjects& gl, const DrawJob& job, Linear linear)
{
    if (gl.light.fit(gl.layer.pixels.width, gl.layer.pixels.height)) {
        glNamedFramebufferTexture(gl.light_pass, GL_COLOR_ATTACHMENT0, gl.light.name, 0);
    }
    glNamedFramebufferTexture(gl.light_pass, GL_DEPTH_STENCIL_ATTACHMENT, gl.layer.depths.name, 0);
    bind(gl.light_pass, gl.light);
    draw_light(gl, job, linear);
    if (!job.clear.empty()) draw_clear(gl, job);
}

// Linear light first, and from there into the picture.
void finish_clear(GlObjects& gl, const DrawJob& job)
{
    draw_linear_light(gl, job, Linear::whole);
    glNamedFramebufferTexture(gl.finish_pass, GL_DEPTH_STENCIL_ATTACHMENT, 0, 0);
    bind(gl.finish_pass, gl.picture);
    glBindTextureUnit(unit_first, gl.light.name);
    glDisable(GL_DEPTH_TEST);
    fill_screen(lit_programs(gl, job.numbers).finish);
}

}  // namespace

Renderer::Renderer()
{
    const GlContext::Current current(context_);
    gl_ = std::make_unique<GlObjects>(make_gl_objects());
}

Renderer::~Renderer() = default;

namespace {

// One picture, whose samples lie at `place` of their pixels: `which` of several, or -1.
void draw_picture(GlObjects& gl, const DrawJob& job, int which, const SamplePlace& place,
                  std::span<std::uint8_t> rgba)
{
    const PictureNumbers& numbers = job.numbers;
    const int samples = samples_along(job);
    set_numbers(gl, job, samples, place);
    gl.layer.fit(numbers.width * samples, numbers.height * samples);
    bind(gl.layer.framebuffer, gl.layer.pixels);
    draw_batches(gl, job, samples, which, place);

    glBindTextureUnit(unit_shadow, gl.shadow_map.name);
    glBindTextureUnit(unit_far, gl.far_map.name);
    if (numbers.soft) draw_seen(gl, job);
    if (gl.picture.fit(numbers.width, numbers.height)) {
        gl.picture.filter(GL_LINEAR);
        glNamedFramebufferTexture(gl.finish_pass, GL_COLOR_ATTACHMENT0, gl.picture.name, 0);
    }
    if (job.clear.empty()) {
        finish_opaque(gl, job);
    } else {
        finish_clear(gl, job);
    }
    glReadPixels(0, 0, numbers.width, numbers.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
}

// The light of the picture just drawn, `share` of it added to `linear`; the depths there are the
// nearest ones of what has any alpha (a floor fades away), as OpenGL stores them.
void add_linear(GlObjects& gl, const DrawJob& job, int which, const SamplePlace& place, float share,
                std::span<float> linear)
{
    const int samples = samples_along(job);
    const int width = job.numbers.width * samples, height = job.numbers.height * samples;
    bind(gl.layer.framebuffer, gl.layer.pixels);
    draw_batches(gl, job, samples, which, place);  // light is drawn by the stencil that these leave
    draw_linear_light(gl, job, job.numbers.linear);
    std::vector<float> light(4 * std::size_t(width) * std::size_t(height));
    std::vector<float> stored(light.size() / 4);
    glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, stored.data());
    if (has_edges(job)) draw_edges(gl, job, gl.light_pass, gl.light, job.numbers.linear);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, light.data());

    const std::size_t across = std::size_t(job.numbers.width), per = std::size_t(samples);
    const auto depths = linear.last(linear.size() / 5);
    share /= float(samples * samples);
    for (std::size_t i = 0; i < stored.size(); ++i) {
        const std::size_t to = i / (across * per) / per * across + i % (across * per) / per;
        for (std::size_t c = 0; c < 4; ++c) linear[4 * to + c] += share * light[4 * i + c];
        if (light[4 * i + 3] > 0) depths[to] = std::max(depths[to], stored[i]);
    }
}

// As OpenGL stores depths to metres; see view_depth() in stored.glsl.
void to_metres(const FrameNumbers& f, std::span<float> depths)
{
    const float near = f.eye[3], far = f.corner[3], scale = f.units[3];
    for (float& d : depths) {
        d = d > 0 ? far / (1 + d * (far - near) / near) / scale : nothing_there;
    }
}

// The mean of several pictures: of their light, and of the brightness in their alpha.
void draw_mean(GlObjects& gl, const DrawJob& job, int pictures, const Pixels& to)
{
    const std::size_t bytes = 4 * std::size_t(job.numbers.width) * std::size_t(job.numbers.height);
    const std::span<std::uint8_t> rgba = to.rgba;
    const auto& light = light_of_steps();
    std::vector<float> sum(bytes);
    for (int k = 0; k < pictures; ++k) {
        draw_picture(gl, job, k, in_a_lattice(k), rgba);
        if (!to.linear.empty()) {
            add_linear(gl, job, k, in_a_lattice(k), 1 / float(pictures), to.linear);
        }
        for (std::size_t i = 0; i < bytes; i += 4) {
            for (std::size_t c = i; c < i + 3; ++c) sum[c] += light[rgba[c]];
            sum[i + 3] += float(rgba[i + 3]);
        }
    }
    const float share = 1 / float(pictures);
    for (std::size_t i = 0; i < bytes; i += 4) {
        for (std::size_t c = i; c < i + 3; ++c) rgba[c] = step_of_light(share * sum[c]);
        rgba[i + 3] = static_cast<std::uint8_t>(std::lround(share * sum[i + 3]));
    }
}

}  // namespace

void Renderer::draw(const DrawJob& job, const Pixels& to)
{
    const GlContext::Current current(context_);
    GlObjects& gl = *gl_;
    const PictureNumbers& numbers = job.numbers;
    upload(gl, job);
    take_textures(gl.textures, job);
    set_numbers(gl, job, 1, {});
    draw_shadow(gl, job);
    std::fill(to.linear.begin(), to.linear.end(), 0.0f);
    if (numbers.pictures > 1) {
        draw_mean(gl, job, numbers.pictures, to);
    } else {
        const int which = numbers.only;
        const SamplePlace place = which < 0 ? SamplePlace{} : in_a_lattice(which);
        draw_picture(gl, job, which, place, to.rgba);
        if (!to.linear.empty()) add_linear(gl, job, which, place, 1, to.linear);
    }
    if (!to.linear.empty()) to_metres(numbers.frame, to.linear.last(to.linear.size() / 5));
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        throw std::runtime_error("OpenGL reports error " + std::to_string(error) +
                                 " for a picture of " + std::to_string(numbers.width) + " x " +
                                 std::to_string(numbers.height));
    }
}

}  // namespace render
