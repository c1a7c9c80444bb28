#include "render/exr.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/base/whole_file.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>

namespace render {
namespace {

// A file in memory.
class Written : public Imf::OStream {
public:
    Written() : OStream("picture.exr") {}
    void write(const char* c, int n) override
    {
        if (at_ + std::size_t(n) > bytes.size()) bytes.resize(at_ + std::size_t(n));
        std::memcpy(&bytes[at_], c, std::size_t(n));
        at_ += std::size_t(n);
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t at) override { at_ = at; }

    std::string bytes;

private:
    std::size_t at_ = 0;
};

constexpr std::array<const char*, 4> colours{"R", "G", "B", "A"};

// Where the channels of `image` lie, which is not changed when it is written.
Imf::FrameBuffer buffer_of(const Image& image)
{
    const std::size_t width = std::size_t(image.width);
    const auto slice = [&](Imf::PixelType type, const void* first, std::size_t step) {
        return Imf::Slice(type, static_cast<char*>(const_cast<void*>(first)), step, step * width);
    };
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < 4; ++c) {
        buffer.insert(colours[c], slice(Imf::HALF, &image.light[c], 4 * sizeof(std::uint16_t)));
    }
    if (!image.depth.empty()) {
        buffer.insert("Z", slice(Imf::FLOAT, image.depth.data(), sizeof(float)));
    }
    return buffer;
}

}  // namespace

std::string encode_exr(const Image& image)
{
    if (image.light.empty()) {
        throw std::invalid_argument(
            "an EXR file needs linear light, the picture has none: set 'linear' of the Render that "
            "makes it to whole or cut_out (a ContactSheet has none), or end the path in .png");
    }
    const std::size_t pixels =
        std::size_t(std::max(image.width, 0)) * std::size_t(std::max(image.height, 0));
    if (image.light.size() != 4 * pixels ||
        (!image.depth.empty() && image.depth.size() != pixels)) {
        throw std::invalid_argument("an image of " + std::to_string(image.width) + " x " +
                                    std::to_string(image.height) + " pixels needs " +
                                    std::to_string(4 * pixels) + " numbers of light, it has " +
                                    std::to_string(image.light.size()));
    }
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const char* name : colours) header.channels().insert(name, Imf::Channel(Imf::HALF));
    if (!image.depth.empty()) header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    Written written;
    {
        Imf::OutputFile file(written, header, 0);
        file.setFrameBuffer(buffer_of(image));
        constexpr int rows = 128;  // at a time: whole blocks of 16, as ZIP keeps them
        for (int row = 0; row < image.height; row += rows) {
            geometry::stop_if_asked();
            file.writePixels(std::min(rows, image.height - row));
        }
    }
    return std::move(written.bytes);
}

void write_exr(const std::filesystem::path& path, const Image& image)
{
    geometry::write_whole_file(path, encode_exr(image));
}

std::vector<std::uint16_t> halves(std::span<const float> values)
{
    std::vector<std::uint16_t> all(values.size());
    std::transform(values.begin(), values.end(), all.begin(), [](float v) {
        return half(std::clamp(v, -float(HALF_MAX), float(HALF_MAX))).bits();
    });
    return all;
}

float of_half(std::uint16_t bits)
{
    half h;
    h.setBits(bits);
    return h;
}

}  // namespace render
