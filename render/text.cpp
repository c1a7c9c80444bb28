#include "render/text.hpp"

#include "render/glyphs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace render {
namespace {

constexpr float baseline = 3, capital = 8;  // glyph units
constexpr float aspect = 0.9f;              // of a glyph unit
constexpr float gap = 2;                    // glyph units between letters

struct Segment {
    Vec2f a, b;
};

float digit(char c)
{
    return static_cast<float>(c <= '9' ? c - '0' : c - 'a' + 10);
}

// Straight pieces of one stroke through `points`.
void add_stroke(std::vector<Segment>& out, const std::vector<Vec2f>& points, bool smooth)
{
    if (!smooth || points.size() < 3) {
        for (std::size_t i = 0; i + 1 < points.size(); ++i) {
            out.push_back({points[i], points[i + 1]});
        }
        return;
    }
    constexpr int pieces = 6;
    Vec2f from = points.front();
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const bool last = i + 2 == points.size();
        const Vec2f to = last ? points.back() : Vec2f(0.5f * (points[i] + points[i + 1]));
        Vec2f before = from;
        for (int k = 1; k <= pieces; ++k) {
            const float t = static_cast<float>(k) / pieces, s = 1 - t;
            const Vec2f at = s * s * from + 2 * s * t * points[i] + t * t * to;
            out.push_back({before, at});
            before = at;
        }
        from = to;
    }
}

// In pixels, from the left end of the baseline. `right`, `up`: glyph units.
void add_strokes(std::vector<Segment>& out, const char* strokes, float right, float up, float unit)
{
    std::vector<Vec2f> points;
    bool smooth = false;
    const auto finish = [&] {
        add_stroke(out, points, smooth);
        points.clear();
        smooth = false;
    };
    for (const char* c = strokes; *c; ++c) {
        if (*c == ',') {
            finish();
        } else if (*c == '~') {
            smooth = true;
        } else if (*c != ' ') {
            const float x = digit(*c++);
            while (*c == ' ') ++c;
            points.emplace_back(unit * aspect * (x + right), unit * (baseline - digit(*c) - up));
        }
    }
    finish();
}

std::vector<Segment> segments_of(const Letter& letter, float unit)
{
    std::vector<Segment> out;
    add_strokes(out, letter.base.strokes, letter.right, 0, unit);
    for (const PlacedMark& m : letter.marks) add_strokes(out, m.strokes, m.right, m.up, unit);
    return out;
}

float distance(const Vec2f& p, const Segment& s)
{
    const Vec2f along = s.b - s.a;
    const float length_sq = along.squaredNorm();
    const float t = length_sq > 0 ? std::clamp((p - s.a).dot(along) / length_sq, 0.0f, 1.0f) : 0.0f;
    return (p - s.a - t * along).norm();
}

void blend(std::uint8_t* pixel, const Vec3f& colour, float cover)
{
    for (int k = 0; k < 3; ++k) {
        const float mixed = float(pixel[k]) + cover * (255 * colour[k] - float(pixel[k]));
        pixel[k] = static_cast<std::uint8_t>(std::lround(std::clamp(mixed, 0.0f, 255.0f)));
    }
}

float unit_of(float height)
{
    return height / capital;
}

}  // namespace

float letter_height(int width, int height)
{
    const float fitting = std::min(static_cast<float>(height) / 34, static_cast<float>(width) / 40);
    constexpr float least = 8;  // read at once
    return std::max(least, std::round(fitting));
}

float text_width(std::string_view text, float height)
{
    float units = 0;
    while (!text.empty()) {
        units += aspect * (letter_of(next_letter(text)).width + gap);
    }
    return unit_of(height) * std::max(0.0f, units - aspect * gap);
}

void cut_last_letter(std::string& text)
{
    while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0) == 0x80) {
        text.pop_back();
    }
    if (!text.empty()) text.pop_back();
}

std::string without_glyphs(std::string_view text)
{
    std::string out;
    while (!text.empty()) {
        const std::string_view before = text;
        if (is_drawn(next_letter(text)) || before[0] == '\n') continue;
        const std::string letter(before.substr(0, before.size() - text.size()));
        if (out.find(letter) == std::string::npos) out += letter;
    }
    return out;
}

void draw_text(Image& image, std::string_view text, const Vec2f& at, const TextStyle& style)
{
    const float unit = unit_of(style.height);
    const float half = std::max(0.55f, 0.075f * style.height);  // of a stroke's width
    const float halo = half + std::max(1.5f, 0.16f * style.height);
    const float reach = halo + 1;

    // The halo of a letter must not cover the letter before: all halos first.
    for (const bool letters : {false, true}) {
        float x = at.x();
        for (std::string_view rest = text; !rest.empty();) {
            const Letter letter = letter_of(next_letter(rest));
            const std::vector<Segment> segments = segments_of(letter, unit);
            const float width = unit * aspect * letter.width;
            const int x0 = std::max(0, int(std::floor(x - 2 * unit - reach)));
            const int x1 = std::min(image.width - 1, int(std::ceil(x + width + 2 * unit + reach)));
            const int y0 = std::max(0, int(std::floor(at.y() - 12 * unit - reach)));
            const int y1 = std::min(image.height - 1, int(std::ceil(at.y() + 3 * unit + reach)));
            for (int py = y0; py <= y1 && !segments.empty(); ++py) {
                for (int px = x0; px <= x1; ++px) {
                    const Vec2f p(float(px) + 0.5f - x, float(py) + 0.5f - at.y());
                    float nearest = 1e9f;
                    for (const Segment& s : segments) nearest = std::min(nearest, distance(p, s));
                    const float edge = letters ? half : halo;
                    float cover = std::clamp(edge + 0.5f - nearest, 0.0f, 1.0f);
                    if (!letters) {
                        const float fade = (halo + 0.5f - nearest) / (halo - half + 0.5f);
                        cover = style.halo_opacity * std::clamp(fade, 0.0f, 1.0f);
                    }
                    if (cover <= 0) continue;
                    blend(&image.rgba[4 * (std::size_t(py) * std::size_t(image.width) +
                                           std::size_t(px))],
                          letters ? style.colour : style.halo, cover);
                }
            }
            x += width + unit * aspect * gap;
        }
    }
}

}  // namespace render
