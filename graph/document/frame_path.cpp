#include "graph/document/frame_path.hpp"

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

std::string why_one_file(const std::filesystem::path& pattern, std::size_t frames)
{
    if (frames < 2 || pattern.filename().string().find('#') != std::string::npos) return {};
    std::filesystem::path better = pattern;
    better.replace_extension(".####" + pattern.extension().string());
    return pattern.string() + " is a single file, but this cook writes " + std::to_string(frames) +
           " frames; use " + better.string() +
           " for one file per frame, or cook one frame (--frames N)";
}

std::filesystem::path frame_file(const std::filesystem::path& pattern, const Context& context)
{
    const std::size_t frames = context.cook ? context.cook->frames.size() : 1;
    if (const std::string why = why_one_file(pattern, frames); !why.empty()) {
        throw std::invalid_argument("parameter 'path': " + why);
    }
    return context.output_folder / frame_path(pattern, context.frame());
}

}  // namespace graph
