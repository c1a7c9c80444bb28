#include "runtime/text_file.hpp"

#include <fmt/format.h>

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
    const std::filesystem::path beside = file.string() + ".new";
    {
        std::ofstream out(beside, std::ios::binary);
        out << text << std::flush;
        if (!out) {
            throw std::runtime_error(fmt::format("{}: can't be written", beside.string()));
        }
    }
    std::filesystem::rename(beside, file);
}

}  // namespace runtime
