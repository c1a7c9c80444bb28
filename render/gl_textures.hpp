#pragma once

// The textures of an OpenGL context: those of a picture stay until one is drawn without them.

#include "render/draw_job.hpp"

#include <glad/gl.h>

#include <map>

namespace render {

struct GlTextures {
    std::map<std::uint64_t, GLuint> names;  // by digest
    GLuint sampler = 0;                     // how the one being drawn repeats
};

// Makes those of the job that are not there yet, and forgets all others. Throws std::runtime_error
// for one that is neither there nor given.
void take_textures(GlTextures& textures, const DrawJob& job);

// What a texture is laid on for: the picture, a shadow map, in which what is blended casts the
// shadow of its more opaque half, or depths of all that is there at all: of clear things, or of
// shadows that are as light as these are clear.
enum class LaidFor { picture, shadow, depth };

// Binds what `cover` has to `unit` and, a normal map, to the one after it, and says to the program
// that is in use how to lay it on.
void use_cover(const GlTextures& textures, const DrawJob& job, const Cover& cover, GLuint unit,
               LaidFor laid_for);

}  // namespace render
