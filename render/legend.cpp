#include "render/legend.hpp"

#include "render/text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace render {
namespace {

// 1, 2 or 5 times a power of ten, not smaller than x > 0 but by the rounding of floats.
double round_up(double x)
{
    const double power = std::pow(10, std::floor(std::log10(x)));
    for (const double digit : {1.0, 2.0, 5.0}) {
        if (digit * power >= x * (1 - 1e-6)) return digit * power;
    }
    return 10 * power;
}

// The power of ten of the last digit that numbers `spacing` apart need: -1 for 0.2, 0 for 25, -1
// for 2.5.
int last_power(double spacing)
{
    const int power = int(std::floor(std::log10(spacing) + 1e-9));
    const double digit = spacing / std::pow(10, power);
    return std::abs(digit - std::round(digit)) > 1e-6 ? power - 1 : power;
}

// Whether they are more apart than by rounding.
bool differ(double low, double high)
{
    return high - low > 1e-6 * std::max(std::abs(low), std::abs(high));
}

// At most half of what floats hold, so that they hold the length of a range too.
float held(double v)
{
    return float(std::clamp(v, -1.6e38, 1.6e38));
}

// Ends that are multiples of a round number, about a quarter of the length.
std::array<float, 2> away_from_0(double low, double high)
{
    const double step = round_up((high - low) / 4);
    return {held(step * std::floor(low / step + 1e-6)), held(step * std::ceil(high / step - 1e-6))};
}

// Where a legend goes, pixels.
struct Place {
    Place(const Legend& legend, int width, int height)
        : size(letter_height(width, height)), bar_width(int(std::lround(1.4f * size))),
          bar_height(height * 45 / 100), top(height * 25 / 100)
    {
        const ColourScale& scale = legend.scale;
        marks =
            ticks(scale.low, scale.high, std::clamp(int(float(bar_height) / (2.2f * size)), 1, 5));
        mark_texts = tick_texts(marks);
        float widest = 0;
        for (const auto& text : mark_texts) widest = std::max(widest, text_width(text, size));
        // In a narrow picture numbers get no more room than they need.
        const float beside =
            float(width) < 40 * size ? std::min(7 * size, widest + 2.4f * size) : 7 * size;
        right = width - int(std::lround(beside));
        const std::string named =
            legend.title + (legend.unit.empty() ? "" : " (" + legend.unit + ")");
        title = right_aligned(named, float(top) - 1.6f * size, width);
        note = right_aligned(legend.note, float(top + bar_height) + 2.4f * size, width);
    }

    // From the bar on, or as far left as it needs; in smaller letters, or cut, where it is wider
    // than the picture.
    PlacedText right_aligned(const std::string& text, float y, int width) const
    {
        const float room = float(width) - 1.5f * size - 2;
        const float wide = text_width(text, size);
        const float letters = wide > room ? std::max(least_letter, size * room / wide) : size;
        const std::string cut = cut_to(text, letters, room);
        const float left = float(width) - 1.5f * size - text_width(cut, letters);
        return {cut, {std::max(2.0f, std::min(float(right - bar_width), left)), y}, letters};
    }

    // With its title inside the picture.
    bool is_there() const { return right - bar_width >= 2 && float(top) >= 2.6f * size; }

    float size;
    int bar_width, bar_height, top, right = 0;  // of the bar
    PlacedText title, note;
    std::vector<double> marks;
    std::vector<std::string> mark_texts;
};

std::uint8_t* pixel_at(Image& image, int x, int y)
{
    return &image.rgba[4 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x))];
}

}  // namespace

std::vector<double> ticks(double low, double high, int count)
{
    if (!(high > low) || !std::isfinite(low) || !std::isfinite(high) ||
        high - low <= 1e-12 * std::max(std::abs(low), std::abs(high))) {
        return {};
    }
    double spacing = round_up((high - low) / std::max(1, count));
    if (high - low < 2 * spacing) spacing /= 2;
    std::vector<double> out;
    for (double i = std::ceil(low / spacing - 1e-6); i * spacing <= high + 1e-6 * spacing; ++i) {
        out.push_back(i == 0 ? 0.0 : i * spacing);
    }
    return out;
}

std::string tick_text(double value, double spacing, double largest)
{
    if (value == 0) return "0";
    largest = std::max({std::abs(value), spacing, largest});
    std::array<char, 32> text{};
    if (largest >= 1e5 || largest < 1e-3) {
        const int first = int(std::floor(std::log10(largest) + 1e-9));
        const int digits = std::max(0, first - last_power(spacing));
        std::snprintf(text.data(), text.size(), "%.*e", std::min(digits, 6), value);
    } else {
        const int digits = std::max(0, -last_power(spacing));
        std::snprintf(text.data(), text.size(), "%.*f", std::min(digits, 9), value);
    }
    return text.data();
}

std::vector<std::string> tick_texts(const std::vector<double>& ticks)
{
    const double spacing = ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
    double largest = 0;
    for (const double tick : ticks) largest = std::max(largest, std::abs(tick));
    std::vector<std::string> out;
    for (const double tick : ticks) out.push_back(tick_text(tick, spacing, largest));
    return out;
}

std::array<float, 2> round_range(const std::vector<float>& values, bool even)
{
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const float v : values) {
        if (!std::isfinite(v)) continue;
        low = std::min(low, double(v));
        high = std::max(high, double(v));
    }
    if (low > high || (low == 0 && high == 0)) return {0, 1};
    if (const double dust = 1e-3 * (high - low); dust > 0) {
        if (low < 0 && -low < dust) low = 0;
        if (high > 0 && high < dust) high = 0;
    }
    if (low < 0 && high > 0) {
        if (even) high = std::max(high, -low), low = -high;
        return {held(-round_up(-low)), held(round_up(high))};
    }
    const double near = std::min(std::abs(low), std::abs(high));
    const double far = std::max(std::abs(low), std::abs(high));
    if (near > 0.3 * far && differ(low, high)) return away_from_0(low, high);
    if (high > 0) return {0, held(round_up(high))};
    return {held(-round_up(-low)), 0};
}

ClippedRange percentile_range(std::vector<float> values, double clip)
{
    std::erase_if(values, [](float v) { return !std::isfinite(v); });
    if (values.empty()) return {round_range(values)};
    const auto at = [&](double share) {
        const auto place = std::ptrdiff_t(std::lround(share * double(values.size() - 1)));
        std::nth_element(values.begin(), values.begin() + place, values.end());
        return double(values[std::size_t(place)]);
    };
    const double least = at(0), most = at(1), low = at(clip), high = at(1 - clip);
    if (differ(low, high)) return {{held(low), held(high)}, least < low || most > high};
    if (differ(least, most)) return {{held(least), held(most)}};
    return {round_range(values)};
}

void draw_legend(Image& image, const Legend& legend)
{
    const Place place(legend, image.width, image.height);
    if (!place.is_there()) return;
    const float size = place.size;
    const int bar_width = place.bar_width, bar_height = place.bar_height;
    const int right = place.right, top = place.top;
    for (int y = 0; y < bar_height; ++y) {
        const float t = 1 - (float(y) + 0.5f) / float(bar_height);
        const Vec3f c = colour_at(legend.scale.map, t);
        for (int x = std::max(0, right - bar_width); x < right; ++x) {
            std::uint8_t* p = pixel_at(image, x, top + y);
            for (int k = 0; k < 3; ++k) {
                p[k] = static_cast<std::uint8_t>(std::lround(255 * c[k]));
            }
        }
    }

    draw_texts(image, std::array{place.title, place.note});
    const double low = legend.scale.low, high = legend.scale.high;
    for (std::size_t i = 0; i < place.marks.size(); ++i) {
        const float t = static_cast<float>((place.marks[i] - low) / (high - low));
        const float y = float(top) + (1 - t) * float(bar_height);
        const int row = std::clamp(int(y), 0, image.height - 1);
        for (int x = right; x < std::min(image.width, right + int(size / 2)); ++x) {
            std::uint8_t* p = pixel_at(image, x, row);
            p[0] = p[1] = p[2] = 255;
        }
        const PlacedText number{
            place.mark_texts[i], {float(right) + 0.9f * size, y + 0.5f * size}, size};
        draw_texts(image, std::span(&number, 1));
    }
}

std::vector<Area> areas_of(const Legend& legend, int width, int height)
{
    const Place place(legend, width, height);
    if (!place.is_there()) return {};
    const float over = 0.5f * place.size + 1;  // of a number beside an end of the bar
    std::vector<Area> areas{{float(place.right - place.bar_width), float(place.top) - over,
                             float(width), float(place.top + place.bar_height) + over}};
    for (const PlacedText& text : {place.title, place.note}) {
        if (!text.text.empty()) areas.push_back(area_of(text));
    }
    return areas;
}

double width_of(const Legend& legend, int width, int height)
{
    const Place place(legend, width, height);
    if (!place.is_there()) return 0;
    const double left = std::min(double(place.right - place.bar_width), double(place.title.at.x()));
    return std::clamp(1 - (left - place.size) / width, 0.0, 1.0);
}

}  // namespace render
