#include "render/measure.hpp"

#include <cstdlib>

namespace render {

double mean_brightness(const Image& image)
{
    if (image.rgba.empty()) return 0;
    double sum = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        sum += 0.2126 * image.rgba[i] + 0.7152 * image.rgba[i + 1] + 0.0722 * image.rgba[i + 2];
    }
    return sum / 255 / (static_cast<double>(image.rgba.size()) / 4);
}

double coverage(const Image& image)
{
    if (image.rgba.empty()) return 0;
    const auto width = static_cast<std::size_t>(image.width);
    std::size_t differ = 0;
    for (std::size_t p = 0; p < image.rgba.size() / 4; ++p) {
        const std::uint8_t* here = &image.rgba[4 * p];
        const std::uint8_t* first = &image.rgba[4 * (p / width * width)];
        bool same = true;
        for (int k = 0; k < 3; ++k) same = same && std::abs(here[k] - first[k]) <= 8;
        differ += same ? 0 : 1;
    }
    return static_cast<double>(differ) / (static_cast<double>(image.rgba.size()) / 4);
}

}  // namespace render
