#include "render/captions.hpp"

#include "render/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace render {
namespace {

std::string three_digits(double value)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

std::vector<std::string> lines_of_label(const std::string& label)
{
    std::vector<std::string> lines;
    for (std::size_t at = 0; at <= label.size();) {
        const std::size_t end = std::min(label.find('\n', at), label.size());
        lines.push_back(label.substr(at, end - at));
        at = end + 1;
    }
    return lines;
}

}  // namespace

std::string quantity_text(double value, const std::string& unit)
{
    if (unit.empty()) return three_digits(value);
    const double size = std::abs(value);
    constexpr std::array prefixed{"N", "Pa", "J", "W", "N m"};
    const bool usual = std::find(prefixed.begin(), prefixed.end(), unit) != prefixed.end();
    if (!usual || !(size > 0) || !std::isfinite(size)) return three_digits(value) + " " + unit;
    struct Prefix {
        double factor;
        const char* text;
    };
    // From where three digits round up to the next: 999.6 N are 1 kN. Tenths have no prefix.
    constexpr std::array<Prefix, 5> prefixes{
        {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}, {1, ""}, {1e-3, "m"}}};
    for (const Prefix& p : prefixes) {
        if (size >= (p.factor == 1 ? 0.1 : 0.9995) * p.factor || p.factor < 1) {
            return three_digits(value / p.factor) + " " + p.text + unit;
        }
    }
    return {};
}

void draw_label(Image& image, const std::string& label)
{
    const auto lines = lines_of_label(label);
    TextStyle style;
    style.height = letter_height(image.height);
    const float room = float(image.width) - 3.2f * style.height;
    float widest = 0;
    for (const std::string& line : lines) widest = std::max(widest, text_width(line, style.height));
    if (widest > room && room > 0) style.height = std::max(7.0f, style.height * room / widest);
    float y = float(image.height) - 1.6f * style.height;
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
        draw_text(image, *line, {1.6f * style.height, y}, style);
        y -= 1.9f * style.height;
    }
}

}  // namespace render
