#include "render/placed_text.hpp"

#include <algorithm>

namespace render {

bool meet(const Area& a, const Area& b)
{
    return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

Area area_of(const PlacedText& text)
{
    const float width = text_width(text.text, text.height);
    const float below = 0.375f * text.height;  // descenders
    return {text.at.x() - 1, text.at.y() - text.height - 1, text.at.x() + width + 1,
            text.at.y() + below + 1};
}

float room_of(const PlacedText& line, int width, std::span<const Area> taken)
{
    Area band = area_of(line);
    band.right = float(width);
    float end = float(width) - line.at.x();
    for (const Area& area : taken) {
        if (meet(band, area)) end = std::min(end, area.left - line.height);
    }
    return std::max(0.0f, end - line.at.x());
}

std::string cut_to(const std::string& text, float height, float room)
{
    if (text_width(text, height) <= room) return text;
    for (std::string shorter = text; cut_last_letter(shorter), !shorter.empty();) {
        std::string cut = shorter;
        cut.erase(cut.find_last_not_of(' ') + 1);
        cut += "...";
        if (text_width(cut, height) <= room) return cut;
    }
    return {};
}

void draw_texts(Image& image, std::span<const PlacedText> texts)
{
    for (const PlacedText& text : texts) {
        TextStyle style;
        style.height = text.height;
        draw_text(image, text.text, text.at, style);
    }
}

}  // namespace render
