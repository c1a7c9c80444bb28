#include "runtime/commands/text_file.hpp"

#include "runtime/cache/whole_file.hpp"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <sstream>

namespace runtime {

std::string read_text(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    if (!in) throw std::invalid_argument(fmt::format("{}: can't be read", file.string()));
    std::ostringstream text;
    text << in.rdbuf();
    return std::move(text).str();
}

void replace_text(const std::filesystem::path& file, const std::string& text)
{
    const std::string_view all = text;
    const Wrote wrote = write_whole_file(file, {&all, 1});
    if (wrote.error == 0) return;
    throw std::runtime_error(
        fmt::format("{}: can't be written ({})", file.string(), std::strerror(wrote.error)));
}

}  // namespace runtime
