#include "graph/frame_path.hpp"

#include <algorithm>
#include <charconv>
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

std::vector<int> frames_on_disk(const std::filesystem::path& pattern)
{
    const std::string name = pattern.filename().string();
    const std::size_t begin = std::min(name.find('#'), name.size());
    std::vector<int> frames;
    std::error_code error;
    for (std::filesystem::directory_iterator at(pattern.parent_path(), error), end;
         !error && at != end; at.increment(error)) {
        const std::string file = at->path().filename().string();
        int frame = 0;
        const char* const digits = file.data() + std::min(begin, file.size());
        if (std::from_chars(digits, file.data() + file.size(), frame).ec != std::errc()) continue;
        if (frame_text(name, frame) == file) frames.push_back(frame);
    }
    std::sort(frames.begin(), frames.end());
    return frames;
}

std::filesystem::path frame_file(const std::filesystem::path& pattern, const Context& context)
{
    const bool numbered = pattern.filename().string().find('#') != std::string::npos;
    if (!numbered && context.cook && context.cook->frames.size() > 1) {
        std::filesystem::path better = pattern;
        better.replace_extension(".####" + pattern.extension().string());
        throw std::invalid_argument(
            "parameter 'path': " + pattern.string() + " is one file, and each of the " +
            std::to_string(context.cook->frames.size()) +
            " frames of this cook would write over the one before: write " + better.string() +
            ", a file a frame, or cook one frame only (--frames " +
            std::to_string(context.cook->frames.back()) + ")");
    }
    return context.output_folder / frame_path(pattern, context.frame());
}

}  // namespace graph
