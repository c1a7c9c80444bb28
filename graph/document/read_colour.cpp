#include "graph/document/read_colour.hpp"

#include <cctype>
#include <cmath>

namespace graph {

namespace {

double linear_of_srgb(double s)
{
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

}  // namespace

std::optional<std::array<double, 3>> read_colour(const std::string& text)
{
    if ((text.size() != 4 && text.size() != 7) || text[0] != '#') return {};
    const std::size_t digits = (text.size() - 1) / 3;
    std::array<double, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
        int level = 0;
        for (std::size_t d = 0; d < 2; ++d) {
            const char digit = text[1 + c * digits + (digits == 2 ? d : 0)];
            if (!std::isxdigit(static_cast<unsigned char>(digit))) return {};
            const int lower = std::tolower(static_cast<unsigned char>(digit));
            level = 16 * level + (lower <= '9' ? lower - '0' : lower - 'a' + 10);
        }
        rgb[c] = linear_of_srgb(level / 255.0);
    }
    return rgb;
}

}  // namespace graph
