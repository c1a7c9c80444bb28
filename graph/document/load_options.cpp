#include "graph/document/load_options.hpp"

#include <stdexcept>

#include <fmt/format.h>

namespace graph {

namespace fs = std::filesystem;

Override parse_override(std::string_view text)
{
    const std::size_t equals = text.find('=');
    const std::size_t dot = text.find('.');
    if (equals == std::string_view::npos || dot == std::string_view::npos || dot == 0 ||
        dot + 1 >= equals) {
        throw std::invalid_argument(fmt::format("expected node.parameter=value, found '{}'", text));
    }
    return {std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
}

fs::path project_root(const fs::path& file)
{
    std::error_code error;
    const fs::path full = fs::weakly_canonical(fs::absolute(file, error), error);
    for (fs::path folder = full.parent_path(); !folder.empty(); folder = folder.parent_path()) {
        if (fs::is_directory(folder / "graphs", error) || fs::exists(folder / ".git", error)) {
            return folder;
        }
        if (folder == folder.parent_path()) break;
    }
    return full.parent_path();
}

}  // namespace graph
