#include "render/captions.hpp"

#include "render/legend.hpp"
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

// Where the lines go that have letters so high, the last one above the lower edge.
std::vector<PlacedText> stacked(const std::vector<std::string>& lines, float letter, int height)
{
    std::vector<PlacedText> out;
    float y = float(height) - 1.6f * letter - 1.9f * letter * float(lines.size() - 1);
    for (const std::string& line : lines) {
        out.push_back({line, {1.6f * letter, y}, letter});
        y += 1.9f * letter;
    }
    return out;
}

bool is_clear(const PlacedText& text, std::span<const Area> taken)
{
    const Area area = area_of(text);
    return std::none_of(taken.begin(), taken.end(), [&](const Area& a) { return meet(area, a); });
}

// To where nothing is taken: where it is, else a line above, a line below, two above and so on.
// Whether there is such a place.
bool move_clear(PlacedText& text, std::span<const Area> taken, int height)
{
    const float letter = text.height, first = text.at.y();
    for (int k = 0; k <= 10; ++k) {
        const int away = (k + 1) / 2;
        const float lines = k % 2 == 0 ? float(away) : -float(away);
        text.at.y() = first + 1.9f * letter * lines;
        const bool inside = text.at.y() >= 2 * letter && text.at.y() <= float(height) - letter;
        if ((k == 0 || inside) && is_clear(text, taken)) return true;
    }
    return false;
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

std::vector<PlacedText> place_label(const std::string& label, int width, int height,
                                    std::span<const Area> taken)
{
    auto lines = lines_of_label(label);
    float letter = letter_height(width, height);
    // Of smaller letters the lines lie lower, where less may be taken: a few times.
    for (int again = 0; again < 8 && letter > least_letter; ++again) {
        float fits = 1;
        for (const PlacedText& line : stacked(lines, letter, height)) {
            const float wide = text_width(line.text, letter);
            if (wide > 0) fits = std::min(fits, room_of(line, width, taken) / wide);
        }
        if (fits >= 1) break;
        letter = std::max(least_letter, letter * std::max(fits, 0.5f));
    }
    letter = std::min(letter, float(height) / letters_high(lines.size()));
    letter = std::max(letter, least_letter);
    leave_out_what_has_no_room(lines, letter, height);
    std::vector<PlacedText> out = stacked(lines, letter, height);
    for (PlacedText& line : out) {
        line.text = cut_to(line.text, letter, room_of(line, width, taken));
    }
    std::erase_if(out, [](const PlacedText& line) { return line.text.empty(); });
    return out;
}

std::vector<PlacedText> place_notes(const Camera& camera, std::span<const Note> notes, int width,
                                    int height, double right_taken, std::span<const Area> taken)
{
    const double aspect = double(width) / height;
    const auto right = float((1 - right_taken) * width);
    const float letter = letter_height(width, height);
    std::vector<PlacedText> out;
    std::vector<Area> all(taken.begin(), taken.end());
    for (const Note& note : notes) {
        const auto tip = place_in_picture(camera, note.tip, aspect);
        const auto from = place_in_picture(camera, note.from, aspect);
        if (!tip || tip->x() < 0 || tip->x() > 1 || tip->y() < 0 || tip->y() > 1) continue;
        const auto in_pixels = [&](const Vec3& p) {
            return Vec2f(float(p.x() * width), float(p.y() * height));
        };
        const Vec2f at = in_pixels(*tip);
        const Vec2f along = from ? Vec2f(at - in_pixels(*from)) : Vec2f(0, 1);
        const float apart = float(note.clear * tip->z() * height) + 0.8f * letter;
        const float wide = text_width(note.text, letter);
        PlacedText placed{note.text, beside_tip(at, along, apart, wide, letter, right, height),
                          letter};
        if (!move_clear(placed, all, height)) continue;
        all.push_back(area_of(placed));
        out.push_back(placed);
    }
    return out;
}

void draw_captions(Image& image, const Camera& camera, const Scene& scene)
{
    const int width = image.width, height = image.height;
    std::vector<Area> taken;
    double right_taken = 0;
    if (scene.legend) {
        taken = areas_of(*scene.legend, width, height);
        right_taken = width_of(*scene.legend, width, height);
    }
    std::vector<PlacedText> label;
    if (!scene.label.empty()) label = place_label(scene.label, width, height, taken);
    for (const PlacedText& line : label) taken.push_back(area_of(line));
    draw_texts(image, place_notes(camera, scene.notes, width, height, right_taken, taken));
    if (scene.legend) draw_legend(image, *scene.legend);
    draw_texts(image, label);
}

}  // namespace render
