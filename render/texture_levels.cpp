#include "render/texture_levels.hpp"

#include "geometry/base/srgb.hpp"

#include <algorithm>
#include <array>

namespace render {
namespace {

std::array<float, 256> make_light_of_byte()
{
    std::array<float, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i) {
        light[i] = geometry::linear_from_srgb(float(i) / 255);
    }
    return light;
}

// The display value of light in steps of 1 / 65535.
std::vector<std::uint8_t> make_byte_of_light()
{
    std::vector<std::uint8_t> bytes(65536);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] =
            static_cast<std::uint8_t>(255 * geometry::srgb_from_linear(float(i) / 65535) + 0.5f);
    }
    return bytes;
}

// Which texels of the level before lie under one of the next along a side, and with which weights.
struct Under {
    std::size_t first = 0, count = 0;
    std::array<float, 3> weight{};
};

std::vector<Under> under(int before, int after)
{
    std::vector<Under> all(static_cast<std::size_t>(after));
    const double step = double(before) / after;  // 1 to 3
    for (std::size_t i = 0; i < all.size(); ++i) {
        const double begin = double(i) * step, end = double(i + 1) * step;
        Under& u = all[i];
        u.first = static_cast<std::size_t>(begin + 1e-9);
        for (std::size_t k = 0; k < 3 && u.first + k < std::size_t(before); ++k) {
            const double low = std::max(begin, double(u.first + k));
            const double high = std::min(end, double(u.first + k + 1));
            if (high - low < 1e-9) break;
            u.weight[u.count++] = static_cast<float>((high - low) / step);
        }
    }
    return all;
}

TextureLevel smaller(const TextureLevel& from)
{
    static const std::array<float, 256> light = make_light_of_byte();
    static const std::vector<std::uint8_t> byte = make_byte_of_light();
    TextureLevel to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    to.rgba.reserve(4 * std::size_t(to.width) * std::size_t(to.height));
    const auto columns = under(from.width, to.width), rows = under(from.height, to.height);
    for (const Under& row : rows) {
        for (const Under& column : columns) {
            std::array<float, 4> sum{}, all{};  // times alpha; and of all texels, if none is opaque
            for (std::size_t j = 0; j < row.count; ++j) {
                const std::size_t start = (row.first + j) * std::size_t(from.width) + column.first;
                for (std::size_t i = 0; i < column.count; ++i) {
                    const std::uint8_t* const texel = &from.rgba[4 * (start + i)];
                    const float w = row.weight[j] * column.weight[i];
                    const float opaque = w * float(texel[3]) / 255;
                    for (std::size_t k = 0; k < 3; ++k) {
                        sum[k] += opaque * light[texel[k]];
                        all[k] += w * light[texel[k]];
                    }
                    sum[3] += opaque;
                }
            }
            const bool there = sum[3] > 1e-6f;
            for (std::size_t k = 0; k < 3; ++k) {
                const float mean = there ? sum[k] / sum[3] : all[k];
                to.rgba.push_back(
                    byte[static_cast<std::size_t>(65535 * std::min(mean, 1.f) + 0.5f)]);
            }
            to.rgba.push_back(static_cast<std::uint8_t>(255 * std::min(sum[3], 1.f) + 0.5f));
        }
    }
    return to;
}

TextureLevel smaller_of_numbers(const TextureLevel& from)
{
    TextureLevel to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    to.rgba.reserve(4 * std::size_t(to.width) * std::size_t(to.height));
    const auto columns = under(from.width, to.width), rows = under(from.height, to.height);
    for (const Under& row : rows) {
        for (const Under& column : columns) {
            std::array<float, 4> mean{};
            for (std::size_t j = 0; j < row.count; ++j) {
                const std::size_t start = (row.first + j) * std::size_t(from.width) + column.first;
                for (std::size_t i = 0; i < 4 * column.count; ++i) {
                    mean[i % 4] +=
                        row.weight[j] * column.weight[i / 4] * float(from.rgba[4 * start + i]);
                }
            }
            for (const float m : mean) to.rgba.push_back(static_cast<std::uint8_t>(m + 0.5f));
        }
    }
    return to;
}

// Texels that are not there take the colour of what lies around them: the next level's, whose rims
// are the mean of what is there. Else their own colour would show at the rims of leaves.
void fill_under_transparent(TextureLevel& level, const TextureLevel& next)
{
    for (std::size_t y = 0; y < std::size_t(level.height); ++y) {
        for (std::size_t x = 0; x < std::size_t(level.width); ++x) {
            std::uint8_t* const texel = &level.rgba[4 * (y * std::size_t(level.width) + x)];
            if (texel[3] != 0) continue;
            const std::size_t row = std::min(y / 2, std::size_t(next.height) - 1);
            const std::size_t column = std::min(x / 2, std::size_t(next.width) - 1);
            std::copy_n(&next.rgba[4 * (row * std::size_t(next.width) + column)], 3, texel);
        }
    }
}

}  // namespace

std::vector<TextureLevel> texture_levels(int width, int height, std::span<const std::uint8_t> rgba,
                                         int largest, bool normals)
{
    std::vector<TextureLevel> levels{{width, height, {rgba.begin(), rgba.end()}}};
    while (levels.back().width > 1 || levels.back().height > 1) {
        levels.push_back(normals ? smaller_of_numbers(levels.back()) : smaller(levels.back()));
    }
    for (std::size_t i = levels.size() - 1; i-- > 0 && !normals;) {
        fill_under_transparent(levels[i], levels[i + 1]);
    }
    std::size_t first = 0;
    while (std::max(levels[first].width, levels[first].height) > largest) ++first;
    levels.erase(levels.begin(), levels.begin() + std::ptrdiff_t(first));
    return levels;
}

}  // namespace render
