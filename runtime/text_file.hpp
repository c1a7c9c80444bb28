#pragma once

#include <filesystem>
#include <string>

namespace runtime {

// Throws std::invalid_argument when it can't be read.
std::string read_text(const std::filesystem::path& file);

// Written beside and renamed, so that a full disk never costs what was there. Throws
// std::runtime_error.
void replace_text(const std::filesystem::path& file, const std::string& text);

}  // namespace runtime
