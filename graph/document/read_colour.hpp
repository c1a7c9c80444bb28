#pragma once

// Colours by name, "#ff8800".

#include <array>
#include <optional>
#include <string>

namespace graph {

// "#rgb" or "#rrggbb", as on a screen (sRGB), as linear RGB; null for any other text.
std::optional<std::array<double, 3>> read_colour(const std::string& text);

}  // namespace graph
