#include "render/captions.hpp"

#include "render/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace render {
namespace {

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

// Where the text of a note starts: right of an upright arrow and above a level one, with `apart`
// pixels between, inside the picture up to its column `right`.
Vec2f beside_tip(const Vec2f& tip, const Vec2f& along, float apart, float width, float letter,
                 float right, int height)
{
    Vec2f at(tip.x() + apart, tip.y() + 0.5f * letter);
    if (std::abs(along.x()) > std::abs(along.y())) {
        at = {tip.x() - 0.5f * width, tip.y() - apart};
    } else if (at.x() + width > right - letter) {
        at.x() = tip.x() - apart - width;
    }
    at.x() = std::clamp(at.x(), letter, std::max(letter, right - letter - width));
    at.y() = std::clamp(at.y(), 2 * letter, std::max(2 * letter, float(height) - letter));
    return at;
}

// Letters no higher than 7 pixels are not read.
constexpr float least_letter = 7;

// How many letters high so many lines are, with what is free below and above them.
float letters_high(std::size_t lines)
{
    return 1.1f + 1.9f * float(lines);
}

// Of the first lines as many as stand in the picture, and how many more there are.
void leave_out_what_has_no_room(std::vector<std::string>& lines, float letter, int height)
{
    std::size_t room = 1;
    while (room < lines.size() && letters_high(room + 1) * letter <= float(height)) ++room;
    if (room == lines.size()) return;
    const std::size_t more = lines.size() - (room - 1);
    lines.resize(room);
    lines.back() = "... " + std::to_string(more) + " more";
}

}  // namespace

std::string number_text(double value)
{
    const double size = std::abs(value);
    const bool whole = size >= 99.95 && size < 999999.5;
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), whole ? "%.0f" : "%.3g", value);
    return text.data();
}

std::string quantity_text(double value, const std::string& unit)
{
    if (unit.empty()) return number_text(value);
    const double size = std::abs(value);
    constexpr std::array prefixed{"N", "Pa", "J", "W", "N m"};
    const bool usual = std::find(prefixed.begin(), prefixed.end(), unit) != prefixed.end();
    if (!usual || !(size > 0) || !std::isfinite(size)) return number_text(value) + " " + unit;
    struct Prefix {
        double factor;
        const char* text;
    };
    // From where three digits round up to the next: 999.6 N are 1 kN. Tenths have no prefix.
    constexpr std::array<Prefix, 5> prefixes{
        {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}, {1, ""}, {1e-3, "m"}}};
    for (const Prefix& p : prefixes) {
        if (size >= (p.factor == 1 ? 0.1 : 0.9995) * p.factor || p.factor < 1) {
            return number_text(value / p.factor) + " " + p.text + unit;
        }
    }
    return {};
}

void draw_label(Image& image, const std::string& label)
{
    auto lines = lines_of_label(label);
    TextStyle style;
    style.height = letter_height(image.height);
    const float room = float(image.width) - 3.2f * style.height;
    float widest = 0;
    for (const std::string& line : lines) widest = std::max(widest, text_width(line, style.height));
    if (widest > room && room > 0) style.height *= room / widest;
    style.height = std::min(style.height, float(image.height) / letters_high(lines.size()));
    style.height = std::max(style.height, least_letter);
    leave_out_what_has_no_room(lines, style.height, image.height);
    float y = float(image.height) - 1.6f * style.height;
    for (auto line = lines.rbegin(); line != lines.rend(); ++line) {
        draw_text(image, *line, {1.6f * style.height, y}, style);
        y -= 1.9f * style.height;
    }
}

void draw_notes(Image& image, const Camera& camera, std::span<const Note> notes, double right_taken)
{
    const double aspect = double(image.width) / image.height;
    const auto right = float((1 - right_taken) * image.width);
    TextStyle style;
    style.height = letter_height(image.height);
    for (const Note& note : notes) {
        const auto tip = place_in_picture(camera, note.tip, aspect);
        const auto from = place_in_picture(camera, note.from, aspect);
        if (!tip || tip->x() < 0 || tip->x() > 1 || tip->y() < 0 || tip->y() > 1) continue;
        const auto in_pixels = [&](const Vec3& p) {
            return Vec2f(float(p.x() * image.width), float(p.y() * image.height));
        };
        const Vec2f at = in_pixels(*tip);
        const Vec2f along = from ? Vec2f(at - in_pixels(*from)) : Vec2f(0, 1);
        const float apart = float(note.clear * tip->z() * image.height) + 0.8f * style.height;
        const float width = text_width(note.text, style.height);
        draw_text(image, note.text,
                  beside_tip(at, along, apart, width, style.height, right, image.height), style);
    }
}

}  // namespace render
