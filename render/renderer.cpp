#include "render/renderer.hpp"

#include "render/shaders.hpp"
#include "render/smooth_edges.hpp"

#include <glad/gl.h>

#include <cmath>
#include <stdexcept>

namespace render {
namespace {

using Vec4f = Eigen::Vector4f;

// As in shaders/frame.glsl.
struct FrameNumbers {
    Eigen::Matrix4f clip_from_stage, shadow_from_stage;
    Vec4f units, eye, corner, across, down, to_light, light, sky, bounce, backdrop_top,
        backdrop_horizon, floor_colour, shadow_size;
};
static_assert(sizeof(FrameNumbers) == (2 * 16 + 13 * 4) * sizeof(float));

Vec4f with(const Vec3f& v, float fourth)
{
    return {v[0], v[1], v[2], fourth};
}

FrameNumbers numbers_of(const DrawList& list, const Look& look, int samples)
{
    FrameNumbers f;
    const View& view = list.view;
    f.clip_from_stage = view.clip_from_stage;
    f.shadow_from_stage =
        list.shadow.width > 0 ? list.shadow.from_stage : Eigen::Matrix4f::Zero().eval();
    f.units = with(list.units.centre.cast<float>(), float(list.units.scale));
    f.eye = with(view.eye, view.near);
    f.corner = with(view.corner, view.far);
    f.across = with(view.across, float(look.width));
    f.down = with(view.down, float(look.height));
    f.to_light = with(list.to_light, list.shadow.width > 0 ? 1 : 0);
    f.light = with(look.light, list.shadow.texel);
    f.sky = with(look.sky, list.ground ? 1 : 0);
    f.bounce = with(look.bounce, list.ground.value_or(0));
    f.backdrop_top = with(look.backdrop_top, look.grid ? list.grid_spacing : 0);
    f.backdrop_horizon = with(look.backdrop_horizon, 0);
    f.floor_colour = with(look.floor, float(samples));
    const double period = 10.0 * list.grid_spacing;
    const auto on_grid = [&](double centre) {
        return period > 0 ? float(std::remainder(centre * list.units.scale, period)) : 0;
    };
    f.shadow_size = {float(list.shadow.width), float(list.shadow.height),
                     on_grid(list.units.centre.x()), on_grid(list.units.centre.z())};
    return f;
}

GLuint compiled(GLenum stage, const std::string& text, const std::string& name)
{
    const GLuint shader = glCreateShader(stage);
    const char* source = text.c_str();
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    GLint fine = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &fine);
    if (!fine) {
        std::array<char, 2048> log{};
        glGetShaderInfoLog(shader, GLsizei(log.size()), nullptr, log.data());
        throw std::runtime_error("this OpenGL does not compile render/shaders/" + name + ": " +
                                 log.data());
    }
    return shader;
}

// The files of each stage, one after the other behind the frame's numbers.
GLuint program(const std::vector<std::string>& vertex, const std::vector<std::string>& fragment,
               const std::string& define = "")
{
    const GLuint made = glCreateProgram();
    const auto attach = [&](GLenum stage, const std::vector<std::string>& files) {
        std::string text(shader_text("frame.glsl"));
        text += define;
        for (const std::string& file : files) text += shader_text(file);
        const GLuint shader = compiled(stage, text, files.back());
        glAttachShader(made, shader);
        glDeleteShader(shader);
    };
    attach(GL_VERTEX_SHADER, vertex);
    attach(GL_FRAGMENT_SHADER, fragment);
    glLinkProgram(made);
    GLint fine = 0;
    glGetProgramiv(made, GL_LINK_STATUS, &fine);
    if (!fine) throw std::runtime_error("this OpenGL does not link " + fragment.back());
    return made;
}

// A texture of one size, made anew when another is wanted.
struct Target {
    GLenum format = 0;
    GLuint name = 0;
    int width = 0, height = 0;

    // True when it is another texture than before.
    bool fit(int w, int h)
    {
        if (name && w == width && h == height) return false;
        glDeleteTextures(1, &name);
        glCreateTextures(GL_TEXTURE_2D, 1, &name);
        glTextureStorage2D(name, 1, format, w, h);
        glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
        filter(GL_NEAREST);
        width = w;
        height = h;
        return true;
    }
    void filter(GLenum how) const
    {
        glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GLint(how));
        glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GLint(how));
    }
};

enum Unit : GLuint { unit_first, unit_depths, unit_shadow, unit_maps };

// What the stencil says of a pixel.
enum Stencil : GLint { is_backdrop, is_object, is_floor, is_uneven };

constexpr int map_count = 3;

}  // namespace

// What lies in each pixel: the result of the first pass.
struct Layer {
    Target pixels{GL_RG32UI}, depths{GL_DEPTH32F_STENCIL8};
    GLuint framebuffer = 0;

    void fit(int width, int height)
    {
        if (!framebuffer) glCreateFramebuffers(1, &framebuffer);
        if (!pixels.fit(width, height)) return;
        depths.fit(width, height);
        glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, pixels.name, 0);
        glNamedFramebufferTexture(framebuffer, GL_DEPTH_STENCIL_ATTACHMENT, depths.name, 0);
    }
};

// Everything that lives in the context; freed with it.
struct Renderer::Gl {
    GLuint surface, object, floor_lit, floor_shadowed, backdrop, uneven, edges, clear, finish,
        shadow, balls, balls_shadow;
    GLuint vertex_array, vertices, indices, frame;
    GLuint light_pass, finish_pass, shadow_pass;
    Layer layer, fine;  // `fine` has twice the width and height, for samples
    Target light{GL_RGBA16F}, picture{GL_RGBA8}, shadow_map{GL_DEPTH_COMPONENT32F}, maps{GL_RGBA8};

    Gl();
    void upload(const DrawList& list);
    void set_numbers(const DrawList& list, const Look& look, int samples) const;
    void draw_shadow(const DrawList& list);
    void draw_batches(const DrawList& list, Layer& into, int width, int height, int samples);
    void draw_light(const DrawList& list, bool linear);
    void draw_edges(const DrawList& list, const Look& look);
    void draw_clear(const DrawList& list);
    void fill_marked(GLuint mark, GLuint with_program) const;
    void fill_screen(GLuint with_program) const;
    static void bind(GLuint framebuffer, const Target& target);
};

Renderer::Gl::Gl()
{
    const std::vector<std::string> screen{"screen.vert"};
    const auto lit = [](std::string file) {
        return std::vector<std::string>{"shade.glsl", "stored.glsl", std::move(file)};
    };
    surface = program({"surface.vert"}, {"pack.glsl", "surface.frag"});
    object = program(screen, lit("object.frag"), "#define READS 2\n");
    floor_lit =
        program({"floor.vert"}, lit("floor.frag"), "#define READS 3\n#define IN_SHADOW 0\n");
    floor_shadowed =
        program({"floor.vert"}, lit("floor.frag"), "#define READS 3\n#define IN_SHADOW 1\n");
    backdrop = program(screen, lit("backdrop.frag"), "#define READS 2\n");
    uneven = program(screen, {"uneven.frag"});
    edges = program(screen, lit("edges.frag"), "#define READS 2\n");
    clear = program({"surface.vert"}, lit("clear.frag"), "#define READS 2\n");
    finish = program(screen, lit("finish.frag"), "#define READS 2\n");
    shadow = program({"shadow.vert"}, {"shadow.frag"});
    balls = program({"balls.vert"}, {"pack.glsl", "balls.frag"});
    balls_shadow = program({"balls.vert"}, {"balls_shadow.frag"});

    for (GLuint* name : {&light_pass, &finish_pass, &shadow_pass}) {
        glCreateFramebuffers(1, name);
    }
    glNamedFramebufferDrawBuffer(shadow_pass, GL_NONE);

    glCreateVertexArrays(1, &vertex_array);
    glCreateBuffers(1, &vertices);
    glCreateBuffers(1, &indices);
    glCreateBuffers(1, &frame);
    glVertexArrayVertexBuffer(vertex_array, 0, vertices, 0, sizeof(Vertex));
    glVertexArrayElementBuffer(vertex_array, indices);
    const auto attribute = [&](GLuint place, GLint count, GLenum type, bool unit, std::size_t at) {
        glEnableVertexArrayAttrib(vertex_array, place);
        glVertexArrayAttribFormat(vertex_array, place, count, type, unit, GLuint(at));
        glVertexArrayAttribBinding(vertex_array, place, 0);
    };
    attribute(0, 3, GL_FLOAT, false, offsetof(Vertex, position));
    attribute(1, 2, GL_SHORT, true, offsetof(Vertex, normal));
    attribute(2, 4, GL_UNSIGNED_BYTE, true, offsetof(Vertex, colour));
    attribute(3, 4, GL_UNSIGNED_BYTE, true, offsetof(Vertex, material));
    attribute(4, 1, GL_FLOAT, false, offsetof(Vertex, value));
    glBindVertexArray(vertex_array);

    constexpr int steps = 256;
    std::vector<std::uint8_t> texels;
    for (int map = 0; map < map_count; ++map) {
        for (int i = 0; i < steps; ++i) {
            const Vec3f c = linear_from_srgb(colour_at(ColourMap(map), float(i) / (steps - 1)));
            for (int k = 0; k < 3; ++k) {
                texels.push_back(std::uint8_t(std::lround(255 * std::sqrt(c[k]))));
            }
            texels.push_back(255);
        }
    }
    maps.fit(steps, map_count);
    maps.filter(GL_LINEAR);
    glTextureSubImage2D(maps.name, 0, 0, 0, steps, map_count, GL_RGBA, GL_UNSIGNED_BYTE,
                        texels.data());

    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glFrontFace(GL_CW);  // the picture's first row is the framebuffer's first: it is mirrored
    glEnable(GL_PROGRAM_POINT_SIZE);
    glPointParameteri(GL_POINT_SPRITE_COORD_ORIGIN, GL_LOWER_LEFT);
    glDisable(GL_DITHER);
}

void Renderer::Gl::bind(GLuint framebuffer, const Target& target)
{
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, target.width, target.height);
}

void Renderer::Gl::fill_screen(GLuint with_program) const
{
    glUseProgram(with_program);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Renderer::Gl::upload(const DrawList& list)
{
    const auto fill = [](GLuint buffer, const auto& data) {
        glNamedBufferData(buffer, GLsizeiptr(data.size() * sizeof(data[0])), data.data(),
                          GL_STREAM_DRAW);
    };
    fill(vertices, list.vertices);
    fill(indices, list.indices);
}

void Renderer::Gl::set_numbers(const DrawList& list, const Look& look, int samples) const
{
    const FrameNumbers numbers = numbers_of(list, look, samples);
    glNamedBufferData(frame, sizeof(numbers), &numbers, GL_STREAM_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame);
}

static const void* at_index(std::uint32_t i)
{
    return reinterpret_cast<const void*>(std::uintptr_t{i} * sizeof(std::uint32_t));
}

void Renderer::Gl::draw_shadow(const DrawList& list)
{
    const ShadowMap& map = list.shadow;
    if (shadow_map.fit(std::max(map.width, 1), std::max(map.height, 1))) {
        glTextureParameteri(shadow_map.name, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glTextureParameteri(shadow_map.name, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
        glNamedFramebufferTexture(shadow_pass, GL_DEPTH_ATTACHMENT, shadow_map.name, 0);
    }
    if (map.width == 0) return;
    bind(shadow_pass, shadow_map);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glClearDepth(1);
    glClear(GL_DEPTH_BUFFER_BIT);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 0);
    for (const auto* batches : {&list.opaque, &list.clear}) {
        for (const Batch& batch : *batches) {
            if (!batch.shadow || batch.shape == Batch::Shape::lines) continue;
            const bool round = batch.shape == Batch::Shape::balls;
            glUseProgram(round ? balls_shadow : shadow);
            if (round) glUniform1i(1, 1);
            glDrawElements(round ? GL_POINTS : GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT,
                           at_index(batch.first));
        }
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
}

void Renderer::Gl::draw_batches(const DrawList& list, Layer& into, int width, int height,
                                int samples)
{
    into.fit(width, height);
    bind(into.framebuffer, into.pixels);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glClearDepth(0);
    glClearStencil(is_backdrop);
    // What the pixels hold matters only where something was drawn.
    glClear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, is_object, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glBindTextureUnit(unit_maps, maps.name);
    for (const Batch& batch : list.opaque) {
        GLenum mode = GL_TRIANGLES;
        if (batch.shape == Batch::Shape::balls) {
            mode = GL_POINTS;
            glUseProgram(balls);
            glUniform1f(0, batch.size);
            glUniform1i(1, 0);
        } else {
            const bool lines = batch.shape == Batch::Shape::lines;
            if (lines) {
                mode = GL_LINES;
                glLineWidth(std::max(1.0f, batch.size * float(samples)));
            }
            glUseProgram(surface);
            glUniform1i(5, lines);
            glUniform1i(3, batch.mapped);
            glUniform1f(4, (float(batch.map) + 0.5f) / map_count);
        }
        glDrawElements(mode, GLsizei(batch.count), GL_UNSIGNED_INT, at_index(batch.first));
    }
    glDisable(GL_STENCIL_TEST);
}

// Light for what `layer` holds, into the bound framebuffer, which has the layer's depth and
// stencil. The stencil is tested before a pixel is shaded: each shader runs only where it is
// needed.
void Renderer::Gl::draw_light(const DrawList& list, bool linear)
{
    for (const GLuint p : {object, floor_lit, floor_shadowed, backdrop}) {
        glProgramUniform1i(p, 0, linear);
    }
    glEnable(GL_STENCIL_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    const auto draw_floor = [](GLuint with_program, const std::vector<Vec3f>& corners) {
        if (corners.empty()) return;
        glUseProgram(with_program);
        glUniform3fv(1, 4, corners[0].data());
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    };
    glStencilFunc(GL_ALWAYS, is_floor, 0xff);
    draw_floor(floor_shadowed, list.shadowed_floor);
    glStencilFunc(GL_NOTEQUAL, is_floor, 0xff);  // depths of the two differ by rounding
    draw_floor(floor_lit, list.floor);

    glDisable(GL_DEPTH_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_EQUAL, is_backdrop, 0xff);
    fill_screen(backdrop);
    // Depths are read while they are attached, though not written.
    glTextureBarrier();
    glBindTextureUnit(unit_first, layer.pixels.name);
    glBindTextureUnit(unit_depths, layer.depths.name);
    glStencilFunc(GL_EQUAL, is_object, 0xff);
    fill_screen(object);
    glDisable(GL_STENCIL_TEST);
}

// Where the four samples of a pixel do not agree, each gets its own light.
void Renderer::Gl::draw_edges(const DrawList& list, const Look& look)
{
    set_numbers(list, look, 2);
    draw_batches(list, fine, 2 * look.width, 2 * look.height, 2);
    set_numbers(list, look, 1);
    bind(finish_pass, picture);
    glBindTextureUnit(unit_first, fine.pixels.name);
    glBindTextureUnit(unit_depths, fine.depths.name);
    fill_marked(uneven, edges);
}

// Runs `with_program` on those pixels only that `mark` does not discard.
void Renderer::Gl::fill_marked(GLuint mark, GLuint with_program) const
{
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_STENCIL_TEST);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    glStencilFunc(GL_ALWAYS, is_uneven, 0xff);
    fill_screen(mark);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glStencilFunc(GL_EQUAL, is_uneven, 0xff);
    fill_screen(with_program);
    glDisable(GL_STENCIL_TEST);
}

void Renderer::Gl::draw_clear(const DrawList& list)
{
    glUseProgram(clear);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    for (const Batch& batch : list.clear) {
        glUniform1i(5, 0);
        glUniform1i(3, batch.mapped);
        glUniform1f(4, (float(batch.map) + 0.5f) / map_count);
        glDrawElements(GL_TRIANGLES, GLsizei(batch.count), GL_UNSIGNED_INT, at_index(batch.first));
    }
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
}

Renderer::Renderer()
{
    const GlContext::Current current(context_);
    gl_ = std::make_unique<Gl>();
}

Renderer::~Renderer() = default;

Image Renderer::draw(const DrawList& list, const Look& look)
{
    const GlContext::Current current(context_);
    Gl& gl = *gl_;
    // Transparent things lie over whatever there is: then every pixel has all its samples.
    const bool samples4 = look.antialias == Antialias::samples4;
    const int samples = samples4 && !list.clear.empty() ? 2 : 1;
    const int width = look.width * samples, height = look.height * samples;
    gl.upload(list);
    gl.set_numbers(list, look, samples);
    gl.draw_shadow(list);
    gl.draw_batches(list, gl.layer, width, height, samples);

    glBindTextureUnit(unit_shadow, gl.shadow_map.name);
    if (gl.picture.fit(look.width, look.height)) {
        gl.picture.filter(GL_LINEAR);
        glNamedFramebufferTexture(gl.finish_pass, GL_COLOR_ATTACHMENT0, gl.picture.name, 0);
    }
    if (list.clear.empty()) {
        glNamedFramebufferTexture(gl.finish_pass, GL_DEPTH_STENCIL_ATTACHMENT, gl.layer.depths.name,
                                  0);
        gl.bind(gl.finish_pass, gl.picture);
        gl.draw_light(list, false);
        if (samples4) gl.draw_edges(list, look);
    } else {
        if (gl.light.fit(width, height)) {
            glNamedFramebufferTexture(gl.light_pass, GL_COLOR_ATTACHMENT0, gl.light.name, 0);
        }
        glNamedFramebufferTexture(gl.light_pass, GL_DEPTH_STENCIL_ATTACHMENT, gl.layer.depths.name,
                                  0);
        gl.bind(gl.light_pass, gl.light);
        gl.draw_light(list, true);
        gl.draw_clear(list);
        glNamedFramebufferTexture(gl.finish_pass, GL_DEPTH_STENCIL_ATTACHMENT, 0, 0);
        gl.bind(gl.finish_pass, gl.picture);
        glBindTextureUnit(unit_first, gl.light.name);
        glDisable(GL_DEPTH_TEST);
        gl.fill_screen(gl.finish);
    }

    Image image{look.width, look.height, {}};
    image.rgba.resize(std::size_t(look.width) * std::size_t(look.height) * 4);
    glReadPixels(0, 0, look.width, look.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    if (look.antialias == Antialias::fxaa) smooth_edges(image);
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        throw std::runtime_error("OpenGL reports error " + std::to_string(error) +
                                 " for a picture of " + std::to_string(look.width) + " x " +
                                 std::to_string(look.height));
    }
    return image;
}

}  // namespace render
