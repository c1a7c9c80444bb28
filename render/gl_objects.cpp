#include "render/gl_objects.hpp"

#include "render/shaders.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace render {
namespace {

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

std::vector<std::string> lit_by(std::string file)
{
    return {"near_map.glsl", "shade.glsl",  "octahedral.glsl", "seen_code.glsl", "penumbra.glsl",
            "reach.glsl",    "stored.glsl", "peeled.glsl",     std::move(file)};
}

// What the shaders of light are to know before they are compiled.
// `samples`: of how many in a pixel a shader takes the mean.
std::string lit_words(const LitKind& kind, int reads, int samples = 1)
{
    std::string text;
    for (const char* name : {"STUDIO 0", "CLAY 1", "DIAGRAM 2", "MATCAP 3", "PLAIN 4"}) {
        text += std::string("#define ") + name + '\n';
    }
    const auto define = [&](const char* name, int value) {
        text += std::string("#define ") + name + ' ' + std::to_string(value) + '\n';
    };
    define("STYLE", int(kind.style));
    define("SOFT", kind.soft);
    define("GLASS", kind.glass);
    define("GRID", kind.grid);
    define("FAR", kind.far);
    define("PEEL", kind.peel);
    define("READS", reads);
    define("SAMPLES", samples);
    return text;
}

constexpr const char* textured = "#define TEXTURED\n";

// `words`: what the shaders are to know before.
ShadowPrograms compile_shadow_programs(const std::string& words)
{
    ShadowPrograms p;
    const auto flat = [&](const std::string& more) {
        return program({"shadow.vert"}, {"near_map.glsl", "shadow.frag"}, words + more);
    };
    const std::string clear = "#define CLEAR\n";
    p.plain = flat("");
    p.textured = flat(textured);
    p.clear = flat(clear);
    p.clear_textured = flat(clear + textured);
    p.balls = program({"balls.vert"}, {"near_map.glsl", "balls_shadow.frag"}, words);
    return p;
}

GlPrograms compile_programs()
{
    GlPrograms p{};
    const std::vector<std::string> screen{"screen.vert"};
    p.surface = program({"surface.vert"}, {"octahedral.glsl", "pack.glsl", "surface.frag"});
    p.uneven = program(screen, {"uneven.frag"});
    p.soften = program(screen, {"seen_code.glsl", "soften.frag"});
    p.surface_textured = program(
        {"surface.vert"}, {"octahedral.glsl", "pack.glsl", "bent.glsl", "surface.frag"}, textured);
    p.shadow = compile_shadow_programs("");
    p.balls = program({"balls.vert"}, {"octahedral.glsl", "pack.glsl", "balls.frag"});
    p.traced = program(screen, lit_by("traced.frag"), lit_words({}, 2));
    p.laid = program(screen, {"laid.frag"});
    p.traced_shadow = program(screen, {"traced_shadow.frag"});
    return p;
}

// Where a vertex array finds the members of Vertex, and uvs; see surface.vert.
GLuint vertex_array(const GlObjects& gl, bool with_uvs)
{
    GLuint array = 0;
    glCreateVertexArrays(1, &array);
    glVertexArrayVertexBuffer(array, 0, gl.vertices, 0, sizeof(Vertex));
    glVertexArrayElementBuffer(array, gl.indices);
    const auto attribute = [&](GLuint place, GLint count, GLenum type, bool unit, std::size_t at) {
        glEnableVertexArrayAttrib(array, place);
        glVertexArrayAttribFormat(array, place, count, type, unit, GLuint(at));
        glVertexArrayAttribBinding(array, place, 0);
    };
    attribute(0, 3, GL_FLOAT, false, offsetof(Vertex, position));
    attribute(1, 2, GL_SHORT, true, offsetof(Vertex, normal));
    attribute(2, 4, GL_UNSIGNED_BYTE, true, offsetof(Vertex, colour));
    attribute(3, 4, GL_UNSIGNED_BYTE, true, offsetof(Vertex, material));
    attribute(4, 1, GL_FLOAT, false, offsetof(Vertex, value));
    if (with_uvs) {
        attribute(5, 2, GL_FLOAT, false, 0);
        glVertexArrayVertexBuffer(array, 1, gl.uvs, 0, 2 * sizeof(float));
        glVertexArrayAttribBinding(array, 5, 1);
    }
    return array;
}

// All colour maps in one texture, a row each.
void fill_maps(GlObjects& gl)
{
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
    gl.maps.fit(steps, map_count);
    gl.maps.filter(GL_LINEAR);
    glTextureSubImage2D(gl.maps.name, 0, 0, 0, steps, map_count, GL_RGBA, GL_UNSIGNED_BYTE,
                        texels.data());
}

}  // namespace

GlObjects make_gl_objects()
{
    GlObjects gl{};
    gl.programs = compile_programs();
    for (GLuint* name : {&gl.light_pass, &gl.finish_pass, &gl.shadow_pass, &gl.far_pass}) {
        glCreateFramebuffers(1, name);
    }
    glCreateFramebuffers(2, gl.seen_pass.data());
    glCreateSamplers(1, &gl.plain_depths);
    glCreateSamplers(1, &gl.smooth_depths);
    for (const GLuint name : {gl.plain_depths, gl.smooth_depths}) {
        const GLint how = name == gl.smooth_depths ? GL_LINEAR : GL_NEAREST;
        glSamplerParameteri(name, GL_TEXTURE_MIN_FILTER, how);
        glSamplerParameteri(name, GL_TEXTURE_MAG_FILTER, how);
        glSamplerParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glSamplerParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    glSamplerParameteri(gl.smooth_depths, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glSamplerParameteri(gl.smooth_depths, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glNamedFramebufferDrawBuffer(gl.shadow_pass, GL_NONE);
    glNamedFramebufferDrawBuffer(gl.far_pass, GL_NONE);
    for (GLuint* const buffer : {&gl.vertices, &gl.uvs, &gl.indices, &gl.frame, &gl.traced,
                                 &gl.traced_samples, &gl.traced_shadow}) {
        glCreateBuffers(1, buffer);
    }
    gl.vertex_array = vertex_array(gl, false);
    gl.textured_array = vertex_array(gl, true);
    fill_maps(gl);

    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glFrontFace(GL_CW);  // the picture's first row is the framebuffer's first: it is mirrored
    glEnable(GL_PROGRAM_POINT_SIZE);
    glPointParameteri(GL_POINT_SPRITE_COORD_ORIGIN, GL_LOWER_LEFT);
    glDisable(GL_DITHER);
    return gl;
}

void SampleLayers::fit(int w, int h)
{
    if (pixels && w == width && h == height) return;
    if (!framebuffers[0]) glCreateFramebuffers(layer_samples, framebuffers.data());
    const auto array_of = [&](GLuint& name, GLenum format) {
        glDeleteTextures(1, &name);
        glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
        glTextureStorage3D(name, 1, format, w, h, layer_samples);
        glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    };
    array_of(pixels, GL_RG32UI);
    array_of(depths, GL_DEPTH32F_STENCIL8);
    for (int k = 0; k < layer_samples; ++k) {
        const GLuint framebuffer = framebuffers[std::size_t(k)];
        glNamedFramebufferTextureLayer(framebuffer, GL_COLOR_ATTACHMENT0, pixels, 0, k);
        glNamedFramebufferTextureLayer(framebuffer, GL_DEPTH_STENCIL_ATTACHMENT, depths, 0, k);
    }
    width = w;
    height = h;
}

void Peel::fit(int width, int height, const Target& opaque)
{
    if (!sum_pass) {
        glCreateFramebuffers(1, &sum_pass);
        glCreateFramebuffers(1, &layer_pass);
        glCreateFramebuffers(2, depth_passes.data());
        glCreateQueries(GL_ANY_SAMPLES_PASSED, 1, &any);
        for (const GLuint pass : depth_passes) glNamedFramebufferDrawBuffer(pass, GL_NONE);
    }
    glNamedFramebufferTexture(layer_pass, GL_DEPTH_STENCIL_ATTACHMENT, opaque.name, 0);
    if (!layer.fit(width, height)) return;
    sum.fit(width, height);
    glNamedFramebufferTexture(layer_pass, GL_COLOR_ATTACHMENT0, layer.name, 0);
    glNamedFramebufferTexture(sum_pass, GL_COLOR_ATTACHMENT0, sum.name, 0);
    for (std::size_t k = 0; k < 2; ++k) {
        depths[k].fit(width, height);
        glNamedFramebufferTexture(depth_passes[k], GL_DEPTH_STENCIL_ATTACHMENT, depths[k].name, 0);
    }
}

const ShadowPrograms& far_shadow_programs(GlObjects& gl)
{
    ShadowPrograms& p = gl.programs.far_shadow;
    if (!p.plain) p = compile_shadow_programs("#define BEYOND\n");
    return p;
}

const LitPrograms& lit_programs(GlObjects& gl, const PictureNumbers& numbers)
{
    const bool glass = numbers.frame.backdrop_horizon[3] == 1;
    const LitKind kind{
        numbers.style,         numbers.soft,       glass, numbers.frame.backdrop_top[3] > 0,
        numbers.far_width > 0, numbers.layered > 0};
    LitPrograms& p =
        gl.lit[32 * std::size_t(kind.style) + (kind.peel ? 16 : 0) + (kind.far ? 8 : 0) +
               (kind.soft ? 4 : 0) + (kind.glass ? 2 : 0) + (kind.grid ? 1 : 0)];
    if (p.object) return p;
    const std::vector<std::string> screen{"screen.vert"};
    const std::string in_shadow = "#define IN_SHADOW 1\n", floor_words = lit_words(kind, 3);
    const std::string words = lit_words(kind, 2) + in_shadow;
    p.floor_lit =
        program({"floor.vert"}, lit_by("floor.frag"), floor_words + "#define IN_SHADOW 0\n");
    p.floor_shadowed = program({"floor.vert"}, lit_by("floor.frag"), floor_words + in_shadow);
    p.backdrop = program(screen, lit_by("backdrop.frag"), words);
    p.edges = program(screen, lit_by("edges.frag"), lit_words(kind, 2, 4) + in_shadow);
    p.clear = program({"surface.vert"}, lit_by("clear.frag"), words);
    p.clear_textured = program({"surface.vert"},
                               {"near_map.glsl", "shade.glsl", "octahedral.glsl", "seen_code.glsl",
                                "penumbra.glsl", "reach.glsl", "stored.glsl", "peeled.glsl",
                                "bent.glsl", "clear.frag"},
                               words + textured);
    if (kind.peel) {
        p.peel = program({"surface.vert"}, {"peeled.glsl", "peel.frag"}, words);
        p.peel_textured = program({"surface.vert"}, {"peeled.glsl", "peel.frag"}, words + textured);
    }
    p.finish = program(screen, lit_by("finish.frag"), words);
    if (kind.soft) {
        p.seen = program(screen, lit_by("seen.frag"), lit_words({.glass = kind.glass}, 2));
    }
    p.object = program(screen, lit_by("object.frag"), words);
    return p;
}

}  // namespace render
