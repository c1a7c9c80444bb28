#pragma once

// Words in a picture: in its corner, and beside the arrows of forces.

#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/scene.hpp"

#include <span>
#include <string>

namespace render {

// `value` in three digits, or in all whole ones: "0.0123", "9.81", "1500". With an exponent from a
// million on, and below a ten-thousandth.
std::string number_text(double value);

// number_text() of `value` with its unit, of which thousands and thousandths get a prefix where
// that is usual: "160 kN", "3.2 MPa", "0.0208 m", "9.81 m/s^2". Metres keep theirs: none.
std::string quantity_text(double value, const std::string& unit);

// Draws `label` in the lower left corner; '\n' parts its lines, which are as large as fit. Where
// not all are read, the last one drawn says how many there are more.
void draw_label(Image& image, const std::string& label);

// Draws each note beside the tip of its arrow, where that lies in the camera's picture, and not on
// the share `right_taken` of its width.
void draw_notes(Image& image, const Camera& camera, std::span<const Note> notes,
                double right_taken = 0);

}  // namespace render
