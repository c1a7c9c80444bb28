#include "render/gl_textures.hpp"

#include "geometry/base/srgb.hpp"
#include "render/texture_levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace render {
namespace {

// Filters along the direction in which a texture is seen at a slant, where that is known.
constexpr GLenum most_anisotropy = 0x84FE;  // GL_TEXTURE_MAX_ANISOTROPY_EXT

bool has_extension(const char* wanted)
{
    GLint count = 0;
    glGetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; ++i) {
        const auto* const name =
            reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, GLuint(i)));
        if (name && std::strcmp(name, wanted) == 0) return true;
    }
    return false;
}

GLuint make_sampler()
{
    GLuint sampler = 0;
    glCreateSamplers(1, &sampler);
    glSamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    glSamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    if (has_extension("GL_EXT_texture_filter_anisotropic")) {
        // 8 takes twice as long as 1, 2 a quarter longer.
        glSamplerParameterf(sampler, most_anisotropy, 2);
    }
    return sampler;
}

// Display values as square roots of light, as all colours are kept here: the shaders need no
// powers. Filtered as they are, between neighbours; the levels are means of light already.
std::vector<std::uint8_t> roots_of(const TextureLevel& level)
{
    std::array<std::uint8_t, 256> root{};
    for (std::size_t i = 0; i < root.size(); ++i) {
        const float light = geometry::linear_from_srgb(float(i) / 255);
        root[i] = static_cast<std::uint8_t>(255 * std::sqrt(light) + 0.5f);
    }
    std::vector<std::uint8_t> rgba = level.rgba;
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 != 3) rgba[i] = root[rgba[i]];
    }
    return rgba;
}

GLuint make_texture(const JobTexture& from)
{
    if (!from.rgba) throw std::runtime_error("a texture to be drawn with is not there");
    GLint largest = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    const std::vector<TextureLevel> levels =
        texture_levels(from.width, from.height, {from.rgba, from.bytes()},
                       std::min<int>(largest, 8192), from.normals);
    GLuint name = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &name);
    glTextureStorage2D(name, GLsizei(levels.size()), GL_RGBA8, levels[0].width, levels[0].height);
    for (std::size_t i = 0; i < levels.size(); ++i) {
        glTextureSubImage2D(name, GLint(i), 0, 0, levels[i].width, levels[i].height, GL_RGBA,
                            GL_UNSIGNED_BYTE,
                            from.normals ? levels[i].rgba.data() : roots_of(levels[i]).data());
    }
    return name;
}

GLint wrap(geometry::TextureUse::Wrap how)
{
    using Wrap = geometry::TextureUse::Wrap;
    return how == Wrap::repeat  ? GL_REPEAT
           : how == Wrap::clamp ? GL_CLAMP_TO_EDGE
                                : GL_MIRRORED_REPEAT;
}

}  // namespace

void take_textures(GlTextures& textures, const DrawJob& job)
{
    std::map<std::uint64_t, GLuint> old = std::move(textures.names);
    textures.names.clear();
    for (const JobTexture& t : job.textures) {
        auto kept = old.extract(t.digest);
        if (kept) {
            textures.names.insert(std::move(kept));
        } else {
            textures.names.emplace(t.digest, make_texture(t));
        }
    }
    for (const auto& [digest, name] : old) glDeleteTextures(1, &name);
    if (!textures.sampler && !job.textures.empty()) textures.sampler = make_sampler();
}

void use_cover(const GlTextures& textures, const DrawJob& job, const Cover& cover, GLuint unit,
               LaidFor laid_for)
{
    using Alpha = geometry::TextureUse::Alpha;
    const Alpha alpha = cover.use.alpha;
    // A picture that is not used stands for one that is not there.
    const auto name = [&](std::int32_t wanted, std::int32_t otherwise) {
        const std::int32_t i = wanted >= 0 ? wanted : otherwise;
        return textures.names.at(job.textures[std::size_t(i)].digest);
    };
    glBindTextureUnit(unit, name(cover.texture, cover.normals));
    glBindTextureUnit(unit + 1, name(cover.normals, cover.texture));
    for (const GLuint of : {unit, unit + 1}) glBindSampler(of, textures.sampler);
    glSamplerParameteri(textures.sampler, GL_TEXTURE_WRAP_S, wrap(cover.use.u));
    glSamplerParameteri(textures.sampler, GL_TEXTURE_WRAP_T, wrap(cover.use.v));
    float least = alpha == Alpha::cutout ? cover.use.cutoff : 0;
    if (alpha == Alpha::blended && laid_for == LaidFor::shadow) least = 0.5f;
    const bool there = cover.texture >= 0;
    glUniform4f(6, there && cover.colours ? 1.f : 0.f, there ? least : 0,
                there && alpha == Alpha::blended ? 1.f : 0.f, 0);
    if (laid_for == LaidFor::picture) glUniform1f(7, cover.normals >= 0 ? cover.bump : 0);
}

}  // namespace render
