#pragma once

// Point clouds as text, a line a point: .xyz, .pts, .asc.

#include "geometry/io/import_scene.hpp"

#include <string_view>

namespace geometry {

// The points of a text whose lines begin with x, y and z, apart by spaces, tabs, commas or
// semicolons. A line of 7 numbers or more has red, green and blue (0 to 255) in its last three; so
// has one of 6, where they are whole numbers up to 255. Where a first line names the columns,
// colours are those named r, g, b or red, green, blue, and no others. Names are apart by commas or
// semicolons, or else by spaces, and may be in quotes.
// Other numbers become attributes by these names, or column4, column5 ..., where every line has as
// many; else they are left out with a warning. Numbers of a line after the 64th are left out. Lines
// that are empty, begin with # or //, or hold one number (the count of a .pts) are passed over.
// Throws std::runtime_error naming the line that is anything else.
ImportedScene read_points(std::string_view bytes);

// Whether the ending of `path` is that of such a file.
bool is_points_file(const std::filesystem::path& path);

}  // namespace geometry
