#pragma once

// Files as a whole: read at once, and written so that they are there as a whole or not at all.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace geometry {

// The bytes of a file; none where it cannot be read.
std::optional<std::string> read_whole_file(const std::filesystem::path& path);

// Writes `bytes` to `path`, whole or not at all: into a file without a name (on file systems that
// have none of those, one beside it) that then takes its place. Missing folders are made. Throws
// std::runtime_error saying what could not be written and why.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace geometry
