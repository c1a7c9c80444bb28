#pragma once

// What lives in an OpenGL context: compiled shaders, buffers, framebuffers and textures. All of it
// is made once and freed with the context; only textures are made anew, when a picture has another
// size.

#include "render/draw_list.hpp"
#include "render/gl_textures.hpp"
#include "render/look.hpp"
#include "render/sample_places.hpp"

#include <glad/gl.h>

namespace render {

inline constexpr int map_count = 3;  // of ColourMap

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

// What lies at each of the samples of a pixel: one layer for each.
struct SampleLayers {
    GLuint pixels = 0, depths = 0;  // texture arrays
    std::array<GLuint, layer_samples> framebuffers{};
    int width = 0, height = 0;

    void fit(int w, int h);
};

// Those that draw depths into a shadow map.
struct ShadowPrograms {
    GLuint plain = 0, textured = 0, clear = 0, clear_textured = 0, balls = 0;
};

// What draw_clear() sorts layer by layer: the depths of two neighbours, the light of the farther
// one, and of all so far.
struct Peel {
    std::array<Target, 2> depths{Target{GL_DEPTH32F_STENCIL8}, Target{GL_DEPTH32F_STENCIL8}};
    Target layer{GL_RGBA16F}, sum{GL_RGBA16F};
    std::array<GLuint, 2> depth_passes{};  // without colour
    GLuint layer_pass = 0, sum_pass = 0;   // the first among the depths `opaque`
    GLuint any = 0;                        // a query

    void fit(int width, int height, const Target& opaque);
};

// One for each kind of pass that knows nothing of light.
struct GlPrograms {
    GLuint surface, uneven, balls, soften, surface_textured, traced, traced_shadow, laid;
    ShadowPrograms shadow, far_shadow;  // the second compiled when first used
};

// Those that light what is seen, in one style.
struct LitPrograms {
    GLuint object = 0, floor_lit = 0, floor_shadowed = 0, backdrop = 0, edges = 0, clear = 0,
           clear_textured = 0, finish = 0, seen = 0;
    GLuint peel = 0, peel_textured = 0;  // of depths alone, where things are peeled
};

// What they are compiled for.
struct LitKind {
    Style style = Style::plain;
    bool soft = false, glass = false, grid = false, far = false, peel = false;
};

struct GlObjects {
    GlPrograms programs;
    std::array<LitPrograms, 32 * style_count> lit;  // compiled when first used
    GLuint plain_depths, smooth_depths;             // samplers of the shadow map
    std::array<GLuint, 2> seen_pass;
    std::array<Target, 2> seen{Target{GL_RGBA32F}, Target{GL_RGBA32F}};  // half as wide and high
    GLuint vertex_array, textured_array;                                 // the second has uvs too
    GLuint vertices, uvs, indices, frame;
    GLuint traced, traced_samples, traced_shadow;
    GlTextures textures;
    GLuint light_pass, finish_pass, shadow_pass, far_pass;
    Layer layer;
    SampleLayers fine;
    Peel peel;
    Target light{GL_RGBA16F}, picture{GL_RGBA8}, shadow_map{GL_DEPTH_COMPONENT32F},
        far_map{GL_DEPTH_COMPONENT32F}, maps{GL_RGBA8};
};

// In the current context, whose fixed state is set as well. Throws std::runtime_error where a
// shader does not compile.
GlObjects make_gl_objects();

// Compiles them where they are not yet. Throws as make_gl_objects does.
const ShadowPrograms& far_shadow_programs(GlObjects& gl);
const LitPrograms& lit_programs(GlObjects& gl, const PictureNumbers& numbers);

}  // namespace render
