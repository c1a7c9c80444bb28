#include "render/contact_sheet.hpp"

#include "render/text.hpp"

#define STB_IMAGE_RESIZE_IMPLEMENTATION
#define STB_IMAGE_RESIZE_STATIC
#include <stb/stb_image_resize.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace render {

Image resized(const Image& image, int width, int height)
{
    const auto bytes = [](int w, int h) { return 4 * std::size_t(w) * std::size_t(h); };
    if (image.width < 1 || image.height < 1 || width < 1 || height < 1 ||
        image.rgba.size() != bytes(image.width, image.height)) {
        throw std::invalid_argument("an image of " + std::to_string(image.width) + " x " +
                                    std::to_string(image.height) + " cannot be made " +
                                    std::to_string(width) + " x " + std::to_string(height));
    }
    Image out{width, height, std::vector<std::uint8_t>(bytes(width, height))};
    stbir_resize_uint8_generic(image.rgba.data(), image.width, image.height, 0, out.rgba.data(),
                               width, height, 0, 4, 3, 0, STBIR_EDGE_CLAMP, STBIR_FILTER_MITCHELL,
                               STBIR_COLORSPACE_SRGB, nullptr);
    return out;
}

namespace {

// `label` in lines that are no wider than `width` pixels, parted at blanks; a word that is wider
// is a line of its own, cut where the width ends.
std::vector<std::string> lines_of(const std::string& label, float width, float height)
{
    std::vector<std::string> lines;
    std::string line;
    for (std::size_t at = 0; at < label.size();) {
        // A word and the blanks before it.
        const std::size_t word = std::min(label.find_first_not_of(' ', at), label.size());
        const std::size_t end = std::min(label.find(' ', word), label.size());
        std::string longer = line + label.substr(at, end - at);
        if (!line.empty() && text_width(longer, height) > width) {
            lines.push_back(std::move(line));
            longer = label.substr(word, end - word);
        }
        for (std::string shorter = longer; text_width(longer, height) > width;) {
            cut_last_letter(shorter);
            if (shorter.empty()) break;
            longer = shorter;
        }
        line = std::move(longer);
        at = end;
    }
    if (!line.empty()) lines.push_back(std::move(line));
    return lines;
}

}  // namespace

Image contact_sheet(const std::vector<Tile>& tiles, int columns, int width)
{
    if (tiles.empty()) throw std::invalid_argument("a contact sheet needs at least one picture");
    columns = std::clamp(columns, 1, static_cast<int>(tiles.size()));
    const int rows = (static_cast<int>(tiles.size()) + columns - 1) / columns;
    const int gap = std::max(2, width / 160);
    const int tile_width = (width - gap * (columns + 1)) / columns;
    if (tile_width < 8) {
        throw std::invalid_argument("a contact sheet " + std::to_string(width) +
                                    " pixels wide has no room for " + std::to_string(columns) +
                                    " columns");
    }
    const Image& first = *tiles[0].image;
    if (first.width < 1 || first.height < 1) {
        throw std::invalid_argument("a contact sheet's first picture has no pixels");
    }
    const int tile_height =
        std::max(1, static_cast<int>(std::lround(double(tile_width) * first.height / first.width)));
    TextStyle style;
    style.height = std::clamp(static_cast<float>(tile_width) / 30, 7.0f, 16.0f);
    style.colour = {0.82f, 0.84f, 0.86f};
    style.halo_opacity = 0;
    const float inset = 0.3f * style.height;
    std::vector<std::vector<std::string>> labels;
    std::size_t lines = 1;
    for (const Tile& tile : tiles) {
        labels.push_back(lines_of(tile.label, float(tile_width) - 2 * inset, style.height));
        lines = std::max(lines, labels.back().size());
    }
    const float line_height = 1.7f * style.height;
    const int strip =
        static_cast<int>(std::lround(2.2f * style.height + float(lines - 1) * line_height));

    Image sheet{width, gap + rows * (tile_height + strip + gap), {}};
    sheet.rgba.resize(4 * std::size_t(sheet.width) * std::size_t(sheet.height));
    for (std::size_t i = 0; i < sheet.rgba.size(); ++i) {
        sheet.rgba[i] = i % 4 == 3 ? 255 : static_cast<std::uint8_t>(26 + i % 4);
    }
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
        const int x = gap + column * (tile_width + gap);
        const int y = gap + row * (tile_height + strip + gap);
        const Image tile = resized(*tiles[i].image, tile_width, tile_height);
        for (int line = 0; line < tile_height; ++line) {
            const auto from = tile.rgba.begin() + std::ptrdiff_t(4) * line * tile_width;
            std::copy(from, from + std::ptrdiff_t(4) * tile_width,
                      sheet.rgba.begin() + 4 * (std::ptrdiff_t(y + line) * sheet.width + x));
        }
        for (std::size_t k = 0; k < labels[i].size(); ++k) {
            draw_text(sheet, labels[i][k],
                      {static_cast<float>(x) + inset, static_cast<float>(y + tile_height) +
                                                          1.6f * style.height +
                                                          float(k) * line_height},
                      style);
        }
    }
    return sheet;
}

std::vector<int> spread_frames(int first, int last, int count)
{
    const int all = last - first + 1;
    if (count >= all || count < 1) count = std::max(all, 0);
    std::vector<int> frames;
    for (int i = 0; i < count; ++i) {
        const double part = count > 1 ? double(i) / (count - 1) : 0;
        frames.push_back(first + static_cast<int>(std::lround(part * (all - 1))));
    }
    return frames;
}

}  // namespace render
