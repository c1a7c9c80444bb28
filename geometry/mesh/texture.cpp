#include "geometry/mesh/texture.hpp"

#include "geometry/base/vec.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <stdexcept>

namespace geometry {

struct Texture::Read {
    std::once_flag once;
    Picture picture;
};

namespace {

// Eight bytes at a time; every step can be undone, so files that differ in one word differ here.
std::uint64_t digest_of(const std::string& file)
{
    std::uint64_t h = file.size();
    for (std::size_t i = 0; i < file.size(); i += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, file.data() + i, std::min<std::size_t>(8, file.size() - i));
        h = (h ^ word) * 0x9e3779b97f4a7c15u;
        h ^= h >> 29;
    }
    return h * 0xbf58476d1ce4e5b9u;
}

}  // namespace

Texture::Texture(Source source)
    : source_(std::move(source)), size_(picture_size(source_.file)),
      digest_(digest_of(source_.file)), read_(std::make_shared<Read>())
{}

const Picture& Texture::picture() const
{
    static const Picture none;
    if (!read_) return none;
    std::call_once(read_->once, [&] { read_->picture = decode_picture(source_.file); });
    return read_->picture;
}

TextureUse::Alpha alpha_of(const Picture& picture)
{
    std::size_t clear = 0, between = 0;
    const std::size_t count = picture.rgba.size() / 4;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t a = picture.rgba[4 * i + 3];
        clear += a < 16;
        between += a >= 16 && a < 240;
    }
    if (clear + between == 0) return TextureUse::Alpha::ignored;
    // The rims of leaves are soft: a tenth of what is there may be.
    return 10 * between <= count - clear ? TextureUse::Alpha::cutout : TextureUse::Alpha::blended;
}

PictureOf told_by(const Picture& picture)
{
    const std::size_t count = picture.rgba.size() / 4;
    std::size_t grey = 0, normal = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t* const c = &picture.rgba[4 * i];
        const auto [low, high] = std::minmax({c[0], c[1], c[2]});
        grey += high - low <= 8 ? 1 : 0;
        const Vec3f n = Vec3f(float(c[0]), float(c[1]), float(c[2])) / 127.5f - Vec3f::Ones();
        normal += n.z() >= 0 && std::abs(n.norm() - 1) <= 0.2f ? 1 : 0;
    }
    // First: light greys are as long as directions are.
    if (20 * grey >= 19 * count) return PictureOf::heights;
    return 20 * normal >= 19 * count ? PictureOf::normals : PictureOf::anything;
}

std::string media_type(const Texture& texture)
{
    const std::string& file = texture.source().file;
    if (file.starts_with("\x89PNG")) return "image/png";
    if (file.starts_with("\xff\xd8")) return "image/jpeg";
    return file.starts_with("BM") ? "image/bmp" : "image/x-tga";
}

}  // namespace geometry
