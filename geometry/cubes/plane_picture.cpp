// Pictures by stb_image, which is told to be private to this file: others have their own.
#include "geometry/cubes/plane_picture.hpp"

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
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <fstream>
#include <memory>
#include <stdexcept>

namespace geometry {

PlanePicture read_plane_picture(const std::filesystem::path& path, PictureInk ink)
{
    const auto fail = [&](const std::string& why) {
        throw std::runtime_error(
            fmt::format("{} {}: expected a PNG, JPEG, BMP or TGA picture", path.string(), why));
    };
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) fail("cannot be opened");
    const auto length = std::int64_t(in.tellg());
    if (length < 0 || length > 1'000'000'000) fail("is not a file, or larger than a gigabyte");
    std::string bytes(std::size_t(length), '\0');
    in.seekg(0);
    in.read(bytes.data(), length);
    if (!in) fail("cannot be read");
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    constexpr double most_pixels = 1e8;
    int width = 0, height = 0, channels = 0;
    const int size = int(bytes.size());
    if (!stbi_info_from_memory(data, size, &width, &height, &channels)) {
        fail("is not a picture that can be read");
    }
    if (double(width) * height > most_pixels)
        fail(fmt::format("has {} x {} pixels, more than a hundred million", width, height));
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(data, size, &width, &height, &channels, 4),
        [](void* p) { stbi_image_free(p); });
    if (!pixels)
        fail(fmt::format("is damaged ({})",
                         stbi_failure_reason() ? stbi_failure_reason() : "no reason known"));
    PlanePicture picture{width, height, {}};
    picture.value.resize(std::size_t(width) * std::size_t(height));
    for (std::size_t i = 0; i < picture.value.size(); ++i) {
        const stbi_uc* const p = pixels.get() + 4 * i;
        const float opaque = float(p[3]) / 255;
        const float bright =
            (0.2126f * float(p[0]) + 0.7152f * float(p[1]) + 0.0722f * float(p[2])) / 255;
        // What is transparent is no ink.
        picture.value[i] = ink == PictureInk::opaque ? opaque
                           : ink == PictureInk::dark ? opaque * (1 - bright)
                                                     : opaque * bright;
    }
    return picture;
}

}  // namespace geometry
