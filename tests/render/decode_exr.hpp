#pragma once

// Reads what render/exr.hpp writes.

#include "render/image.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>

#include <algorithm>
#include <string>

namespace tests {

// A file in memory.
class Exr : public Imf::IStream {
public:
    explicit Exr(const std::string& bytes) : IStream("picture.exr"), bytes_(bytes) {}
    bool read(char* c, int n) override
    {
        if (at_ > bytes_.size() || std::size_t(n) > bytes_.size() - at_) {
            throw std::runtime_error("it is cut short");
        }
        std::copy_n(bytes_.data() + at_, n, c);
        at_ += std::size_t(n);
        return at_ < bytes_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t at) override { at_ = at; }

private:
    const std::string& bytes_;
    std::size_t at_ = 0;
};

// The light and depth of an EXR. Throws std::exception where it is damaged.
inline render::Image decode_exr(const std::string& bytes)
{
    Exr given(bytes);
    Imf::InputFile file(given, 0);
    const auto& window = file.header().dataWindow();
    render::Image image;
    image.width = window.max.x + 1;
    image.height = window.max.y + 1;
    const std::size_t width = std::size_t(image.width);
    image.light.resize(4 * width * std::size_t(image.height));
    Imf::FrameBuffer buffer;
    const auto add = [&](const char* name, Imf::PixelType type, auto* first, std::size_t step) {
        buffer.insert(name, Imf::Slice(type, reinterpret_cast<char*>(first), step, step * width));
    };
    std::size_t c = 0;
    for (const char* colour : {"R", "G", "B", "A"}) {
        add(colour, Imf::HALF, &image.light[c++], 4 * sizeof(std::uint16_t));
    }
    if (file.header().channels().findChannel("Z")) {
        image.depth.resize(image.light.size() / 4);
        add("Z", Imf::FLOAT, image.depth.data(), sizeof(float));
    }
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    return image;
}

}  // namespace tests
