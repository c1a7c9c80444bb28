#include "graph/frame_path.hpp"

#include <algorithm>
#include <cstdlib>

namespace graph {

std::string frame_text(std::string pattern, int frame)
{
    const std::size_t begin = pattern.find('#');
    if (begin == std::string::npos) return pattern;
    const std::size_t end = std::min(pattern.find_first_not_of('#', begin), pattern.size());
    std::string digits = std::to_string(std::abs(static_cast<long>(frame)));
    if (digits.size() < end - begin) digits.insert(0, end - begin - digits.size(), '0');
    if (frame < 0) digits.insert(0, 1, '-');
    return pattern.replace(begin, end - begin, digits);
}

std::filesystem::path frame_path(const std::filesystem::path& pattern, int frame)
{
    std::filesystem::path path = pattern;
    return path.replace_filename(frame_text(path.filename().string(), frame));
}

}  // namespace graph
