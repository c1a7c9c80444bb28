#include "graph/document/path_rules.hpp"

#include "graph/document/problem.hpp"

#include <algorithm>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace graph {

bool can_be_a_path(std::string_view text)
{
    return std::none_of(text.begin(), text.end(),
                        [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; });
}

bool lies_in(const std::filesystem::path& path, const std::filesystem::path& root)
{
    const auto [at, end] = std::mismatch(root.begin(), root.end(), path.begin(), path.end());
    return at == root.end() || (at->empty() && std::next(at) == root.end());
}

std::string suggest_file(const std::filesystem::path& path)
{
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path folder = path.parent_path();
    if (!fs::is_directory(folder, error)) {
        return fmt::format("there is no folder {}", folder.generic_string());
    }
    const std::string name = path.filename().string(), stem = path.stem().string();
    std::vector<std::string> files, alike;  // alike: what could be meant, a file of this kind
    std::size_t looked_at = 0;
    for (fs::directory_iterator it(folder, error), end; !error && it != end && ++looked_at < 1000;
         it.increment(error)) {
        const std::string file = it->path().filename().string();
        if (file.starts_with('.')) continue;
        files.push_back(file);
        if (it->path().extension() == path.extension()) alike.push_back(file);
    }
    std::sort(files.begin(), files.end());
    std::sort(alike.begin(), alike.end());
    for (const std::string& file : files) {  // in a folder below
        if (fs::exists(folder / file / name, error)) {
            return fmt::format("did you mean '{}/{}'?", file, name);
        }
    }
    for (const std::string& file : files) {  // the same name in another format
        if (fs::path(file).stem() == stem) return fmt::format("did you mean '{}'?", file);
    }
    const std::vector<std::string>& told = alike.empty() ? files : alike;
    const std::vector<std::string_view> names(told.begin(), told.end());
    return names.empty() ? "the folder is empty" : suggest(name, names);
}

}  // namespace graph
