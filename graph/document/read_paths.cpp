#include "graph/document/read_paths.hpp"

#include "graph/document/frame_path.hpp"

#include <regex>
#include <stdexcept>

#include <fmt/format.h>

namespace graph {

namespace fs = std::filesystem;

namespace {

// Other programs' ways to put the number of the frame into a path: "a.$F4.obj", "a.%04d.obj".
std::string foreign_number(const fs::path& path)
{
    static const std::regex number(R"(\$F+\d*|%0?\d*d(?![a-z]))");
    const std::string name = path.filename().string();
    if (!std::regex_search(name, number)) return {};
    return fmt::format("use {}", std::regex_replace(name, number, "####"));
}

// The frames of a sequence of files, "walk.####.obj"; none for the name of one file.
std::vector<int> sequence(const fs::path& pattern)
{
    std::error_code error;
    const bool numbered = pattern.filename().string().find('#') != std::string::npos;
    if (!numbered || fs::exists(pattern, error)) return {};
    return frames_on_disk(pattern);
}

fs::path file_of_frame(const fs::path& pattern, int frame, int first, int last,
                       const fs::path& root)
{
    const fs::path file = frame_path(pattern, frame);
    std::error_code error;
    if (!fs::is_regular_file(file, error)) {
        throw std::invalid_argument(
            fmt::format("file not found: {}; the sequence has files from frame {} to {}",
                        file.generic_string(), first, last));
    }
    if (!root.empty() && !lies_in(fs::canonical(file), root)) {
        throw std::invalid_argument(fmt::format("{} is outside the project folder {}",
                                                file.generic_string(), root.generic_string()));
    }
    return file;
}

}  // namespace

ParamValue read_path_in(const ParamReading& reading, const Param& param, const Json& json)
{
    if (json.text()->empty()) return {std::string()};
    Problem p = param_problem(reading, json.place());
    const fs::path path = (json.origin->source->folder() / *json.text()).lexically_normal();
    std::error_code error;
    const fs::path real = fs::weakly_canonical(path, error);
    if (!can_be_a_path(*json.text()) || error) {
        p.message = "not a valid path";
        p.found = json.snippet();
        if (!error) p.suggestion = "remove control characters (tabs, line breaks)";
    } else if (!reading.context.paths.allow_outside && !lies_in(real, reading.context.paths.root)) {
        p.message = fmt::format("this path is outside the project folder {}",
                                reading.context.paths.root.generic_string());
        p.found = real == path
                      ? json.snippet()
                      : fmt::format("{}, which is {}", json.snippet(), real.generic_string());
        p.suggestion = "copy the file into the project, or pass --allow-outside";
    } else if (const auto frames = sequence(path); !frames.empty()) {
        Animated a = animated(reading, param, json, -1);
        a.file = [path, first = frames.front(), last = frames.back(),
                  root = reading.context.paths.allow_outside ? fs::path()
                                                             : reading.context.paths.root](
                     int frame) { return file_of_frame(path, frame, first, last, root); };
        reading.node.animated.push_back(std::move(a));
        return {path.generic_string()};
    } else if (!fs::exists(real, error)) {
        p.message = fmt::format("file not found: {}", path.generic_string());
        const std::string numbered = foreign_number(path);
        const bool backslash = json.text()->find('\\') != std::string::npos;
        p.suggestion = backslash          ? "write '/' in place of '\\'"
                       : numbered.empty() ? suggest_file(path)
                                          : numbered;
    } else if (fs::is_directory(real, error)) {
        p.expected = "a file";
        p.found = fmt::format("the folder {}", path.generic_string());
    } else {
        return {path.generic_string()};
    }
    reading.context.problems.add(std::move(p));
    return param.fallback;
}

ParamValue read_path_out(const ParamReading& reading, const Param& param, const Json& json)
{
    const fs::path path = fs::path(*json.text()).lexically_normal();
    const bool leaves = path.is_absolute() || (!path.empty() && *path.begin() == "..");
    if (!can_be_a_path(*json.text())) {
        complain(reading, json.place(), "a path without control characters (tabs, line breaks)",
                 json);
    } else if (leaves && !reading.context.paths.allow_outside) {
        complain(reading, json.place(), "a path inside the output folder", json,
                 "use one without '..' and without '/' at its beginning, or pass --allow-outside");
    } else if (const std::string help = foreign_number(path); !help.empty()) {
        complain(reading, json.place(), "#### for the number of the frame", json, help);
    } else {
        return {path.generic_string()};
    }
    return param.fallback;
}

}  // namespace graph
