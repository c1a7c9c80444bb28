#include "render/renderer.hpp"

#include "render/shaders.hpp"

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
GLuint program(std::vector<std::string> vertex, std::vector<std::string> fragment,
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
        for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) {
            glTextureParameteri(name, wrap, GL_CLAMP_TO_EDGE);
        }
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

constexpr int map_count = 3;

}  // namespace

// Everything that lives in the context; freed with it.
struct Renderer::Gl {
    GLuint surface, lit, lit_samples, clear, finish, shadow, balls, balls_shadow, fxaa;
    GLuint vertex_array, vertices, indices, frame;
    GLuint first_pass, light_pass, finish_pass, last_pass, shadow_pass;
    Target pixels{GL_RG32UI}, depths{GL_DEPTH_COMPONENT32F}, light{GL_RGBA16F}, picture{GL_RGBA8},
        smoothed{GL_RGBA8}, shadow_map{GL_DEPTH_COMPONENT32F}, maps{GL_RGBA8};

    Gl();
    void upload(const DrawList& list, const FrameNumbers& numbers);
    void draw_shadow(const DrawList& list);
    void draw_batches(const DrawList& list, int width, int height, int samples);
    void draw_clear(const DrawList& list);
    void fill_screen(GLuint with_program) const;
    static void bind(GLuint framebuffer, const Target& target);
};

Renderer::Gl::Gl()
{
    surface = program({"surface.vert"}, {"pack.glsl", "surface.frag"});
    lit = program({"screen.vert"}, {"shade.glsl", "light.frag"}, "#define SAMPLES 1\n");
    lit_samples = program({"screen.vert"}, {"shade.glsl", "light.frag"}, "#define SAMPLES 4\n");
    clear = program({"surface.vert"}, {"shade.glsl", "clear.frag"});
    finish = program({"screen.vert"}, {"shade.glsl", "finish.frag"});
    shadow = program({"shadow.vert"}, {"shadow.frag"});
    balls = program({"balls.vert"}, {"pack.glsl", "balls.frag"});
    balls_shadow = program({"balls.vert"}, {"balls_shadow.frag"});
    fxaa = program({"screen.vert"}, {"fxaa.frag"});

    for (GLuint* name : {&first_pass, &light_pass, &finish_pass, &last_pass, &shadow_pass}) {
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
            const Vec3f c = colour_at(ColourMap(map), float(i) / (steps - 1));
            for (int k = 0; k < 3; ++k) texels.push_back(std::uint8_t(std::lround(255 * c[k])));
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
    glDisable(GL_DEPTH_TEST);
    glUseProgram(with_program);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Renderer::Gl::upload(const DrawList& list, const FrameNumbers& numbers)
{
    const auto fill = [](GLuint buffer, const auto& data) {
        glNamedBufferData(buffer, GLsizeiptr(data.size() * sizeof(data[0])), data.data(),
                          GL_STREAM_DRAW);
    };
    fill(vertices, list.vertices);
    fill(indices, list.indices);
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

void Renderer::Gl::draw_batches(const DrawList& list, int width, int height, int samples)
{
    if (pixels.fit(width, height)) {
        depths.fit(width, height);
        glNamedFramebufferTexture(first_pass, GL_COLOR_ATTACHMENT0, pixels.name, 0);
        glNamedFramebufferTexture(first_pass, GL_DEPTH_ATTACHMENT, depths.name, 0);
    }
    bind(first_pass, pixels);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glClearDepth(0);
    glClear(GL_DEPTH_BUFFER_BIT);  // what the pixels hold matters only where something was drawn
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
            glUniform1i(0, lines);
            glUniform1i(1, batch.mapped);
            glUniform1f(2, (float(batch.map) + 0.5f) / map_count);
        }
        glDrawElements(mode, GLsizei(batch.count), GL_UNSIGNED_INT, at_index(batch.first));
    }
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
        glUniform1i(0, 0);
        glUniform1i(1, batch.mapped);
        glUniform1f(2, (float(batch.map) + 0.5f) / map_count);
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
    const int samples = look.antialias == Antialias::samples4 ? 2 : 1;
    const int width = look.width * samples, height = look.height * samples;
    gl.upload(list, numbers_of(list, look, samples));
    gl.draw_shadow(list);
    gl.draw_batches(list, width, height, samples);

    glBindTextureUnit(unit_first, gl.pixels.name);
    glBindTextureUnit(unit_depths, gl.depths.name);
    glBindTextureUnit(unit_shadow, gl.shadow_map.name);
    if (gl.picture.fit(look.width, look.height)) {
        gl.picture.filter(GL_LINEAR);
        glNamedFramebufferTexture(gl.finish_pass, GL_COLOR_ATTACHMENT0, gl.picture.name, 0);
    }
    if (list.clear.empty()) {
        gl.bind(gl.finish_pass, gl.picture);
        const GLuint lighting = samples == 2 ? gl.lit_samples : gl.lit;
        glProgramUniform1i(lighting, 0, 0);
        gl.fill_screen(lighting);
    } else {
        if (gl.light.fit(width, height)) {
            glNamedFramebufferTexture(gl.light_pass, GL_COLOR_ATTACHMENT0, gl.light.name, 0);
        }
        glNamedFramebufferTexture(gl.light_pass, GL_DEPTH_ATTACHMENT, 0, 0);
        gl.bind(gl.light_pass, gl.light);
        glProgramUniform1i(gl.lit, 0, 1);
        gl.fill_screen(gl.lit);
        glNamedFramebufferTexture(gl.light_pass, GL_DEPTH_ATTACHMENT, gl.depths.name, 0);
        gl.draw_clear(list);
        gl.bind(gl.finish_pass, gl.picture);
        glBindTextureUnit(unit_first, gl.light.name);
        gl.fill_screen(gl.finish);
    }
    if (look.antialias == Antialias::fxaa) {
        if (gl.smoothed.fit(look.width, look.height)) {
            glNamedFramebufferTexture(gl.last_pass, GL_COLOR_ATTACHMENT0, gl.smoothed.name, 0);
        }
        gl.bind(gl.last_pass, gl.smoothed);
        glBindTextureUnit(unit_first, gl.picture.name);
        gl.fill_screen(gl.fxaa);
    }

    Image image{look.width, look.height, {}};
    image.rgba.resize(std::size_t(look.width) * std::size_t(look.height) * 4);
    glReadPixels(0, 0, look.width, look.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        throw std::runtime_error("OpenGL reports error " + std::to_string(error) +
                                 " for a picture of " + std::to_string(look.width) + " x " +
                                 std::to_string(look.height));
    }
    return image;
}

}  // namespace render
