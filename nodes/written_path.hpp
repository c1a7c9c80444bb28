#pragma once

// What is wrong with the path of a file that a node is to write: told before anything is cooked.

#include "graph/document/frame_path.hpp"
#include "graph/types/node_type.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

namespace nodes {

// In capitals or not, ".png".
inline bool has_ending(const std::filesystem::path& path, std::string_view ending)
{
    std::string own = path.extension().string();
    std::transform(own.begin(), own.end(), own.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return own == ending;
}

// Faults of the parameter 'path': expected is a file, with one of the endings (any, where none is
// given), and with a # where a cook writes several frames to files of their own.
inline graph::Faults wrong_path(const std::filesystem::path& path,
                                std::initializer_list<std::string_view> endings, int frames_apart)
{
    if (!path.has_filename()) {
        return {{"path", fmt::format("expected the path of a file, found \"{}\"", path.string())}};
    }
    const auto is_its = [&](std::string_view ending) { return has_ending(path, ending); };
    if (endings.size() > 0 && std::none_of(endings.begin(), endings.end(), is_its)) {
        return {{"path", fmt::format("expected a path that ends in {}, found {}",
                                     fmt::join(endings, " or "), path.string())}};
    }
    std::string why = graph::why_one_file(path, static_cast<std::size_t>(frames_apart));
    return why.empty() ? graph::Faults{} : graph::Faults{{"path", std::move(why)}};
}

}  // namespace nodes
