#include "geometry/cubes/plane_picture.hpp"

#include "geometry/base/picture_file.hpp"

#include <fmt/format.h>

#include <fstream>
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
    Picture read;
    try {
        read = decode_picture(bytes);
    } catch (const std::runtime_error& error) {
        fail(error.what());
    }
    PlanePicture picture{read.width, read.height, {}};
    picture.value.resize(read.rgba.size() / 4);
    for (std::size_t i = 0; i < picture.value.size(); ++i) {
        const std::uint8_t* const p = &read.rgba[4 * i];
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
