#include "render/compare.hpp"

#include "geometry/base/stop.hpp"
#include "render/legend.hpp"
#include "render/text.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace render {
namespace {

constexpr std::ptrdiff_t channels = 4;

std::string size_told(const Image& image)
{
    return std::to_string(image.width) + " x " + std::to_string(image.height);
}

void check_alike(const Image& a, const Image& b)
{
    const auto whole = [](const Image& i) {
        return i.width > 0 && i.height > 0 &&
               i.rgba.size() == 4 * std::size_t(i.width) * std::size_t(i.height);
    };
    if (a.width != b.width || a.height != b.height) {
        throw std::invalid_argument("two pictures are compared pixel by pixel: a is " +
                                    size_told(a) + " and b is " + size_told(b) +
                                    "; give both the same width and height");
    }
    if (!whole(a) || !whole(b)) {
        throw std::invalid_argument("pictures of " + size_told(a) + " have nothing to compare");
    }
}

Image empty(int width, int height)
{
    return {width, height,
            std::vector<std::uint8_t>(4 * std::size_t(width) * std::size_t(height), 255)};
}

// Columns `from` up to `to` of a picture, into those from `at` on of another as high.
void copy_columns(const Image& image, int from, int to, Image& out, int at)
{
    for (int y = 0; y < image.height; ++y) {
        const auto row = image.rgba.begin() + channels * y * image.width;
        std::copy(row + channels * from, row + channels * to,
                  out.rgba.begin() + channels * (std::ptrdiff_t(y) * out.width + at));
    }
}

void fill_columns(Image& image, int from, int to, std::uint8_t grey)
{
    from = std::max(0, from), to = std::min(to, image.width);
    for (int y = 0; y < image.height; ++y) {
        for (int x = from; x < to; ++x) {
            const auto at = image.rgba.begin() + channels * (std::ptrdiff_t(y) * image.width + x);
            std::fill_n(at, 3, grey);
        }
    }
}

enum class Side { left, right };

// At the top, in letters that fit into its width beside what is `taken`, or cut.
void draw_heading(Image& image, const std::string& label, Side side,
                  std::span<const Area> taken = {})
{
    const auto placed = [&](float letter) {
        return PlacedText{label, {1.6f * letter, 2.4f * letter}, letter};
    };
    PlacedText heading = placed(letter_height(image.width, image.height));
    const float width = text_width(label, heading.height);
    const float room = room_of(heading, image.width, taken);
    if (width > room) heading = placed(std::max(least_letter, heading.height * room / width));
    heading.text = cut_to(label, heading.height, room_of(heading, image.width, taken));
    if (side == Side::right) {
        const float wide = text_width(heading.text, heading.height);
        heading.at.x() = float(image.width) - heading.at.x() - wide;
    }
    draw_texts(image, std::span(&heading, 1));
}

// Of an even width, as videos need it.
int gap_of(int height)
{
    return 2 * std::max(1, height / 270);
}

Image beside(const Image& a, const Image& b)
{
    const int gap = gap_of(a.height);
    Image out = empty(2 * a.width + gap, a.height);
    copy_columns(a, 0, a.width, out, 0);
    fill_columns(out, a.width, a.width + gap, 255);
    copy_columns(b, 0, b.width, out, a.width + gap);
    return out;
}

Image wiped(const Image& a, const Image& b, double place)
{
    const int line = static_cast<int>(std::lround(std::clamp(place, 0.0, 1.0) * a.width));
    Image out = empty(a.width, a.height);
    copy_columns(a, 0, line, out, 0);
    copy_columns(b, line, b.width, out, line);
    if (line > 0 && line < a.width) {
        const int half = gap_of(a.height) / 2;
        fill_columns(out, line - half - 1, line + half + 1, 26);  // stands off white pictures
        fill_columns(out, line - half, line + half, 255);
    }
    return out;
}

// By the channel that differs most, as a share of black to white.
Image differences(const Image& a, const Image& b, const std::string& heading, double gain)
{
    Image out = empty(a.width, a.height);
    const Legend legend{"difference", "%", {ColourMap::viridis, 0, float(100 / gain)}};
    const std::size_t row = 4 * std::size_t(a.width);
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        if (i % row == 0) geometry::stop_if_asked();
        int most = 0;
        for (std::size_t k = i; k < i + 3; ++k) {
            most = std::max(most, std::abs(int(a.rgba[k]) - int(b.rgba[k])));
        }
        const float percent = 100 * float(most) / 255;
        const Vec3f c = colour_at(legend.scale.map, legend.scale.place(percent));
        for (int k = 0; k < 3; ++k) {
            out.rgba[i + std::size_t(k)] = static_cast<std::uint8_t>(std::lround(255 * c[k]));
        }
    }
    draw_legend(out, legend);
    draw_heading(out, heading, Side::left, areas_of(legend, a.width, a.height));
    return out;
}

}  // namespace

Image compare(const Image& a, const Image& b, const Comparison& how)
{
    check_alike(a, b);
    if (how.mode == CompareMode::difference) {
        const std::string between = how.label_a.empty() || how.label_b.empty() ? "" : " - ";
        return differences(a, b, how.label_a + between + how.label_b, how.gain);
    }
    // Before they are cut, so that a line that wipes a picture wipes its label.
    const bool wipes = how.mode == CompareMode::wipe;
    Image left{a.width, a.height, a.rgba}, right{b.width, b.height, b.rgba};
    draw_heading(left, how.label_a, Side::left);
    draw_heading(right, how.label_b, wipes ? Side::right : Side::left);
    return wipes ? wiped(left, right, how.wipe) : beside(left, right);
}

}  // namespace render
