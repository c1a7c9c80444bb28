#include "render/png.hpp"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include <unistd.h>

namespace render {

std::vector<std::uint8_t> encode_png(const Image& image)
{
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
    if (!stbi_write_png_to_func(append, &bytes, image.width, image.height, 4, image.rgba.data(),
                                image.width * 4)) {
        throw std::runtime_error("out of memory while a PNG was encoded");
    }
    return bytes;
}

void write_png(const std::filesystem::path& path, const Image& image)
{
    const std::vector<std::uint8_t> bytes = encode_png(image);
    const auto fail = [&](const std::string& what) {
        throw std::runtime_error("cannot write " + path.string() + ": " + what);
    };
    std::error_code error;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
    if (error) fail(error.message());
    const std::filesystem::path beside = path.string() + "." + std::to_string(getpid()) + ".part";
    std::FILE* file = std::fopen(beside.c_str(), "wb");
    if (!file) fail(std::strerror(errno));
    const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
    const int write_error = errno;
    if (std::fclose(file) != 0 || !written) {
        std::filesystem::remove(beside, error);
        fail(std::strerror(written ? errno : write_error));
    }
    std::filesystem::rename(beside, path, error);
    if (error) {
        const std::string text = error.message();
        std::filesystem::remove(beside, error);
        fail(text);
    }
}

}  // namespace render
