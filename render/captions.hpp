#pragma once

// Words in a picture: in its corner, and beside the arrows of forces.

#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/placed_text.hpp"
#include "render/scene.hpp"

#include <span>
#include <string>
#include <vector>

namespace render {

// `value` in three digits, or in all whole ones: "0.0123", "9.81", "1500". With an exponent from a
// million on, and below a ten-thousandth.
std::string number_text(double value);

// number_text() of `value` with its unit, of which thousands and thousandths get a prefix where
// that is usual: "160 kN", "3.2 MPa", "0.0208 m", "9.81 m/s^2". Metres keep theirs: none.
std::string quantity_text(double value, const std::string& unit);

// The lines of `label`, which '\n' parts, in the lower left corner of a picture and clear of what
// is `taken` there, as large as fit. What is left out of a line shows as "..."; where not all lines
// are there, the last one says how many there are more.
std::vector<PlacedText> place_label(const std::string& label, int width, int height,
                                    std::span<const Area> taken = {});

// Each note beside the tip of its arrow, where that lies in the camera's picture, not on the share
// `right_taken` of its width, and clear of what is `taken` and of the notes before: else above or
// below, by up to five lines. A note without a place is left out.
std::vector<PlacedText> place_notes(const Camera& camera, std::span<const Note> notes, int width,
                                    int height, double right_taken = 0,
                                    std::span<const Area> taken = {});

// The scene's notes, its legend and its label.
void draw_captions(Image& image, const Camera& camera, const Scene& scene);

}  // namespace render
