#pragma once

#include <filesystem>
#include <string>

namespace geometry {

// A file that is built and installed with the running program: beside it, one folder above it, or
// in
// ../libexec/aspic. Empty where it is in none of them.
std::filesystem::path beside_program(const std::string& name);

}  // namespace geometry
