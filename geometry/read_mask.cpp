// Pictures by stb_image, which is told to be private to this file: others have their own.
#include "geometry/plane.hpp"

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

Mask read_mask(const std::filesystem::path& path, MaskInk ink)
{
    const auto fail = [&](const std::string& why) {
        throw std::runtime_error(
            fmt::format("{}: {}; expected a PNG, JPEG, BMP or TGA picture", path.string(), why));
    };
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) fail("can't be opened");
    const auto length = std::int64_t(in.tellg());
    if (length < 0 || length > 1'000'000'000) fail("is no file, or larger than a gigabyte");
    std::string bytes(std::size_t(length), '\0');
    in.seekg(0);
    in.read(bytes.data(), length);
    if (!in) fail("can't be read");
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    constexpr double most_pixels = 1e8;
    int width = 0, height = 0, channels = 0;
    const int size = int(bytes.size());
    if (!stbi_info_from_memory(data, size, &width, &height, &channels)) {
        fail("can't be read as a picture");
    }
    if (double(width) * height > most_pixels)
        fail(fmt::format("has {} x {} pixels", width, height));
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(data, size, &width, &height, &channels, 4),
        [](void* p) { stbi_image_free(p); });
    if (!pixels) fail(stbi_failure_reason() ? stbi_failure_reason() : "can't be read");
    Mask mask{width, height, {}};
    mask.value.resize(std::size_t(width) * std::size_t(height));
    for (std::size_t i = 0; i < mask.value.size(); ++i) {
        const stbi_uc* const p = pixels.get() + 4 * i;
        const float opaque = float(p[3]) / 255;
        const float bright =
            (0.2126f * float(p[0]) + 0.7152f * float(p[1]) + 0.0722f * float(p[2])) / 255;
        // What is transparent is no ink.
        mask.value[i] = ink == MaskInk::opaque ? opaque
                        : ink == MaskInk::dark ? opaque * (1 - bright)
                                               : opaque * bright;
    }
    return mask;
}

}  // namespace geometry
