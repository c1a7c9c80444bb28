#include "render/png.hpp"

#include "geometry/base/whole_file.hpp"

#include <zlib.h>

#include <cstdlib>

// stb finds the filters and writes the chunks. Its own deflate takes 70 ms for a frame of 960 x 540
// and leaves 590 KB; zlib's quickest, on one fixed filter and without the alpha that every frame
// has, takes 14 ms and leaves 430 KB.
static unsigned char* deflated(unsigned char* data, int size, int* out_size, int level)
{
    auto capacity = compressBound(static_cast<uLong>(size));
    auto* out = static_cast<unsigned char*>(std::malloc(capacity));
    if (!out) return nullptr;
    if (compress2(out, &capacity, data, static_cast<uLong>(size), level) != Z_OK) {
        std::free(out);
        return nullptr;
    }
    *out_size = static_cast<int>(capacity);
    return out;
}

#define STBIW_ZLIB_COMPRESS deflated
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace render {
namespace {

// stb counts bytes in ints, and what is compressed may grow by a little.
constexpr double most_bytes = 2e9;
constexpr int filter_left = 1;  // each byte less the one a pixel to the left

// The picture without its alpha; empty when that is not opaque everywhere.
std::vector<std::uint8_t> opaque_rgb(const Image& image)
{
    std::vector<std::uint8_t> rgb(image.rgba.size() / 4 * 3);
    for (std::size_t i = 0, o = 0; i < image.rgba.size(); i += 4, o += 3) {
        if (image.rgba[i + 3] != 255) return {};
        for (std::size_t k = 0; k < 3; ++k) rgb[o + k] = image.rgba[i + k];
    }
    return rgb;
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Image& image)
{
    if ((4.0 * image.width + 1) * image.height > most_bytes) {
        throw std::invalid_argument("a picture of " + std::to_string(image.width) + " x " +
                                    std::to_string(image.height) +
                                    " pixels has more than the 2 GB that a PNG may: make it "
                                    "smaller (a contact sheet by more columns or a smaller width)");
    }
    const auto expected =
        std::size_t(std::max(image.width, 0)) * std::size_t(std::max(image.height, 0)) * 4;
    if (expected == 0 || image.rgba.size() != expected) {
        throw std::invalid_argument("an image of " + std::to_string(image.width) + " x " +
                                    std::to_string(image.height) + " pixels needs " +
                                    std::to_string(expected) + " bytes to be written, it has " +
                                    std::to_string(image.rgba.size()));
    }
    std::vector<std::uint8_t> bytes;
    const auto append = [](void* out, void* data, int size) {
        auto& all = *static_cast<std::vector<std::uint8_t>*>(out);
        const auto* first = static_cast<const std::uint8_t*>(data);
        all.insert(all.end(), first, first + size);
    };
    const std::vector<std::uint8_t> rgb = opaque_rgb(image);
    const int channels = rgb.empty() ? 4 : 3;
    static const bool set_up = [] {
        stbi_write_png_compression_level = 1;
        stbi_write_force_png_filter = filter_left;
        return true;
    }();
    static_cast<void>(set_up);
    if (!stbi_write_png_to_func(append, &bytes, image.width, image.height, channels,
                                rgb.empty() ? image.rgba.data() : rgb.data(),
                                image.width * channels)) {
        throw std::runtime_error("out of memory while a PNG was encoded");
    }
    return bytes;
}

void write_png(const std::filesystem::path& path, const Image& image)
{
    const std::vector<std::uint8_t> bytes = encode_png(image);
    geometry::write_whole_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace render
