#pragma once

// Words in a picture: in its corner.

#include "render/image.hpp"

#include <string>

namespace render {

// Three digits of `value` with its unit, of which thousands and thousandths get a prefix where that
// is usual: "160 kN", "3.2 MPa", "0.0208 m", "9.81 m/s^2". Metres keep theirs: none.
std::string quantity_text(double value, const std::string& unit);

// Draws `label` in the lower left corner; '\n' parts its lines, which are as large as fit.
void draw_label(Image& image, const std::string& label);

}  // namespace render
