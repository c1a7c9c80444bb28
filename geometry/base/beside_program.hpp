#pragma once

// Finds files that are installed with the running program.

#include <filesystem>
#include <string>

namespace geometry {

// The file of this name beside the running program, one folder above it, or in ../libexec/aspic.
// Empty where it is in none of them.
std::filesystem::path beside_program(const std::string& name);

}  // namespace geometry
