#pragma once

// The shaders of render/shaders/, built into the program as text.

#include <string_view>

namespace render {

// The text of the file `name` in render/shaders/, built into the program.
// Throws std::logic_error when there is none.
std::string_view shader_text(std::string_view name);

}  // namespace render
