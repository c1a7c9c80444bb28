#pragma once

// Text files, read and written whole.

#include <filesystem>
#include <string>

namespace runtime {

// Throws std::invalid_argument when it can't be read.
std::string read_text(const std::filesystem::path& file);

// A full disk never costs what was there, see whole_file.hpp. Throws std::runtime_error.
void replace_text(const std::filesystem::path& file, const std::string& text);

}  // namespace runtime
