#pragma once

// Frames, sizes and times as people write and read them.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace runtime {

// "1-48", "1-48x2", "10,20", and any list of these, ascending and without doubles. Throws
// std::invalid_argument.
std::vector<int> parse_frames(std::string_view text);

// "500M", "2G", "1.5G", "4096" in bytes; K, M, G and T are powers of 1024. Throws
// std::invalid_argument.
std::size_t parse_bytes(std::string_view text);

// 1536 -> "1.5 kB".
std::string format_bytes(double bytes);

// 75 -> "1 min 15 s".
std::string format_seconds(double seconds);

}  // namespace runtime
