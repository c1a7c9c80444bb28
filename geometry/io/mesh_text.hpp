#pragma once

// What text files of meshes have in common.

#include <charconv>
#include <string_view>

namespace geometry {

// As std::from_chars, but a number beyond the range of a double is 0 or infinite.
std::from_chars_result number_from(const char* begin, const char* end, double& value);

// Without the bytes EF BB BF, by which some programs begin a text in UTF-8.
std::string_view without_byte_order_mark(std::string_view text);

}  // namespace geometry
