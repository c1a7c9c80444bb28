#include "render/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace render {
namespace {

// A glyph is a few strokes, parted by commas. A point is a digit for x and a hexadecimal digit for
// y: descenders end at 0, the baseline is 3, small letters reach 8 and capitals b. A stroke that
// starts with ~ is a quadratic B-spline: it leaves the first point, ends in the last, and passes
// the middles between the others.
struct Glyph {
    int width;
    const char* strokes;
};
constexpr std::array<Glyph, 95> glyphs = {{
    {2, ""},                                  // space
    {0, "0b06,0303"},                         // !
    {2, "0b09,2b29"},                         // "
    {4, "131b,333b,0646,0949"},               // #
    {4, "~494b0b0747430305,2c22"},            // $
    {4, "034b,0b1b1a0a0b,3444433334"},        // %
    {5, "~53190b3b380503435 6"},              // &
    {0, "0b09"},                              // '
    {2, "~2c0a0422"},                         // (
    {2, "~0c2a2402"},                         // )
    {4, "2a26,0947,0749"},                    // *
    {4, "2824,0646"},                         // +
    {1, "1301"},                              // ,
    {3, "0636"},                              // -
    {1, "03130414,0314"},                     // .
    {4, "024c"},                              // /
    {4, "~2b4b43030b2b"},                     // 0
    {4, "092b23,0343"},                       // 1
    {4, "~090b4b4703,0343"},                  // 2
    {4, "~090b4b4717,~1747430305"},           // 3
    {4, "333b0545"},                          // 4
    {4, "4b0b07,~072848430304"},              // 5
    {4, "~4a4b0b05034347 0705"},              // 6
    {4, "0b4b13"},                            // 7
    {4, "~2b4b47070b2b,~274743030727"},       // 8
    {4, "~040343494b0b074749"},               // 9
    {0, "0303,0707"},                         // :
    {1, "1301,1717"},                         // ;
    {4, "490643"},                            // <
    {4, "0747,0545"},                         // =
    {4, "094603"},                            // >
    {4, "~090b4b472725,2323"},                // ?
    {6, "~63030b6b6545,~454848252545"},       // @
    {6, "033b63,1656"},                       // A
    {6, "030b,~0b3b6b673707,~073767633303"},  // B
    {6, "~696b0b036365"},                     // C
    {6, "030b,~0b3b6b633303"},                // D
    {5, "53030b5b,0747"},                     // E
    {5, "030b5b,0747"},                       // F
    {6, "~696b0b036366,6636"},                // G
    {6, "030b,636b,0767"},                    // H
    {0, "030b"},                              // I
    {4, "~4b47430305"},                       // J
    {6, "030b,6b06,2863"},                    // K
    {5, "0b0353"},                            // L
    {8, "030b458b83"},                        // M
    {6, "030b636b"},                          // N
    {6, "~3b6b63030b3b"},                     // O
    {6, "030b,~0b3b6b663606"},                // P
    {7, "~3b6b63030b3b,4672"},                // Q
    {6, "030b,~0b3b6b663606,3663"},           // R
    {6, "~696b0b0767630305"},                 // S
    {6, "333b,0b6b"},                         // T
    {6, "~0b070363676b"},                     // U
    {6, "0b336b"},                            // V
    {8, "0b2349638b"},                        // W
    {6, "036b,0b63"},                         // X
    {6, "0b376b,3733"},                       // Y
    {6, "0b6b0363"},                          // Z
    {2, "2c0c0222"},                          // [
    {4, "0c42"},                              // backslash
    {2, "0c2c2202"},                          // ]
    {4, "092b49"},                            // ^
    {4, "0242"},                              // _
    {1, "0b19"},                              // `
    {4, "4843,~464808034345"},                // a
    {4, "030b,~050343480806"},                // b
    {4, "~474808034344"},                     // c
    {4, "434b,~464808034345"},                // d
    {4, "0646,~464808034344"},                // e
    {3, "~3b1b1713,0838"},                    // f
    {4, "~464808034345,~4844400001"},         // g
    {4, "030b,~0608484643"},                  // h
    {0, "0308,0b0b"},                         // i
    {2, "~28242000,2b2b"},                    // j
    {4, "030b,4805,2643"},                    // k
    {2, "~0b070323"},                         // l
    {6, "0308,~0608383633,~3638686663"},      // m
    {4, "0308,~0608484643"},                  // n
    {4, "~284843030828"},                     // o
    {4, "0800,~050343480806"},                // p
    {4, "4840,~464808034345"},                // q
    {3, "0308,~060838"},                      // r
    {4, "~4748080645430304"},                 // s
    {3, "~1a171333,0838"},                    // t
    {4, "4843,~0805034346"},                  // u
    {4, "082348"},                            // v
    {6, "0813375368"},                        // w
    {4, "0843,0348"},                         // x
    {4, "4810,0823"},                         // y
    {4, "08480343"},                          // z
    {3, "~3c1c1807,~07161232"},               // {
    {0, "0c02"},                              // |
    {3, "~0c2c2837,~37262202"},               // }
    {4, "~05084447"},                         // ~
}};
constexpr Glyph unknown = {4, "030b4b4303"};

constexpr float baseline = 3, capital = 8;  // glyph units
constexpr float aspect = 0.9f;              // of a glyph unit
constexpr float gap = 2;                    // glyph units between letters

const Glyph& glyph_of(char c)
{
    const auto i = static_cast<std::size_t>(static_cast<unsigned char>(c)) - 32;
    return i < glyphs.size() ? glyphs[i] : unknown;
}

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

// In pixels, from the left end of the baseline.
std::vector<Segment> segments_of(const Glyph& glyph, float unit)
{
    std::vector<Segment> out;
    std::vector<Vec2f> points;
    bool smooth = false;
    const auto finish = [&] {
        add_stroke(out, points, smooth);
        points.clear();
        smooth = false;
    };
    for (const char* c = glyph.strokes; *c; ++c) {
        if (*c == ',') {
            finish();
        } else if (*c == '~') {
            smooth = true;
        } else if (*c != ' ') {
            const float x = digit(*c++);
            while (*c == ' ') ++c;
            points.emplace_back(unit * aspect * x, unit * (baseline - digit(*c)));
        }
    }
    finish();
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
    for (const char c : text) units += aspect * (static_cast<float>(glyph_of(c).width) + gap);
    return unit_of(height) * std::max(0.0f, units - aspect * gap);
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
        for (const char c : text) {
            const Glyph& glyph = glyph_of(c);
            const std::vector<Segment> segments = segments_of(glyph, unit);
            const float width = unit * aspect * static_cast<float>(glyph.width);
            const int x0 = std::max(0, int(std::floor(x - reach)));
            const int x1 = std::min(image.width - 1, int(std::ceil(x + width + reach)));
            const int y0 = std::max(0, int(std::floor(at.y() - 9 * unit - reach)));
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
