// stb is told to be private to this file: others have their own.
#include "geometry/base/picture_file.hpp"

#include <fmt/format.h>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#define STBI_MAX_DIMENSIONS 100000
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <limits>
#include <memory>
#include <stdexcept>

namespace geometry {
namespace {

const stbi_uc* data_of(std::string_view file)
{
    return reinterpret_cast<const stbi_uc*>(file.data());
}

}  // namespace

PictureSize picture_size(std::string_view file)
{
    constexpr double most_pixels = 1e8;
    int width = 0, height = 0, channels = 0;
    if (file.size() > std::size_t(std::numeric_limits<int>::max()) ||
        !stbi_info_from_memory(data_of(file), int(file.size()), &width, &height, &channels)) {
        throw std::runtime_error("is not a picture that can be read");
    }
    if (double(width) * height > most_pixels) {
        throw std::runtime_error(
            fmt::format("has {} x {} pixels, more than a hundred million", width, height));
    }
    return {width, height};
}

Picture decode_picture(std::string_view file)
{
    picture_size(file);
    Picture picture;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(data_of(file), int(file.size()), &picture.width, &picture.height,
                              &channels, 4),
        [](void* p) { stbi_image_free(p); });
    if (!pixels) {
        const char* const why = stbi_failure_reason();
        throw std::runtime_error(fmt::format("is damaged ({})", why ? why : "no reason known"));
    }
    const std::size_t bytes = 4 * std::size_t(picture.width) * std::size_t(picture.height);
    picture.rgba.assign(pixels.get(), pixels.get() + bytes);
    return picture;
}

std::string encode_png(const Picture& picture)
{
    std::string bytes;
    const auto append = [](void* to, void* from, int size) {
        static_cast<std::string*>(to)->append(static_cast<const char*>(from), std::size_t(size));
    };
    if (!stbi_write_png_to_func(append, &bytes, picture.width, picture.height, 4,
                                picture.rgba.data(), 4 * picture.width)) {
        throw std::runtime_error("a picture cannot be written as PNG");
    }
    return bytes;
}

}  // namespace geometry
