#pragma once

#include <filesystem>
#include <string_view>

namespace geometry {

// Writes `bytes` to `path`, whole or not at all: into a file beside it that is then renamed.
// Missing folders are made. Throws std::runtime_error saying what could not be written and why.
void write_whole_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace geometry
